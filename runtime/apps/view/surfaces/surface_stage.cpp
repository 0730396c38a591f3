#include "runtime/apps/view/surfaces/surface_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include <Eigen/Geometry>

#include "runtime/apps/view/shape/collider_shape.h"
#include "runtime/apps/view/shape/moved_by.h"
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

Result<std::unique_ptr<SurfaceStage>> SurfaceStage::create(const MovingSurfaces& scenes,
                                                           const ViewSetup& setup,
                                                           const ViewerOptions& options) {
  std::unique_ptr<SurfaceStage> stage(new SurfaceStage());
  stage->colour_ = colour_by(options.colour);
  stage->asked_ = static_cast<float>(stage->colour_ == ColourBy::kStress ? options.stress_full
                                                                         : options.moved_full);
  std::size_t next = 0;
  for (const ShownSheet& shown : scenes.sheets()) stage->add_sheet(shown, setup.paints[next++]);
  if (Status s = stage->add_images(setup.images); !s) return s.error();
  const std::vector<ShownSolid> solids = scenes.solids();
  for (std::size_t i = 0; i < solids.size(); ++i)
    stage->add_solid(solids[i], i, scenes.pose(i), !options.no_colliders, setup.paints, next);
  stage->hand_mesh_ = GpuMesh(ball_shape(kTakenRadius));
  stage->pose(scenes);
  stage->edge_ = stage->coarsest_edge();
  if (stage->has_ground_) return stage;
  stage->ground_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 2; i < stage->points_.size(); i += 3)
    stage->ground_ = std::min(stage->ground_, stage->points_[i]);
  return stage;
}

void SurfaceStage::add_sheet(const ShownSheet& shown, const Vector3f& paint) {
  Sheet& sheet = sheets_.emplace_back();
  sheet.colour = paint;
  sheet.rest = shown.rest;
  sheet.triangles.assign(shown.triangles.begin(), shown.triangles.end());
  sheet.has_degrees = shown.has_degrees;
  sheet.sheet = CreasedSheet(shown.rest, shown.triangles);
  std::vector<std::uint32_t> triangles;
  for (const Triangle& t : sheet.sheet.triangles())
    for (const VertexId v : t) triangles.push_back(static_cast<std::uint32_t>(v));
  sheet.mesh = GpuMesh(triangles, std::vector<float>(3 * sheet.sheet.vertices(), 0.0F));
  if (!shown.materials.empty()) {
    sheet.stress.emplace(shown.rest, shown.triangles, shown.materials);
    if (sheet.stress->empty()) sheet.stress.reset();
  }
  sheet.has_uvs = !shown.uvs.empty();
  if (!sheet.has_uvs) return;
  const std::vector<float> uvs =
      sheet.sheet.spread({shown.uvs.front().data(), 2 * shown.uvs.size()}, 2);
  sheet.mesh.unfold(uvs);
  sheet.tiled = repeats_image(triangles, uvs);
}

// The last image is shown.
Status SurfaceStage::add_images(const std::vector<StageImage>& images) {
  const bool any =
      std::any_of(sheets_.begin(), sheets_.end(), [](const Sheet& sheet) { return sheet.has_uvs; });
  for (const StageImage& image : images) {
    if (!any) return content_error("--texture: no body has texture coordinates");
    if (!image.material.empty())
      return content_error("--texture " + image.material +
                           "=...: the materials of cloths and of tetrahedra have no names: leave "
                           "it out");
    images_.push_back(make_image(image.picture));
  }
  return Success{};
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
    coarsest = std::max(coarsest, mean_edge(sheet.sheet.triangles(), sheet.sheet.positions()));
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
  sheet.sheet.pose(sheet.positions, sheet.normals);
}

bool SurfaceStage::is_numbered(const Sheet& sheet) const {
  return colour_ == ColourBy::kMoved || (colour_ == ColourBy::kStress && sheet.stress) ||
         (colour_ == ColourBy::kDegree && sheet.has_degrees);
}

// The numbers of a sheet that are its colours.
void SurfaceStage::number(Sheet& sheet) {
  if (colour_ == ColourBy::kMoved)
    most_ = std::max(most_, moved_by(sheet.rest, sheet.positions, sheet.numbers));
  else if (colour_ == ColourBy::kStress)
    most_ = std::max(most_, sheet.stress->look(sheet.positions, sheet.numbers));
  else
    sheet.numbers = sheet.now.degrees;
  const std::vector<float> own = sheet.sheet.spread(sheet.numbers, 1);
  sheet.colours.assign(4 * own.size(), 1.0F);
  for (std::size_t v = 0; v < own.size(); ++v) sheet.colours[4 * v] = own[v];
  sheet.mesh.paint(sheet.colours);
}

float SurfaceStage::full() const {
  if (colour_ == ColourBy::kDegree) return 1.0F;
  return asked_ > 0.0F ? asked_ : most_;
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
    sheet.mesh.move(sheet.sheet.positions(), sheet.sheet.normals());
    if (is_numbered(sheet)) number(sheet);
  }
}

const std::vector<DrawnThing>& SurfaceStage::things() {
  things_.clear();
  for (const Sheet& sheet : sheets_) {
    DrawnThing thing;
    thing.mesh = &sheet.mesh;
    thing.count = sheet.mesh.triangles();
    thing.colour = sheet.colour;
    if (!images_.empty() && sheet.has_uvs) {
      thing.paint = Paint::kImage;
      thing.image = images_.back().name();
      thing.tiled = sheet.tiled;
    }
    if (is_numbered(sheet)) thing.paint = Paint::kNumber;
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
