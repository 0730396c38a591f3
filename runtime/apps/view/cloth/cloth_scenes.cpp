#include "runtime/apps/view/cloth/cloth_scenes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/cloth/cloth_commands.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/view/live/hand_record.h"
#include "runtime/apps/view/shape/sheet_geometry.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"
#include "runtime/apps/view/surfaces/surface_window.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kRoom = 1.25;  // from a scene to the next, in its width

// The extent of a scene's cloths along x at their start.
std::pair<double, double> extent(const ClothWorld& world) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < world.cloths(); ++i)
    for (Eigen::Index k = 0; k < world.positions(i).size(); k += 3) {
      low = std::min(low, world.positions(i)[k]);
      high = std::max(high, world.positions(i)[k]);
    }
  return {low, high};
}

}  // namespace

Result<ClothFile> read_cloth_file(const std::string& file, const GivenFlags& flags) {
  const Result<std::string> text = read_whole_file(file);
  if (!text) return text.error();
  Result<ClothFile> read = parse_cloths(*text, file);
  if (!read) return read.error();
  if (Status s = apply_cloth_flags(flags, *read); !s) return s.error();
  return read;
}

Result<ClothScenes> ClothScenes::create(std::vector<ClothFile> files) {
  ClothScenes scenes;
  for (ClothFile& file : files) {
    Result<ClothWorld> world = ClothWorld::create(file.scene);
    if (!world) return error_of_file(file.path, value_error(world.error()));
    if (file.scene.options.step != files.front().scene.options.step)
      return content_error(file.path +
                           ": scenes that are seen side by side have one step: say --step");
    scenes.shown_.push_back({file, std::move(*world)});
  }
  scenes.place_beside();
  scenes.list_parts();
  return scenes;
}

void ClothScenes::place_beside() {
  double next = 0.0;
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    const auto [low, high] = extent(shown_[i].world);
    const double width = kRoom * std::max(high - low, 1e-3);
    shown_[i].aside = i == 0 ? Vector3d::Zero() : Vector3d(next - low, 0.0, 0.0);
    next = shown_[i].aside.x() + low + width;
  }
}

void ClothScenes::list_parts() {
  for (std::size_t s = 0; s < shown_.size(); ++s)
    for (std::size_t i = 0; i < shown_[s].world.cloths(); ++i) sheets_.push_back({s, i});
  find_looks();
  for (const bool colliders : {false, true})
    for (std::size_t s = 0; s < shown_.size(); ++s) {
      const ClothScene& scene = shown_[s].file.scene;
      const std::size_t count = colliders ? scene.colliders.size() : scene.balls.size();
      for (std::size_t i = 0; i < count; ++i) solids_.push_back({s, i, colliders});
    }
}

void ClothScenes::find_looks() {
  looks_.clear();
  for (const Part& sheet : sheets_)
    looks_.push_back(look_of(shown_[sheet.scene].world.model(sheet.number).parts()));
}

std::vector<ShownSheet> ClothScenes::sheets() const {
  std::vector<ShownSheet> sheets;
  for (const Part& part : sheets_) {
    const Shown& shown = shown_[part.scene];
    const ClothLook& look = looks_[sheets.size()];
    ShownSheet sheet{shown.file.scene.cloths[part.number].name, look.triangles,
                     look.particles.size()};
    const Eigen::VectorXd& x = shown.world.model(part.number).parts().x;
    for (const std::uint32_t particle : look.particles)
      sheet.rest.emplace_back(x.segment<3>(3 * static_cast<Eigen::Index>(particle)));
    sheet.uvs = look.uvs;
    sheets.push_back(std::move(sheet));
  }
  return sheets;
}

std::vector<ShownSolid> ClothScenes::solids() const {
  std::vector<ShownSolid> solids;
  for (const Part& part : solids_) {
    const ClothScene& scene = shown_[part.scene].file.scene;
    if (part.is_collider)
      solids.push_back({scene.colliders[part.number].name, 0.0, &scene.colliders[part.number]});
    else
      solids.push_back({scene.balls[part.number].name, scene.balls[part.number].radius});
  }
  return solids;
}

void ClothScenes::place(std::size_t sheet, SheetNow& now) const {
  const Shown& shown = shown_[sheets_[sheet].scene];
  const std::size_t cloth = sheets_[sheet].number;
  const Eigen::VectorXd& x = shown.world.positions(cloth);
  spread_to_look<double>(looks_[sheet], {x.data(), static_cast<std::size_t>(x.size())}, 3,
                         now.positions);
  for (std::size_t k = 0; k < now.positions.size(); ++k) now.positions[k] += shown.aside[k % 3];
  // Vertices of one particle on both sides of a seam have one normal.
  if (looks_[sheet].particles.size() == shown.world.particles(cloth)) return;
  particles_.assign(x.begin(), x.end());
  mean_normals(shown.world.triangles(cloth), particles_, normals_);
  spread_to_look<float>(looks_[sheet], normals_, 3, now.normals);
}

Pose ClothScenes::pose(std::size_t solid) const {
  const Part& part = solids_[solid];
  const Shown& shown = shown_[part.scene];
  Pose pose;
  if (part.is_collider) {
    pose = shown.world.collider_pose(part.number);
  } else {
    pose.position = shown.world.balls()[part.number].position;
    pose.rotation = shown.world.balls()[part.number].rotation;
  }
  pose.position += shown.aside;
  return pose;
}

std::vector<std::string> ClothScenes::panel_lines() const {
  std::vector<std::string> lines;
  for (const Shown& shown : shown_) {
    const ClothEnergy energy = shown.world.energy();
    lines.push_back(fmt::format("{}: {}", std::filesystem::path(shown.file.path).stem().string(),
                                shown.world.scene().integrator));
    lines.push_back(fmt::format("  energy {:.4g} J, by the method itself {:.3g} J", energy.total(),
                                energy.numerical));
  }
  return lines;
}

Status ClothScenes::step() {
  if (hand_) {
    ClothWorld& world = shown_[hand_->scene].world;
    if (records_) record_.before_step(world, hand_->cloth, hand_->particle, hand_->way);
    if (Status s = world.hold(hand_->cloth, hand_->particle, hand_->point()); !s) return s;
  }
  for (Shown& one : shown_)
    if (Status s = one.world.step(); !s) return error_of_file(one.file.path, s.error());
  return Success{};
}

Status ClothScenes::begin_again() {
  hand_.reset();
  for (Shown& one : shown_) {
    // With the method and the step that were chosen.
    ClothScene scene = one.file.scene;
    scene.integrator = one.world.scene().integrator;
    scene.options.step = one.world.scene().options.step;
    Result<ClothWorld> world = ClothWorld::create(scene);
    if (!world) return error_of_file(one.file.path, value_error(world.error()));
    one.world = std::move(*world);
  }
  find_looks();
  record_.clear();
  return Success{};
}

std::optional<double> ClothScenes::hand_work() const {
  double work = 0.0;
  for (const Shown& shown : shown_) work += shown.world.energy().pins;
  return work;
}

std::vector<std::string> ClothScenes::chosen() const {
  std::vector<std::string> names;
  for (const Shown& shown : shown_) names.push_back(shown.world.scene().integrator);
  return names;
}

Status ClothScenes::choose(std::size_t scene, std::string_view method) {
  if (records_) return usage_error("the method cannot be changed while a hand is recorded");
  return shown_[scene].world.set_method(method, step_size());
}

Status ClothScenes::set_step_size(double step) {
  if (records_) return usage_error("the step cannot be changed while a hand is recorded");
  for (const Shown& shown : shown_) {
    const auto limit = shown.world.stability_limit_of(shown.world.scene().integrator, step);
    if (!limit) return limit.error();
  }
  for (Shown& shown : shown_)
    if (Status s = shown.world.set_method(shown.world.scene().integrator, step); !s) return s;
  return Success{};
}

Status ClothScenes::record_hand() {
  if (shown_.size() > 1)
    return usage_error("--record-hand applies only to one scene, not to two side by side");
  records_ = true;
  return Success{};
}

Status ClothScenes::write_hand(const std::string& path) {
  const Shown& shown = shown_.front();
  record_.end(shown.world.time());
  if (record_.hands().empty()) {
    tell("tremolo: nothing was pulled: {} is not written\n", path);
    return Success{};
  }
  return write_recorded_cloth(path, shown.file, shown.world.scene(), record_.hands());
}

bool ClothScenes::take(const CameraRay& ray) {
  let_go();
  RayHit hit;
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    const CameraRay into{ray.origin - shown_[i].aside, ray.direction};
    const ClothWorld& world = shown_[i].world;
    for (std::size_t cloth = 0; cloth < world.cloths(); ++cloth) {
      const auto at = [&world, cloth](VertexId v) -> Vector3d {
        return world.positions(cloth).segment<3>(3 * static_cast<Eigen::Index>(v));
      };
      if (find_nearer(into, world.triangles(cloth), at, hit))
        hand_ = Hand{i, cloth, hit.corner, at(static_cast<VertexId>(hit.corner)), Vector3d::Zero()};
    }
  }
  return hand_.has_value();
}

void ClothScenes::move_to(const Vector3d& point) {
  if (hand_) hand_->way = point - shown_[hand_->scene].aside - hand_->begun;
}

void ClothScenes::let_go() {
  // The particle is one that was taken.
  if (hand_) (void)shown_[hand_->scene].world.let_go(hand_->cloth, hand_->particle);
  record_.end(time());
  hand_.reset();
}

std::optional<Vector3d> ClothScenes::hand() const {
  if (!hand_) return std::nullopt;
  return Vector3d(hand_->point() + shown_[hand_->scene].aside);
}

namespace {

Result<int> view_cloth(const ViewerOptions& options, const GivenFlags& flags) {
  if (Status s = refuse_body_flags(options, "cloth"); !s) return s.error();
  if (options.colour == "stress" || options.colour == "degree")
    return usage_error("--colour " + options.colour +
                       " does not apply to cloth, which consists of springs: use body or moved");
  std::vector<ClothFile> files;
  std::vector<NamedFile> inputs;
  for (const std::string& path : {options.file, options.beside}) {
    if (path.empty()) continue;
    Result<ClothFile> file = read_cloth_file(path, flags);
    if (!file) return file.error();
    for (NamedFile& input : inputs_of(*file)) inputs.push_back(std::move(input));
    files.push_back(std::move(*file));
  }
  Result<ClothScenes> scenes = ClothScenes::create(std::move(files));
  if (!scenes) return scenes.error();
  return view_surfaces(options, inputs, *scenes);
}

}  // namespace

int view_cloth_command(const ViewerOptions& options, const GivenFlags& flags) {
  return end_view(view_cloth(options, flags));
}

void ClothHandRecord::before_step(const ClothWorld& world, std::size_t cloth, std::size_t particle,
                                  const Eigen::Vector3d& way) {
  const ClothScene& scene = world.scene();
  if (!std::exchange(holds_, true)) {
    ClothHand taken;
    taken.cloth = scene.cloths[cloth].name;
    taken.particle = world.model(cloth).parts().vertex_of_particle(particle);
    taken.from = world.time();
    taken.motion = hand_motion();
    add_hand_key(taken.motion, world.time(), Eigen::Vector3d::Zero());
    hands_.push_back(std::move(taken));
  }
  add_hand_key(hands_.back().motion, static_cast<double>(world.steps() + 1) * scene.options.step,
               way);
}

void ClothHandRecord::end(double time) {
  if (std::exchange(holds_, false)) hands_.back().until = time;
}

void ClothHandRecord::clear() {
  hands_.clear();
  holds_ = false;
}

Status write_recorded_cloth(const std::string& path, const ClothFile& file, const ClothScene& now,
                            const std::vector<ClothHand>& hands) {
  toml::table table = moved_scene(file.text, file.path, std::filesystem::path(path).parent_path());
  table.insert_or_assign("step", now.options.step);
  table.insert_or_assign("integrator", now.integrator);
  table.insert_or_assign("tolerance", now.options.tolerance);
  table.insert_or_assign("max-iterations", now.options.max_iterations);
  table.insert_or_assign("duration", now.duration);
  std::vector<toml::table> tables;
  for (const ClothHand& hand : hands) {
    toml::table one{{"cloth", hand.cloth},
                    {"at", static_cast<std::int64_t>(hand.particle)},
                    {"from", hand.from}};
    if (hand.until < kForEver) one.insert("until", hand.until);
    one.insert("motion", hand_motion_table(hand.motion));
    tables.push_back(std::move(one));
  }
  return write_scene_with_hands(path, table, tables);
}

}  // namespace tremolo
