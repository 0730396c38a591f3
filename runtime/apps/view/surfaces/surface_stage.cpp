#include "runtime/apps/view/surfaces/surface_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include <Eigen/Geometry>

#include "runtime/apps/view/shape/collider_shape.h"
#include "runtime/apps/view/shape/sheet_geometry.h"
#include "runtime/apps/view/stage/stage.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::uint32_t kScenery = 0x9aa4b0, kTaken = 0xe8c020;  // sRGB
constexpr double kTakenRadius = 0.012;                           // m
constexpr double kPlane = 3.0;                                   // m, of a plane that is no ground
// A wall is an unbounded plane, and transparent.
constexpr float kGlassOfWalls = 0.22F;
// Balls are drawn smaller, so that they do not cross triangles between particles in contact with
// them.
constexpr double kUnder = 0.985;

Eigen::Matrix4f shown_at(const Pose& pose) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix().cast<float>();
  matrix.topRightCorner<3, 1>() = pose.position.cast<float>();
  return matrix;
}

bool is_level(const SceneCollider& collider, const Pose& pose) {
  return std::holds_alternative<PlaneShape>(collider.shape) &&
         (pose.rotation * Vector3d::UnitZ()).z() > 0.9998;
}

}  // namespace

SurfaceStage::SurfaceStage(const MovingSurfaces& scenes, const std::vector<Vector3f>& paints,
                           bool colliders) {
  std::size_t next = 0;
  for (const ShownSheet& shown : scenes.sheets()) {
    Sheet sheet;
    sheet.colour = paints[next++];
    std::vector<std::uint32_t> triangles;
    for (const Triangle& t : shown.triangles)
      for (const VertexId v : t) triangles.push_back(static_cast<std::uint32_t>(v));
    sheet.mesh = GpuMesh(triangles, std::vector<float>(3 * shown.vertices, 0.0F));
    sheet.triangles.assign(shown.triangles.begin(), shown.triangles.end());
    sheet.numbered = shown.numbered;
    sheets_.push_back(std::move(sheet));
  }
  const std::vector<ShownSolid> solids = scenes.solids();
  for (std::size_t i = 0; i < solids.size(); ++i)
    add_solid(solids[i], i, scenes.pose(i), colliders, paints, next);
  hand_mesh_ = GpuMesh(ball_shape(kTakenRadius));
  pose(scenes);
  edge_ = coarsest_edge();
  if (has_ground_) return;
  ground_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 2; i < points_.size(); i += 3) ground_ = std::min(ground_, points_[i]);
}

void SurfaceStage::add_solid(const ShownSolid& shown, std::size_t number, const Pose& pose,
                             bool colliders, const std::vector<Vector3f>& paints,
                             std::size_t& next) {
  Solid solid;
  solid.number = number;
  if (shown.collider == nullptr) {
    solid.radius = shown.radius;
    solid.colour = paints[next++];
    solid.mesh = GpuMesh(ball_shape(kUnder * solid.radius));
  } else {
    if (is_level(*shown.collider, pose)) {
      ground_ = pose.position.z();
      has_ground_ = true;
      return;
    }
    // A file holds distances; the world has them, the scene's values do not.
    if (!colliders || !shown.collider->file.empty()) return;
    solid.is_plane = std::holds_alternative<PlaneShape>(shown.collider->shape);
    solid.most_yield = most_yield(shown.collider->shape);
    yielding_ = yielding_ || !solid.is_plane;
    solid.colour = linear_colour(kScenery);
    solid.mesh = GpuMesh(collider_shape(shown.collider->shape, kPlane));
  }
  solids_.push_back(std::move(solid));
}

double SurfaceStage::coarsest_edge() const {
  double coarsest = 0.0;
  for (const Sheet& sheet : sheets_)
    coarsest = std::max(coarsest, mean_edge(sheet.triangles, sheet.positions));
  return coarsest;
}

void SurfaceStage::pose_sheet(const MovingSurfaces& scenes, std::size_t number) {
  Sheet& sheet = sheets_[number];
  scenes.place(number, sheet.now);
  sheet.positions.assign(sheet.now.positions.begin(), sheet.now.positions.end());
  points_.insert(points_.end(), sheet.now.positions.begin(), sheet.now.positions.end());
  if (sheet.now.normals.empty())
    mean_normals(sheet.triangles, sheet.positions, sheet.normals);
  else
    sheet.normals = sheet.now.normals;
  sheet.colours.assign(4 * sheet.now.numbers.size(), 1.0F);
  for (std::size_t v = 0; v < sheet.now.numbers.size(); ++v)
    sheet.colours[4 * v] = sheet.now.numbers[v];
}

void SurfaceStage::pose_solid(const MovingSurfaces& scenes, Solid& solid) {
  const Pose pose = scenes.pose(solid.number);
  solid.pose = shown_at(pose);
  for (int corner = 0; corner < 8 && solid.radius > 0.0; ++corner)
    for (int k = 0; k < 3; ++k)
      points_.push_back(pose.position[k] + ((corner >> k & 1) != 0 ? solid.radius : -solid.radius));
}

void SurfaceStage::pose(const MovingSurfaces& scenes) {
  points_.clear();
  for (std::size_t i = 0; i < sheets_.size(); ++i) pose_sheet(scenes, i);
  for (Solid& solid : solids_) pose_solid(scenes, solid);
  hand_ = scenes.hand();
  enclose();
}

void SurfaceStage::enclose() {
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

void SurfaceStage::upload() {
  for (Sheet& sheet : sheets_) {
    sheet.mesh.move(sheet.positions, sheet.normals);
    if (sheet.numbered) sheet.mesh.paint(sheet.colours);
  }
}

const std::vector<DrawnThing>& SurfaceStage::things() {
  things_.clear();
  for (const Sheet& sheet : sheets_) {
    DrawnThing thing;
    thing.mesh = &sheet.mesh;
    thing.count = sheet.mesh.triangles();
    thing.colour = sheet.colour;
    if (sheet.numbered) thing.paint = Paint::kNumber;
    thing.gloss = 0.15F;
    if (yielding_) thing.lifted = static_cast<float>(0.5 * edge_);
    things_.push_back(thing);
  }
  for (const Solid& solid : solids_) {
    DrawnThing thing;
    thing.mesh = &solid.mesh;
    thing.count = solid.mesh.triangles();
    thing.pose = solid.pose;
    thing.colour = solid.colour;
    thing.gloss = 0.3F;
    if (solid.is_plane) {
      thing.glass = kGlassOfWalls;
      thing.shadow = thing.wire = false;
    }
    thing.yields = std::min(static_cast<float>(edge_), solid.most_yield);
    things_.push_back(thing);
  }
  // Glass shows only things drawn before it.
  std::stable_partition(things_.begin(), things_.end(),
                        [](const DrawnThing& thing) { return thing.glass == 1.0F; });
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
