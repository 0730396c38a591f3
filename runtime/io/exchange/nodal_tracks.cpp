#include "runtime/io/exchange/nodal_tracks.h"

#include <filesystem>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/tets/elements/element_turn.h"

namespace tremolo {

AnimatedShape tets_shape(const TetsKind& kind) {
  const TetsSurface& drawn = kind.surface->rest();
  AnimatedShape shape;
  shape.name = std::filesystem::path(kind.path).stem().string();
  RenderSurface& surface = shape.surface;
  surface.vertices = drawn.vertices;
  surface.triangles = drawn.triangles;
  surface.uvs = drawn.uvs;
  surface.sources = drawn.sources;
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.material_of.assign(surface.triangles.size(), 0);
  surface.objects = surface.materials = {shape.name};
  return shape;
}

Result<AnimatedShape> cloth_shape(const SceneCloth& cloth) {
  const Result<ClothParts> parts = make_cloth_parts(cloth);
  if (!parts) return parts.error();
  AnimatedShape shape;
  shape.name = cloth.name;
  RenderSurface& surface = shape.surface;
  if (parts->drawn != nullptr) {
    surface = *parts->drawn;
    return shape;
  }
  surface.vertices.resize(static_cast<std::size_t>(parts->x.size()) / 3);
  for (std::size_t i = 0; i < surface.vertices.size(); ++i)
    surface.vertices[i] = parts->x.segment<3>(3 * i);
  surface.triangles = parts->triangles;
  surface.uvs = parts->uvs;
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.material_of.assign(surface.triangles.size(), 0);
  surface.objects = surface.materials = {cloth.name};
  return shape;
}

namespace {

Eigen::Vector3d mean_of(const std::vector<Eigen::Vector3d>& places) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& place : places) sum += place;
  return sum / static_cast<double>(places.size());
}

}  // namespace

Pose nearest_pose(const std::vector<Eigen::Vector3d>& rest,
                  const std::vector<Eigen::Vector3d>& places) {
  const Eigen::Vector3d rest_mean = mean_of(rest), mean = mean_of(places);
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i)
    products += (places[i] - mean) * (rest[i] - rest_mean).transpose();
  const Eigen::Matrix3d turn = nearest_rotation(products);
  return {mean - turn * rest_mean, Eigen::Quaterniond(turn).normalized()};
}

Pose tets_frame(const TetsKind& kind, const Eigen::VectorXd& positions, const AnimatedShape& shape,
                std::vector<double>& displacements) {
  const std::vector<Eigen::Vector3d>& rest = shape.surface.vertices;
  std::vector<Eigen::Vector3d> places(rest.size());
  std::vector<Eigen::Vector3f> normals(rest.size());
  kind.surface->place(positions, places, normals);
  const Pose pose = nearest_pose(rest, places);
  for (std::size_t k = 0; k < rest.size(); ++k) {
    const Eigen::Vector3d local = pose.rotation.conjugate() * (places[k] - pose.position);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      displacements.push_back(local[axis] - rest[k][axis]);
  }
  return pose;
}

void cloth_frame(const ClothParts& parts, const Eigen::VectorXd& x, const AnimatedShape& shape,
                 std::vector<double>& displacements) {
  const std::vector<Eigen::Vector3d>& rest = shape.surface.vertices;
  const std::vector<VertexId>& sources = shape.surface.sources;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const std::size_t vertex = sources.empty() ? v : static_cast<std::size_t>(sources[v]);
    const auto particle = static_cast<Eigen::Index>(parts.particle_of_vertex(vertex));
    for (int axis = 0; axis < 3; ++axis)
      displacements.push_back(x[3 * particle + axis] - rest[v][axis]);
  }
}

void record_tets(const TetsKind& kind, const Eigen::VectorXd& positions, const AnimatedShape& shape,
                 AnimatedBody& body) {
  body.poses.push_back(tets_frame(kind, positions, shape, body.displacements));
}

void record_cloth(const ClothParts& parts, const Eigen::VectorXd& x, const AnimatedShape& shape,
                  AnimatedBody& body) {
  cloth_frame(parts, x, shape, body.displacements);
  body.poses.emplace_back();
}

}  // namespace tremolo
