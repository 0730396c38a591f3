#include "runtime/apps/tremolo/export/nodal_tracks.h"

#include <filesystem>
#include <iterator>
#include <utility>

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

void record_tets(const TetsKind& kind, const Eigen::VectorXd& positions, const AnimatedShape& shape,
                 AnimatedBody& body) {
  const std::vector<Eigen::Vector3d>& rest = shape.surface.vertices;
  std::vector<Eigen::Vector3d> places(rest.size());
  std::vector<Eigen::Vector3f> normals(rest.size());
  kind.surface->place(positions, places, normals);
  const Pose pose = nearest_pose(rest, places);
  for (std::size_t k = 0; k < rest.size(); ++k) {
    const Eigen::Vector3d local = pose.rotation.conjugate() * (places[k] - pose.position);
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      body.displacements.push_back(local[axis] - rest[k][axis]);
  }
  body.poses.push_back(pose);
}

void record_cloth(const ClothParts& parts, const Eigen::VectorXd& x, const AnimatedShape& shape,
                  AnimatedBody& body) {
  const std::vector<Eigen::Vector3d>& rest = shape.surface.vertices;
  const std::vector<VertexId>& sources = shape.surface.sources;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const std::size_t vertex = sources.empty() ? v : static_cast<std::size_t>(sources[v]);
    const auto particle = static_cast<Eigen::Index>(parts.particle_of_vertex(vertex));
    for (int axis = 0; axis < 3; ++axis)
      body.displacements.push_back(x[3 * particle + axis] - rest[v][axis]);
  }
  body.poses.emplace_back();
}

Result<GuestTracks> GuestTracks::create(const WorldGuests& guests) {
  GuestTracks tracks;
  tracks.guests_ = &guests;
  for (const TetsKind& kind : guests.kinds) tracks.shapes_.push_back(tets_shape(kind));
  for (std::size_t i = 0; i < guests.tets(); ++i) {
    AnimatedBody body;
    body.name = guests.guests->name(i);
    body.shape = guests.kind_of[i];
    tracks.bodies_.push_back(std::move(body));
  }
  for (std::size_t i = 0; i < guests.cloths(); ++i) {
    const std::size_t number = guests.of_cloth(i);
    Result<AnimatedShape> shape = cloth_shape(guests.guests->cloth(number)->body().cloth());
    if (!shape) return shape.error();
    AnimatedBody body;
    body.name = guests.guests->name(number);
    body.shape = tracks.shapes_.size();
    tracks.shapes_.push_back(std::move(*shape));
    tracks.bodies_.push_back(std::move(body));
  }
  return tracks;
}

void GuestTracks::record() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    AnimatedBody& body = bodies_[i];
    const AnimatedShape& shape = shapes_[body.shape];
    if (const TetStep* tets = guests_->guests->tets(i)) {
      record_tets(guests_->kind(i), tets->body().positions(), shape, body);
    } else {
      const ClothBody& cloth = guests_->guests->cloth(i)->body();
      record_cloth(cloth.model().parts(), cloth.state().x, shape, body);
    }
  }
}

void GuestTracks::add_to(Animation& animation) {
  for (AnimatedBody& body : bodies_) body.shape += animation.shapes.size();
  std::move(shapes_.begin(), shapes_.end(), std::back_inserter(animation.shapes));
  std::move(bodies_.begin(), bodies_.end(), std::back_inserter(animation.bodies));
}

}  // namespace tremolo
