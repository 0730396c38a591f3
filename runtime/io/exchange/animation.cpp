#include "runtime/io/exchange/animation.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "runtime/bodies/reduced/bones/skin.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::Vector3d;
using Eigen::VectorXd;

Error bad_shape(const AnimatedShape& shape, const std::string& what) {
  return usage_error("shape '" + shape.name + "': " + what);
}
Error bad_body(const AnimatedBody& body, const std::string& what) {
  return usage_error("body '" + body.name + "': " + what);
}

// One number for each of n, or none at all.
bool all_or_none(std::size_t count, std::size_t n) {
  return count == 0 || count == n;
}

Status check_animated_shape(const AnimatedShape& shape) {
  const RenderSurface& surface = shape.surface;
  const std::size_t vertices = surface.vertices.size(), triangles = surface.triangles.size();
  if (vertices == 0 || triangles == 0) return bad_shape(shape, "it has no triangles");
  if (std::cmp_not_equal(shape.modes.rows(), 3 * vertices) && shape.modes.size() > 0)
    return bad_shape(shape, "the modes have another number of rows than three a vertex");
  if (!all_or_none(surface.uvs.size(), vertices) || !all_or_none(surface.colours.size(), vertices))
    return bad_shape(shape, "not every vertex has texture coordinates or a colour");
  if (!all_or_none(shape.smooth_groups.size(), vertices))
    return bad_shape(shape, "not every vertex is in a group of normals");
  if (surface.material_of.size() != triangles || surface.object_of.size() != triangles)
    return bad_shape(shape, "not every triangle has a material and an object");
  for (const Triangle& triangle : surface.triangles)
    for (const VertexId corner : triangle)
      if (corner < 0 || std::cmp_greater_equal(corner, vertices))
        return bad_shape(shape, "a triangle has the corner " + std::to_string(corner) + " of " +
                                    std::to_string(vertices) + " vertices");
  for (const auto& [list, names] : {std::pair{&surface.material_of, &surface.materials},
                                    std::pair{&surface.object_of, &surface.objects}})
    for (const std::uint32_t index : *list)
      if (index >= names->size()) return bad_shape(shape, "a material or object has no name");
  for (const Vector3d& x : surface.vertices)
    if (!x.allFinite()) return bad_shape(shape, "a vertex is not finite");
  for (const Eigen::Vector2f& uv : surface.uvs)
    if (!uv.allFinite()) return bad_shape(shape, "a texture coordinate is not finite");
  for (const std::uint32_t group : shape.smooth_groups)
    if (group >= vertices) return bad_shape(shape, "a group of normals is out of range");
  if (!shape.modes.allFinite()) return bad_shape(shape, "a mode is not finite");
  return Success{};
}

Status check_animated_body(const Animation& animation, const AnimatedBody& body) {
  if (body.shape >= animation.shapes.size()) return bad_body(body, "it has no shape");
  const AnimatedShape& shape = animation.shape_of(body);
  const std::size_t frames = animation.frames();
  if (body.q.size() != frames * static_cast<std::size_t>(shape.modes.cols()))
    return bad_body(body, "not every frame has all coordinates");
  if (body.poses.size() != frames * body.bones())
    return bad_body(body, "not every frame has a pose for each bone");
  if (!all_or_none(body.bone_names.size(), body.bones()))
    return bad_body(body, "not every bone has a name");
  if (body.weights.cols() > 0 &&
      std::cmp_not_equal(body.weights.rows(), shape.surface.vertices.size()))
    return bad_body(body, "not every vertex has weights of the bones");
  if (const std::string problem = weights_problem(body.weights);
      body.weights.cols() > 0 && !problem.empty())
    return bad_body(body, problem);
  if (!body.displacements.empty() &&
      (body.displacements.size() != 3 * frames * shape.surface.vertices.size() ||
       shape.modes.cols() > 0 || body.weights.cols() > 0))
    return bad_body(body, "not every frame has all displacements, or it has modes or bones too");
  if (!all_or_none(body.shown.size(), frames))
    return bad_body(body, "not every frame says whether it is there");
  for (const double value : body.displacements)
    if (!std::isfinite(value)) return bad_body(body, "a displacement is not finite");
  for (const double value : body.q)
    if (!std::isfinite(value)) return bad_body(body, "a coordinate is not finite");
  for (const Pose& pose : body.poses)
    if (!pose.position.allFinite() || !pose.rotation.coeffs().allFinite() ||
        std::abs(pose.rotation.norm() - 1.0) > 1e-6)
      return bad_body(body, "a pose is not finite, or its rotation not of length one");
  return Success{};
}

VectorXd displacements(const Animation& animation, const AnimatedBody& body, std::size_t frame) {
  const BasisRows& modes = animation.shape_of(body).modes;
  const std::size_t numbers = 3 * animation.shape_of(body).surface.vertices.size();
  if (!body.displacements.empty())
    return Map<const VectorXd>(body.displacements.data() + frame * numbers,
                               static_cast<Index>(numbers));
  if (modes.cols() == 0) return VectorXd::Zero(numbers);
  return modes * coordinates_at(animation, body, frame);
}

std::vector<BoneMap> maps_of(std::span<const Pose> poses) {
  std::vector<BoneMap> maps;
  for (const Pose& pose : poses) maps.push_back(bone_map(pose));
  return maps;
}

}  // namespace

Status check_animation(const Animation& animation) {
  if (animation.bodies.empty()) return usage_error("there is no body to write");
  if (animation.times.empty()) return usage_error("there is no frame to write");
  if (!(animation.rate > 0.0) || !std::isfinite(animation.rate))
    return usage_error("the frames a second must be positive and finite");
  for (std::size_t f = 0; f < animation.frames(); ++f)
    if (!std::isfinite(animation.times[f]) ||
        (f > 0 && animation.times[f] <= animation.times[f - 1]))
      return usage_error("the frames' times do not ascend");
  for (const AnimatedShape& shape : animation.shapes)
    if (Status s = check_animated_shape(shape); !s) return s;
  std::set<std::string> names;
  for (const AnimatedBody& body : animation.bodies) {
    if (body.name.empty() || !names.insert(body.name).second)
      return bad_body(body, "every body needs a name of its own");
    if (Status s = check_animated_body(animation, body); !s) return s;
  }
  return Success{};
}

Status check_all_shown(const std::string& path, const AnimatedBody& body) {
  if (body.shown.empty()) return Success{};
  return usage_error(path + ": body '" + body.name +
                     "' comes or goes within the motion, which .usda, .pvd, .ply, .obj, .html, and "
                     "of a body without bones .glb, can show");
}

double largest_extent(const AnimatedShape& shape) {
  const BoundingBox box = bounding_box(shape.surface.vertices);
  return (box.high - box.low).maxCoeff();
}

namespace {

// The radius of drawn planes: the largest extent of the bodies in all frames, with a margin.
double reach_of(const Animation& animation, const Eigen::Vector3d& centre) {
  double reach = 0.0;
  for (const AnimatedBody& body : animation.bodies) {
    if (body.collider) continue;
    const AnimatedShape& shape = animation.shape_of(body);
    const BoundingBox box = bounding_box(shape.surface.vertices);
    const double size = std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
    for (const Pose& pose : body.poses)
      reach = std::max(reach, (pose.position - centre).norm() + size);
  }
  return 1.25 * reach;
}

}  // namespace

void widen_planes(Animation& animation) {
  for (AnimatedBody& body : animation.bodies) {
    AnimatedShape& shape = animation.shapes[body.shape];
    if (!shape.plane) continue;
    const double reach = reach_of(animation, body.poses[0].position);
    for (Vector3d& x : shape.surface.vertices) x *= reach;
  }
}

Map<const VectorXd> coordinates_at(const Animation& animation, const AnimatedBody& body,
                                   std::size_t frame) {
  const Index r = animation.shape_of(body).modes.cols();
  return {body.q.data() + frame * static_cast<std::size_t>(r), r};
}

std::span<const Pose> poses_at(const AnimatedBody& body, std::size_t frame) {
  return std::span(body.poses).subspan(frame * body.bones(), body.bones());
}

void local_positions(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                     std::span<double> out) {
  const std::vector<Vector3d>& rest = animation.shape_of(body).surface.vertices;
  // Eigen's fixed-size vectors are contiguous.
  Map<VectorXd>(out.data(), static_cast<Index>(out.size())) =
      displacements(animation, body, frame) +
      Map<const VectorXd>(rest[0].data(), static_cast<Index>(3 * rest.size()));
}

void world_positions(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                     std::span<double> out) {
  local_positions(animation, body, frame, out);
  const std::span<const Pose> poses = poses_at(body, frame);
  if (body.weights.cols() > 0) return skin_places(body.weights, maps_of(poses), out);
  const Eigen::Matrix3d turn = poses[0].rotation.toRotationMatrix();
  for (std::size_t i = 0; i + 2 < out.size(); i += 3) {
    Map<Vector3d> x(out.data() + i);
    x = (poses[0].position + turn * x).eval();
  }
}

void world_displacements(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                         std::span<double> out) {
  Map<VectorXd>(out.data(), static_cast<Index>(out.size())) = displacements(animation, body, frame);
  std::vector<BoneMap> maps = maps_of(poses_at(body, frame));
  for (BoneMap& map : maps) map.col(3).setZero();
  if (body.weights.cols() > 0) return skin_places(body.weights, maps, out);
  for (std::size_t i = 0; i + 2 < out.size(); i += 3) {
    Map<Vector3d> u(out.data() + i);
    u = (maps[0].leftCols<3>() * u).eval();
  }
}

Result<double> keep_coordinates(Animation& animation, std::size_t count) {
  if (count == 0) return usage_error("at least one coordinate must be kept");
  double worst = 0.0;
  const std::vector<AnimatedShape> whole = animation.shapes;
  const Index kept = count;
  for (AnimatedShape& shape : animation.shapes)
    if (shape.modes.cols() > kept) shape.modes = BasisRows(shape.modes.leftCols(kept));
  for (AnimatedBody& body : animation.bodies) {
    const BasisRows& modes = whole[body.shape].modes;
    const Index r = modes.cols(), cut = r - kept;
    if (cut <= 0) continue;
    const Map<const Eigen::MatrixXd> q(body.q.data(), r, static_cast<Index>(animation.frames()));
    const double size = largest_extent(whole[body.shape]);
    for (Index frame = 0; frame < q.cols(); ++frame) {
      const VectorXd lost = modes.rightCols(cut) * q.col(frame).tail(cut);
      const double farthest =
          Map<const Eigen::Matrix3Xd>(lost.data(), 3, lost.size() / 3).colwise().norm().maxCoeff();
      worst = std::max(worst, farthest / size);
    }
    const Eigen::MatrixXd head = q.topRows(kept);
    body.q.assign(head.data(), head.data() + head.size());
  }
  return worst;
}

}  // namespace tremolo
