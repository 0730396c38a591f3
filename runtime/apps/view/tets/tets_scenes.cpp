#include "runtime/apps/view/tets/tets_scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/tets/tets_commands.h"
#include "runtime/apps/view/live/live_guests.h"
#include "runtime/apps/view/shape/sheet_geometry.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"
#include "runtime/apps/view/surfaces/surface_window.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

using Eigen::Vector3d;

Result<TetsScenes> TetsScenes::create(TetScene scene) {
  TetsScenes scenes;
  scenes.scene_ = std::move(scene);
  if (Status s = scenes.begin_again(); !s) return s.error();
  return scenes;
}

Status TetsScenes::begin_again() {
  steps_ = 0;
  hold_.reset();
  reports_.resize(scene_.bodies.size());
  return tremolo::take(bodies_, make_tets_bodies(scene_));
}

SceneGravity TetsScenes::gravity() const {
  SceneGravity gravity;
  gravity.times = {0.0};
  gravity.values = {scene_.gravity};
  return gravity;
}

std::vector<ShownSheet> TetsScenes::sheets() const {
  std::vector<ShownSheet> sheets;
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    const TetSurface& surface = *bodies_.kind(i).surface;
    sheets.push_back({scene_.bodies[i].name, surface.rest().triangles, surface.vertices(), true,
                      surface.rest().vertices, surface.rest().uvs, materials_of(bodies_.kind(i))});
  }
  return sheets;
}

std::vector<ShownSolid> TetsScenes::solids() const {
  std::vector<ShownSolid> solids;
  for (const SceneCollider& collider : scene_.colliders)
    solids.push_back({collider.name, 0.0, &collider});
  return solids;
}

void TetsScenes::place(std::size_t sheet, SheetNow& now) const {
  const TetSurface& surface = *bodies_.kind(sheet).surface;
  const TetBody& body = bodies_.group->body(sheet);
  std::vector<Eigen::Vector3d> places(surface.vertices());
  std::vector<Eigen::Vector3f> normals(surface.vertices());
  surface.place(body.positions(), places, normals);
  now.positions.clear();
  now.normals.clear();
  for (const Eigen::Vector3d& x : places)
    now.positions.insert(now.positions.end(), x.begin(), x.end());
  for (const Eigen::Vector3f& n : normals)
    now.normals.insert(now.normals.end(), n.begin(), n.end());
  now.degrees.clear();
  for (const std::uint32_t element : surface.rest().tetrahedra)
    now.degrees.push_back(
        quadratic_share(body.model(), body.model().elements()[element], body.system().degrees()));
}

Status TetsScenes::step() {
  if (hold_) {
    TetHand& hand = hold_->hand;
    hand.velocity = (hold_->goal - hand.point) / scene_.step;
    hand.point = hold_->goal;
    if (Status s = bodies_.group->set_hand(hold_->body, hand); !s) return s;
  }
  if (!bodies_.group->step(reports_))
    for (std::size_t i = 0; i < reports_.size(); ++i)
      if (!reports_[i].converged)
        return Error{ErrorKind::kSolver,
                     fmt::format("{}: body '{}': the step from t = {:.6g} s could not be solved",
                                 scene_.path, scene_.bodies[i].name, time())};
  ++steps_;
  return Success{};
}

std::vector<std::string> TetsScenes::panel_lines() const {
  const TetGroup& group = *bodies_.group;
  double share = 0.0;
  for (std::size_t i = 0; i < group.size(); ++i)
    share += group.body(i).system().quadratic_share() / static_cast<double>(group.size());
  return {fmt::format("{} bodies, {} asleep", group.size(), group.sleeping()),
          fmt::format("{:.0f} % of their edges quadratic", 100.0 * share)};
}

bool TetsScenes::take(const CameraRay& ray) {
  let_go();
  RayHit hit;
  std::size_t body = 0;
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    const TetSurface& surface = *bodies_.kind(i).surface;
    std::vector<Vector3d> at(surface.vertices());
    std::vector<Eigen::Vector3f> normals(surface.vertices());
    surface.place(bodies_.group->body(i).positions(), at, normals);
    const auto place = [&at](VertexId v) { return at[v]; };
    if (find_nearer(ray, surface.rest().triangles, place, hit)) body = i;
  }
  if (!std::isfinite(hit.distance)) return false;
  TetBody& held = bodies_.group->body(body);
  TetHand hand = hand_at(held.model(), bodies_.kind(body).surface->rest(), hit.corner);
  if (!suit_springs(held, hand)) return false;
  hand.point = hand.of(held.positions());
  hold_ = Hold{body, hand, hand.point};
  return true;
}

void TetsScenes::move_to(const Vector3d& point) {
  if (hold_) hold_->goal = point;
}

void TetsScenes::let_go() {
  // The body is one that was taken.
  if (hold_) (void)bodies_.group->set_hand(hold_->body, std::nullopt);
  hold_.reset();
}

std::optional<Vector3d> TetsScenes::hand() const {
  if (!hold_) return std::nullopt;
  return hold_->goal;
}

std::optional<Vector3d> TetsScenes::held() const {
  if (!hold_) return std::nullopt;
  return hold_->hand.of(bodies_.group->body(hold_->body).positions());
}

namespace {

Result<int> view_tets(const ViewerOptions& options, const GivenFlags& flags) {
  if (Status s = refuse_body_flags(options, "tetrahedra"); !s) return s.error();
  const Result<std::string> text = read_whole_file(options.file);
  if (!text) return text.error();
  Result<TetScene> scene = parse_tets_scene(*text, options.file);
  if (!scene) return scene.error();
  if (Status s = apply_tets_flags(flags, "", *scene); !s) return s.error();
  const std::vector<NamedFile> inputs = inputs_of(*scene);
  Result<TetsScenes> scenes = TetsScenes::create(std::move(*scene));
  if (!scenes) return scenes.error();
  return view_surfaces(options, inputs, *scenes);
}

}  // namespace

int view_tets_command(const ViewerOptions& options, const GivenFlags& flags) {
  return end_view(view_tets(options, flags));
}

}  // namespace tremolo
