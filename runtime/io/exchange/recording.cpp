#include "runtime/io/exchange/recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include <Eigen/Core>

#include "common/mesh/creases.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/math/dense/decompositions.h"

namespace tremolo {

namespace {

// The exact shape of a round rigid body. The faces of a box are flat by its points, too.
const Collider* round_solid(const Model& model) {
  const Collider* solid = model.solid();
  return solid == nullptr || std::holds_alternative<BoxShape>(*solid) ? nullptr : solid;
}

// Kind and sizes.
std::array<double, 3> sizes_of(const Collider& round) {
  const auto kind = static_cast<double>(round.index());
  if (const auto* sphere = std::get_if<SphereShape>(&round)) return {kind, sphere->radius};
  if (const auto* capsule = std::get_if<CapsuleShape>(&round))
    return {kind, capsule->radius, capsule->half_length};
  const auto& cylinder = std::get<CylinderShape>(round);
  return {kind, cylinder.radius, cylinder.half_length};
}

bool are_alike(const Model& a, const Model& b) {
  return round_solid(a) != nullptr && round_solid(b) != nullptr &&
         sizes_of(*round_solid(a)) == sizes_of(*round_solid(b));
}

}  // namespace

AnimatedShape animated_shape(const Model& model, std::string name) {
  if (const Collider* round = round_solid(model))
    if (std::optional<AnimatedShape> exact = collider_shape(*round, name, 1.0)) {
      exact->modes.resize(3 * std::ssize(exact->surface.vertices), 0);
      return std::move(*exact);
    }
  AnimatedShape shape;
  shape.name = std::move(name);
  const DrawnSurface drawn = model.drawn();
  shape.modes.resize(drawn.rows.rows(), drawn.rows.cols() + drawn.response.cols());
  shape.modes << drawn.rows, drawn.response;
  shape.response_columns = drawn.response.cols();
  if (const RenderBlock* render = model.render()) {
    shape.surface = render->surface;
    shape.smooth_groups = find_smooth_patches(render->surface).group_of;
    return shape;
  }
  if (model.modes() == 0) {
    CreasedSurface creased = split_at_creases(drawn.rest, drawn.triangles);
    for (const VertexId v : creased.vertex_of)
      shape.surface.vertices.push_back(drawn.rest[static_cast<std::size_t>(v)]);
    shape.surface.triangles = std::move(creased.triangles);
    shape.modes.resize(3 * std::ssize(shape.surface.vertices), 0);
    shape.response_columns = 0;
  } else {
    shape.surface.vertices = drawn.rest;
    shape.surface.triangles.assign(drawn.triangles.begin(), drawn.triangles.end());
  }
  shape.surface.object_of.assign(drawn.triangles.size(), 0);
  shape.surface.material_of.assign(drawn.triangles.size(), 0);
  shape.surface.objects = {shape.name};
  shape.surface.materials = {shape.name};
  return shape;
}

Status Recording::add_body(AnimatedBody body) {
  if (has_name(body.name)) return usage_error("two bodies are called '" + body.name + "'");
  if (body.name.empty()) return usage_error("a body needs a name");
  animation_.bodies.push_back(std::move(body));
  frames_.push_back({.late = animation_.frames() > 0});
  return Success{};
}

bool Recording::has_name(const std::string& name) const {
  return std::any_of(animation_.bodies.begin(), animation_.bodies.end(),
                     [&name](const AnimatedBody& body) { return body.name == name; });
}

std::size_t Recording::coordinates(std::size_t track) const {
  if (track >= frames_.size()) return 0;
  const AnimatedShape& shape = animation_.shape_of(animation_.bodies[track]);
  return static_cast<std::size_t>(shape.modes.cols() - shape.response_columns);
}

Result<std::size_t> Recording::add(const Model::Pointer& model, std::string name,
                                   const std::shared_ptr<const Skin>& skin) {
  AnimatedBody body;
  if (skin && skin->bones() > 1) {
    body.weights = skin->drawn;
    body.bone_names = skin->names;
  }
  if (body.weights.cols() > 0 &&
      std::cmp_not_equal(body.weights.rows(), model->drawn().rest.size()))
    return usage_error("body '" + name + "': its skin is of another model");
  auto [place, is_new] = shapes_.try_emplace(model.get(), animation_.shapes.size());
  // Round bodies of one shape share its surface, although each has a model of its own.
  for (std::size_t k = 0; is_new && k < models_.size(); ++k)
    if (are_alike(*models_[k], *model)) place->second = shapes_.at(models_[k].get());
  body.shape = place->second;
  body.name = name;
  if (Status s = add_body(std::move(body)); !s) {
    if (is_new) shapes_.erase(place);
    return s.error();
  }
  if (is_new) models_.push_back(model);
  if (place->second == animation_.shapes.size()) {
    animation_.shapes.push_back(animated_shape(*model, std::move(name)));
  }
  return frames_.size() - 1;
}

Result<std::size_t> Recording::add(const Body& body, std::string name) {
  std::shared_ptr<const Skin> skin;
  if (body.skin() != nullptr) skin = std::make_shared<const Skin>(*body.skin());
  return add(body.model().shared_from_this(), std::move(name), skin);
}

Result<std::size_t> Recording::add(AnimatedShape shape, std::string name) {
  AnimatedBody body;
  body.name = std::move(name);
  body.shape = animation_.shapes.size();
  body.collider = true;
  if (Status s = add_body(std::move(body)); !s) return s.error();
  animation_.shapes.push_back(std::move(shape));
  return frames_.size() - 1;
}

std::size_t Recording::add_shape(AnimatedShape shape) {
  animation_.shapes.push_back(std::move(shape));
  return animation_.shapes.size() - 1;
}

Result<std::size_t> Recording::add_free(std::size_t shape, std::string name) {
  AnimatedBody body;
  body.name = std::move(name);
  body.shape = shape;
  if (shape >= animation_.shapes.size())
    return usage_error("body '" + body.name + "': there is no shape " + std::to_string(shape));
  if (Status s = add_body(std::move(body)); !s) return s.error();
  return frames_.size() - 1;
}

Status Recording::check_whole() const {
  for (std::size_t track = 0; track < frames_.size(); ++track) {
    const Frames& frames = frames_[track];
    if (frames.over || (frames.late && frames.count == 0)) continue;
    if (frames.first + frames.count != animation_.frames())
      return usage_error("body '" + animation_.bodies[track].name +
                         "' is not in the frame at t = " + std::to_string(animation_.times.back()) +
                         " s");
  }
  return Success{};
}

Status Recording::begin_frame(double time) {
  if (Status s = check_whole(); !s) return s;
  if (!std::isfinite(time) || (!animation_.times.empty() && time <= animation_.times.back()))
    return usage_error("a frame's time must be finite and later than the last one's");
  animation_.times.push_back(time);
  return Success{};
}

Status Recording::check_track(std::size_t track) const {
  if (track < frames_.size()) return Success{};
  return usage_error("there are " + std::to_string(frames_.size()) + " tracks, no track " +
                     std::to_string(track));
}

Status Recording::begin_record(std::size_t track, std::size_t poses) const {
  if (Status s = check_track(track); !s) return s;
  const AnimatedBody& body = animation_.bodies[track];
  const Frames& frames = frames_[track];
  if (frames.over) return usage_error("body '" + body.name + "': its track has ended");
  const bool begun = frames.count > 0 || !frames.late;
  if (animation_.frames() == 0 || (begun && frames.first + frames.count >= animation_.frames()))
    return usage_error("body '" + body.name + "': begin a frame first, which it is not in yet");
  if (poses != body.bones())
    return usage_error("body '" + body.name + "': it has " + std::to_string(body.bones()) +
                       " frames, not " + std::to_string(poses));
  return Success{};
}

void Recording::end_record(std::size_t track) {
  Frames& frames = frames_[track];
  if (frames.count == 0) frames.first = animation_.frames() - 1;
  ++frames.count;
}

Status Recording::record(std::size_t track, std::span<const double> q,
                         std::span<const Pose> poses) {
  if (Status s = begin_record(track, poses.size()); !s) return s;
  AnimatedBody& body = animation_.bodies[track];
  const AnimatedShape& shape = animation_.shape_of(body);
  const Eigen::Index modes = shape.modes.cols() - shape.response_columns;
  if (std::cmp_not_equal(q.size(), modes) && std::cmp_not_equal(q.size(), shape.modes.cols()))
    return usage_error("body '" + body.name + "': it has " + std::to_string(modes) +
                       " coordinates, not " + std::to_string(q.size()));
  for (const double value : q)
    if (!std::isfinite(value))
      return usage_error("body '" + body.name + "': a coordinate is not finite");
  body.q.insert(body.q.end(), q.begin(), q.end());
  body.q.resize(body.q.size() + static_cast<std::size_t>(shape.modes.cols()) - q.size(), 0.0);
  body.poses.insert(body.poses.end(), poses.begin(), poses.end());
  end_record(track);
  return Success{};
}

Status Recording::record_free(std::size_t track, std::span<const double> displacements,
                              const Pose& pose) {
  if (Status s = begin_record(track, 1); !s) return s;
  AnimatedBody& body = animation_.bodies[track];
  const std::size_t numbers = 3 * animation_.shape_of(body).surface.vertices.size();
  if (displacements.size() != numbers)
    return usage_error("body '" + body.name + "': it has " + std::to_string(numbers) +
                       " displacements, not " + std::to_string(displacements.size()));
  body.displacements.insert(body.displacements.end(), displacements.begin(), displacements.end());
  body.poses.push_back(pose);
  end_record(track);
  return Success{};
}

Status Recording::end(std::size_t track) {
  if (Status s = check_track(track); !s) return s;
  frames_[track].over = true;
  return Success{};
}

Status Recording::record(std::size_t track, const Body& body) {
  poses_.clear();
  for (std::size_t b = 0; b < body.bones(); ++b) poses_.push_back(body.pose(b));
  if (body.bones() < 2) poses_.assign(1, body.pose());
  const Eigen::VectorXd& q = body.shown();
  return record(track, {q.data(), static_cast<std::size_t>(q.size())}, poses_);
}

namespace {

// Puts copies of the first frame before `first` and of the last one behind.
template <class Value>
void fill_around(std::vector<Value>& values, std::size_t first, std::size_t count,
                 std::size_t frames) {
  const std::size_t width = values.size() / count;
  std::vector<Value> whole;
  whole.reserve(width * frames);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const std::size_t from = std::clamp(frame, first, first + count - 1) - first;
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(from * width);
    whole.insert(whole.end(), begin, begin + static_cast<std::ptrdiff_t>(width));
  }
  values = std::move(whole);
}

void fill_frames(AnimatedBody& body, std::size_t first, std::size_t count, std::size_t frames) {
  fill_around(body.q, first, count, frames);
  fill_around(body.poses, first, count, frames);
  fill_around(body.displacements, first, count, frames);
  body.shown.assign(frames, 0);
  std::fill_n(body.shown.begin() + static_cast<std::ptrdiff_t>(first), count, std::uint8_t{1});
}

}  // namespace

Result<Animation> Recording::animation() const {
  if (Status s = check_whole(); !s) return s.error();
  Animation whole = animation_;
  whole.bodies.clear();
  for (std::size_t track = 0; track < frames_.size(); ++track) {
    const Frames& frames = frames_[track];
    if (frames.count == 0 && (frames.late || frames.over)) continue;
    whole.bodies.push_back(animation_.bodies[track]);
    if (frames.count < whole.frames())
      fill_frames(whole.bodies.back(), frames.first, frames.count, whole.frames());
  }
  if (Status s = check_animation(whole); !s) return s.error();
  return whole;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The squares of singular values resolve no smaller ones.
constexpr double kLeastSquare = 1e-13;

double farthest(const MatrixXd& rest) {
  double most = 0.0;
  for (Index frame = 0; frame < rest.cols(); ++frame)
    for (Index k = 0; k < rest.rows(); k += 3)
      most = std::max(most, rest.col(frame).segment<3>(k).squaredNorm());
  return std::sqrt(most);
}

// Leaves the body's shape with modes and q; the largest distance that is left, m.
double describe(AnimatedShape& shape, AnimatedBody& body, Index most, double enough) {
  const Index rows = 3 * shape.surface.vertices.size();
  const auto frames = static_cast<Index>(body.displacements.size()) / rows;
  const Eigen::Map<const MatrixXd> motion(body.displacements.data(), rows, frames);
  MatrixXd products = MatrixXd::Zero(frames, frames);
  products.selfadjointView<Eigen::Lower>().rankUpdate(motion.transpose());
  const SymmetricEigen solver = symmetric_eigen(products);
  const double largest = solver.values[frames - 1];
  MatrixXd left = motion, modes(rows, std::min(most, frames));
  Index count = 0;
  double off = farthest(left);
  while (count < modes.cols() && off > enough) {
    const Index k = frames - 1 - count;
    if (!(solver.values[k] > kLeastSquare * largest)) break;
    modes.col(count) = motion * solver.vectors.col(k);
    modes.col(count).normalize();
    // Coordinates of the residual, not of the whole motion: the next mode corrects the rounding of
    // this one.
    const VectorXd shares = left.transpose() * modes.col(count);
    left.noalias() -= modes.col(count) * shares.transpose();
    off = farthest(left);
    ++count;
  }
  shape.modes = modes.leftCols(count);
  const MatrixXd q = shape.modes.transpose() * motion;
  off = farthest(motion - shape.modes * q);
  body.q.assign(q.data(), q.data() + q.size());
  body.displacements.clear();
  return off;
}

}  // namespace

Result<double> describe_by_modes(Animation& animation, std::size_t most, double enough) {
  if (Status s = check_animation(animation); !s) return s.error();
  double worst = 0.0;
  for (AnimatedBody& body : animation.bodies) {
    if (body.displacements.empty()) continue;
    const bool shared =
        std::count_if(animation.bodies.begin(), animation.bodies.end(),
                      [&body](const AnimatedBody& other) { return other.shape == body.shape; }) > 1;
    if (shared) {
      animation.shapes.push_back(animation.shapes[body.shape]);
      animation.shapes.back().name = body.name;
      body.shape = animation.shapes.size() - 1;
    }
    AnimatedShape& shape = animation.shapes[body.shape];
    const double size = std::max(largest_extent(shape), 1e-300);
    worst = std::max(worst, describe(shape, body, static_cast<Index>(most), enough * size) / size);
  }
  return worst;
}

}  // namespace tremolo
