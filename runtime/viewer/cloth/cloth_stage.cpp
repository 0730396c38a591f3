#include "runtime/viewer/cloth/cloth_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include <Eigen/Geometry>

#include "runtime/viewer/shape/collider_shape.h"
#include "runtime/viewer/stage/stage.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::uint32_t kScenery = 0x9aa4b0, kTaken = 0xe8c020;  // sRGB
constexpr double kTakenRadius = 0.012;                           // m
constexpr double kPlane = 3.0;                                   // m, of a plane that is no ground
// Balls are drawn smaller, so that triangles between particles that lie on one do not cross it.
constexpr double kUnder = 0.985;

Eigen::Matrix4f shown_at(const Pose& pose, const Vector3d& aside) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix().cast<float>();
  matrix.topRightCorner<3, 1>() = (pose.position + aside).cast<float>();
  return matrix;
}

bool is_level(const SceneCollider& collider) {
  return std::holds_alternative<PlaneShape>(collider.shape) &&
         (collider.pose.rotation * Vector3d::UnitZ()).z() > 0.9998;
}

}  // namespace

ClothStage::ClothStage(const ClothScenes& scenes, const std::vector<Vector3f>& paints,
                       bool colliders) {
  std::size_t next = 0;
  for (std::size_t s = 0; s < scenes.shown().size(); ++s) {
    const ClothWorld& world = scenes.shown()[s].world;
    for (std::size_t i = 0; i < world.cloths(); ++i) {
      Sheet sheet;
      sheet.scene = s;
      sheet.cloth = i;
      sheet.colour = paints[next++];
      std::vector<std::uint32_t> triangles;
      for (const Triangle& t : world.triangles(i))
        for (const VertexId v : t) triangles.push_back(static_cast<std::uint32_t>(v));
      const std::vector<float> rest(static_cast<std::size_t>(world.positions(i).size()), 0.0F);
      sheet.mesh = GpuMesh(triangles, rest);
      sheets_.push_back(std::move(sheet));
    }
    add_solids(scenes, s, colliders, paints, next);
  }
  hand_mesh_ = GpuMesh(ball_shape(kTakenRadius));
  pose(scenes);
  if (has_ground_) return;
  ground_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 2; i < points_.size(); i += 3) ground_ = std::min(ground_, points_[i]);
}

void ClothStage::add_solids(const ClothScenes& scenes, std::size_t scene, bool colliders,
                            const std::vector<Vector3f>& paints, std::size_t& next) {
  const ClothScene& of = scenes.shown()[scene].file.scene;
  for (std::size_t i = 0; i < of.balls.size(); ++i) {
    Solid solid;
    solid.scene = scene;
    solid.number = i;
    solid.is_ball = true;
    solid.radius = of.balls[i].radius;
    solid.colour = paints[next++];
    solid.mesh = GpuMesh(ball_shape(kUnder * solid.radius));
    solids_.push_back(std::move(solid));
  }
  for (std::size_t i = 0; i < of.colliders.size(); ++i) {
    const SceneCollider& collider = of.colliders[i];
    if (is_level(collider)) {
      ground_ = collider.pose.position.z();
      has_ground_ = true;
      continue;
    }
    // A file holds distances; the world has them, the scene's values do not.
    if (!colliders || !collider.file.empty()) continue;
    Solid solid;
    solid.scene = scene;
    solid.number = i;
    solid.colour = linear_colour(kScenery);
    solid.mesh = GpuMesh(collider_shape(collider.shape, kPlane));
    solids_.push_back(std::move(solid));
  }
}

void ClothStage::pose_sheet(const ClothScenes& scenes, Sheet& sheet) {
  const ClothScenes::Shown& shown = scenes.shown()[sheet.scene];
  const Eigen::VectorXd& x = shown.world.positions(sheet.cloth);
  const auto size = static_cast<std::size_t>(x.size());
  sheet.positions.resize(size);
  for (std::size_t k = 0; k < size; ++k) {
    const double at =
        x[static_cast<Eigen::Index>(k)] + shown.aside[static_cast<Eigen::Index>(k % 3)];
    sheet.positions[k] = static_cast<float>(at);
    points_.push_back(at);
  }
  // The mean of the triangles' normals, by their areas.
  sheet.normals.assign(size, 0.0F);
  const auto at = [](std::vector<float>& list, VertexId v) {
    return Eigen::Map<Vector3f>(list.data() + 3 * static_cast<std::size_t>(v));
  };
  for (const Triangle& t : shown.world.triangles(sheet.cloth)) {
    const Vector3f a = at(sheet.positions, t[0]), b = at(sheet.positions, t[1]),
                   c = at(sheet.positions, t[2]);
    const Vector3f normal = (b - a).cross(c - a);
    for (const VertexId v : t) at(sheet.normals, v) += normal;
  }
  for (std::size_t k = 0; k < size; k += 3)
    Eigen::Map<Vector3f>(sheet.normals.data() + k).normalize();
}

void ClothStage::pose_solid(const ClothScenes& scenes, Solid& solid) {
  const ClothScenes::Shown& shown = scenes.shown()[solid.scene];
  Pose pose;
  if (solid.is_ball) {
    const ClothWorld::Ball& ball = shown.world.balls()[solid.number];
    pose.position = ball.position;
    pose.rotation = ball.rotation;
    for (int corner = 0; corner < 8; ++corner)
      for (int k = 0; k < 3; ++k)
        points_.push_back(ball.position[k] + shown.aside[k] +
                          ((corner >> k & 1) != 0 ? solid.radius : -solid.radius));
  } else {
    pose = shown.world.collider_pose(solid.number);
  }
  solid.pose = shown_at(pose, shown.aside);
}

void ClothStage::pose(const ClothScenes& scenes) {
  points_.clear();
  for (Sheet& sheet : sheets_) pose_sheet(scenes, sheet);
  for (Solid& solid : solids_) pose_solid(scenes, solid);
  hand_ = scenes.hand();
  enclose();
}

void ClothStage::enclose() {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i + 2 < points_.size(); i += 3) {
    const Eigen::Map<const Vector3d> x(points_.data() + i);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const Vector3d centre = 0.5 * (low + high);
  const double radius = std::max(0.505 * (high - low).norm(), 1e-9);
  if (posed_ && (centre - ball_.centre).norm() + radius <= ball_.radius) return;
  ball_.radius = std::max(1.1 * radius, posed_ ? ball_.radius : 0.0);
  ball_.centre = centre;
  posed_ = true;
}

void ClothStage::upload() {
  for (Sheet& sheet : sheets_) sheet.mesh.move(sheet.positions, sheet.normals);
}

const std::vector<DrawnThing>& ClothStage::things() {
  things_.clear();
  for (const Sheet& sheet : sheets_) {
    DrawnThing thing;
    thing.mesh = &sheet.mesh;
    thing.count = sheet.mesh.triangles();
    thing.colour = sheet.colour;
    thing.gloss = 0.15F;
    things_.push_back(thing);
  }
  for (const Solid& solid : solids_) {
    DrawnThing thing;
    thing.mesh = &solid.mesh;
    thing.count = solid.mesh.triangles();
    thing.pose = solid.pose;
    thing.colour = solid.colour;
    thing.gloss = 0.3F;
    things_.push_back(thing);
  }
  if (!hand_) return things_;
  DrawnThing thing;
  thing.mesh = &hand_mesh_;
  thing.count = hand_mesh_.triangles();
  thing.pose.topRightCorner<3, 1>() = hand_->cast<float>();
  thing.colour = linear_colour(kTaken);
  thing.shadow = thing.wire = false;
  thing.on_top = true;
  things_.push_back(thing);
  return things_;
}

}  // namespace tremolo
