#include "runtime/apps/view/stage/stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <variant>

#include <Eigen/Geometry>

#include "runtime/apps/view/shape/collider_shape.h"
#include "runtime/apps/view/shape/creased_shape.h"
#include "runtime/apps/view/shape/moved_by.h"
#include "runtime/apps/view/shape/sheet_geometry.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// sRGB.
constexpr std::uint32_t kColliderColour = 0x9aa4b0, kHandColour = 0xe8c020;
constexpr std::array<float, 4> kMaterialShades = {1.0f, 0.55f, 1.35f, 0.3f};
constexpr float kGlass = 0.22f;          // how much of it is seen
constexpr std::size_t kMostHidden = 64;  // bodies, or vertices of a cloth, that are looked for
constexpr float kGuestGloss = 0.15f;
constexpr double kHandRadius = 0.012;  // of the world's size
constexpr double kPlaneReach = 3.0;    // of the world's size, for a plane that is not the ground
constexpr double kLevel = 0.9998;      // cosine of how far a ground may be out of level

float linear_share(std::uint32_t value) {
  const double x = value / 255.0;
  return static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
}

Eigen::Matrix4f matrix_of(const Pose& pose) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix().cast<float>();
  matrix.topRightCorner<3, 1>() = pose.position.cast<float>();
  return matrix;
}

// A box that grows.
struct GrownBox {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;

  void add(const Vector3d& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  bool empty() const { return !(low[0] <= high[0]); }
};

void add_vertices(const std::vector<float>& positions, const Pose& pose, GrownBox& box) {
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    const Eigen::Map<const Vector3f> x(positions.data() + i);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  if (!(low[0] <= high[0])) return;
  for (int corner = 0; corner < 8; ++corner)
    box.add(pose * Vector3d(corner & 1 ? low[0] : high[0], corner & 2 ? low[1] : high[1],
                            corner & 4 ? low[2] : high[2]));
}

// Colours of vertices; where one is bare it gets the other.
std::vector<float> vertex_paint(const std::vector<Colour>& colours, const Vector3f& bare) {
  std::vector<float> paint;
  for (const Colour& colour : colours)
    for (std::size_t k = 0; k < 4; ++k)
      paint.push_back(k == 3 ? 1.0f : colour[3] == 0 ? bare[k] : linear_share(colour[k]));
  return paint;
}

bool is_level_plane(const Collider& shape, const Pose& pose, UpAxis up) {
  return std::holds_alternative<PlaneShape>(shape) &&
         (pose.rotation * Vector3d::UnitZ()).dot(up_direction(up)) > kLevel;
}

}  // namespace

Vector3f linear_colour(std::uint32_t rgb) {
  return {linear_share(rgb >> 16 & 255U), linear_share(rgb >> 8 & 255U), linear_share(rgb & 255U)};
}

float most_yield(const Collider& solid) {
  if (std::holds_alternative<PlaneShape>(solid)) return 0.0f;
  const BoundingBox box = bounds(solid);
  return static_cast<float>(0.5 * (box.high - box.low).minCoeff());
}

Result<std::unique_ptr<Stage>> Stage::create(const LiveWorld& live, UpAxis up,
                                             const std::vector<Eigen::Vector3f>& paints,
                                             const std::vector<StageImage>& images,
                                             const std::vector<std::optional<Material>>& solids) {
  const SceneWorld& world = live.world();
  std::unique_ptr<Stage> stage(new Stage());
  stage->up_ = up;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (world.body(i).model().drawn().triangles.empty())
      return content_error("body '" + world.name(i) +
                           "': its model has no surface, there is nothing to show");
    stage->add_body(world.name(i), world.body(i), paints[i], solids[i]);
  }
  if (Status s = stage->add_guests(live.guests(), paints); !s) return s.error();
  if (Status s = stage->add_images(images); !s) return s.error();
  const WorldMoment& start = live.now();
  stage->pose_bodies(start);
  for (const StagedBody& body : stage->bodies_)
    if (!body.rest.empty())
      stage->edge_ =
          std::max(stage->edge_, mean_edge(body.sheet.triangles(), body.sheet.positions()));
  GrownBox box;
  for (const StagedBody& body : stage->bodies_) add_vertices(body.positions, body.pose, box);
  if (!box.empty()) stage->size_ = std::max((box.high - box.low).norm(), 1e-9);
  stage->add_colliders(world);
  stage->hand_mesh_ = GpuMesh(ball_shape(kHandRadius * stage->size_));
  stage->pose(start);
  stage->find_ground(live);
  return stage;
}

// A rigid body of an exact shape is drawn by that, not by the points that feel contact.
void Stage::add_rigid(StagedBody& body) {
  const Model& model = *body.model;
  const TriangleShape shape = model.solid() != nullptr
                                  ? collider_shape(*model.solid(), 1.0)
                                  : creased_shape(model.drawn().rest, model.drawn().triangles);
  for (const Vector3f& x : shape.positions)
    body.positions.insert(body.positions.end(), x.begin(), x.end());
  body.is_rigid = true;
  body.mesh = GpuMesh(shape);
  body.ranges = {{0, body.mesh.triangles(), 0}};
}

// A range for each material. order: the triangles as they are drawn.
void Stage::add_ranges(StagedBody& body, const std::vector<std::size_t>& order) {
  const std::vector<std::uint32_t>& materials = body.model->render()->surface.material_of;
  body.ranges.clear();
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t material = materials[order[k]];
    if (body.ranges.empty() || body.ranges.back().material != material)
      body.ranges.push_back({k, 0, material});
    ++body.ranges.back().count;
  }
}

// The mesh of a body that deforms. uvs: of the given vertices, or none.
void Stage::add_mesh(StagedBody& body, const std::vector<Vector3d>& rest,
                     std::span<const Eigen::Vector2f> uvs) {
  std::vector<std::uint32_t> triangles;
  for (const Triangle& triangle : body.sheet.triangles())
    for (const VertexId v : triangle) triangles.push_back(static_cast<std::uint32_t>(v));
  std::vector<float> numbers;
  for (const Vector3d& x : rest)
    for (int k = 0; k < 3; ++k) numbers.push_back(static_cast<float>(x[k]));
  body.mesh = GpuMesh(triangles, body.sheet.spread(numbers, 3));
  body.positions = std::move(numbers);
  body.normals.resize(body.positions.size());
  body.has_uvs = !uvs.empty();
  if (!body.has_uvs) return;
  const std::vector<float> own = body.sheet.spread({uvs.front().data(), 2 * uvs.size()}, 2);
  body.mesh.unfold(own);
  for (MaterialRange& range : body.ranges)
    range.tiled =
        repeats_image(std::span(triangles).subspan(3 * range.first, 3 * range.count), own);
}

void Stage::add_body(const std::string& name, const Body& body, const Vector3f& colour,
                     const std::optional<Material>& solid) {
  const DrawnSurface drawn = body.model().drawn();
  const RenderBlock* render = body.model().render();
  StagedBody& staged = bodies_.emplace_back();
  staged.name = name;
  staged.model = body.model().shared_from_this();
  staged.colour = colour;
  staged.own_frame = body.bones() == 0;
  if (body.model().modes() == 0 && render == nullptr) return add_rigid(staged);
  staged.ranges = {{0, drawn.triangles.size(), 0}};
  if (render == nullptr) {
    staged.sheet = CreasedSheet(drawn.rest, drawn.triangles);
  } else {
    const RenderSurface& surface = render->surface;
    // Sorts the triangles by material.
    std::vector<std::size_t> order(drawn.triangles.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (!surface.material_of.empty())
      std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return surface.material_of[a] < surface.material_of[b];
      });
    std::vector<Triangle> triangles;
    for (const std::size_t t : order) triangles.push_back(drawn.triangles[t]);
    if (!surface.material_of.empty()) add_ranges(staged, order);
    if (surface.normals.empty())
      staged.sheet = CreasedSheet(drawn.rest, triangles, find_smooth_patches(surface).group_of);
    else
      staged.sheet = CreasedSheet::as_given(drawn.rest.size(), triangles);
  }
  add_mesh(staged, drawn.rest,
           render != nullptr ? std::span<const Eigen::Vector2f>(render->surface.uvs)
                             : std::span<const Eigen::Vector2f>());
  if (render != nullptr && !render->surface.colours.empty()) {
    staged.paint = Paint::kVertices;
    staged.own_paint = staged.sheet.spread(vertex_paint(render->surface.colours, colour), 4);
    staged.mesh.paint(staged.own_paint);
  }
  if (solid && staged.own_frame) staged.stress.emplace(drawn.rest, drawn.triangles, *solid);
}

Status Stage::add_images(const std::vector<StageImage>& images) {
  for (const StageImage& image : images) {
    images_.push_back(make_image(image.picture));
    bool used = false;
    for (StagedBody& body : bodies_) {
      if (!body.has_uvs) continue;
      for (MaterialRange& range : body.ranges) {
        // The materials of tetrahedra have no names.
        if (!image.material.empty() &&
            (!body.model ||
             image.material != body.model->render()->surface.materials[range.material]))
          continue;
        range.image = images_.back().name();
        used = true;
      }
    }
    if (!used)
      return content_error(image.material.empty()
                               ? "--texture: no body has texture coordinates"
                               : "--texture " + image.material +
                                     "=...: no body with texture coordinates has a "
                                     "material of that name");
  }
  return Success{};
}

std::vector<std::string> Stage::without_image() const {
  std::vector<std::string> names;
  for (const StagedBody& body : bodies_)
    if (!images_.empty() && !body.has_uvs && !body.is_rigid) names.push_back(body.name);
  return names;
}

void Stage::add_colliders(const SceneWorld& world) {
  for (const PlacedCollider& collider : world.colliders()) {
    StagedCollider staged;
    staged.pose = collider.end;
    staged.solid = collider.shape;
    staged.is_plane = std::holds_alternative<PlaneShape>(collider.shape);
    staged.is_ground = is_level_plane(collider.shape, collider.end, up_);
    staged.yields = std::min(static_cast<float>(edge_), most_yield(collider.shape));
    staged.shape = collider_shape(collider.shape, kPlaneReach * size_);
    staged.mesh = GpuMesh(staged.shape);
    colliders_.push_back(std::move(staged));
  }
}

void Stage::find_ground(const LiveWorld& live) {
  const Vector3d up = up_direction(up_);
  double lowest = std::numeric_limits<double>::infinity();
  for (const StagedBody& body : bodies_)
    for (std::size_t i = 0; i + 2 < body.positions.size(); i += 3)
      lowest = std::min(
          lowest,
          up.dot(body.pose * Eigen::Map<const Vector3f>(body.positions.data() + i).cast<double>()));
  bool catches = false, flies = false;
  for (const StagedCollider& collider : colliders_) {
    catches = catches || collider.is_ground;
    if (collider.is_plane) continue;
    for (const Vector3f& x : collider.shape.positions)
      lowest = std::min(lowest, up.dot(collider.pose * x.cast<double>()));
  }
  for (std::size_t i = 0; i < live.world().size(); ++i)
    flies = flies || live.world().body(i).frame() == FrameKind::kFree;
  for (std::size_t i = 0; i < live.guests().size(); ++i) flies = flies || !live.guests().is_held(i);
  ground_ = std::isfinite(lowest) ? lowest : 0.0;
  has_ground_ = catches || !flies;
  for (const StagedCollider& collider : colliders_)
    if (collider.is_ground) ground_ = up.dot(collider.pose.position);
}

void Stage::pose_bodies(const WorldMoment& moment) {
  most_moved_ = 0.0f;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    StagedBody& body = bodies_[i];
    const BodyMoment& seen = moment.bodies[i];
    body.pose = seen.pose;
    if (body.is_rigid) continue;
    if (!body.own_frame) {
      body.positions = seen.positions;
      body.normals = seen.normals;
      body.degrees = seen.degrees;
      body.sheet.pose(body.positions, body.normals);
      if (!body.rest.empty())
        most_moved_ = std::max(most_moved_, moved_by(body.rest, body.positions, body.distances));
      continue;
    }
    surface_with_normals(body.model->surface_basis(), body.model->drawn().triangles, seen.q,
                         workspace_, body.positions, body.normals);
    body.sheet.pose(body.positions, body.normals);
    const std::vector<Vector3d>& rest = body.model->drawn().rest;
    float most = 0.0f;
    for (std::size_t v = 0; v < rest.size(); ++v)
      most = std::max(
          most, (Eigen::Map<const Vector3f>(body.positions.data() + 3 * v) - rest[v].cast<float>())
                    .squaredNorm());
    most_moved_ = std::max(most_moved_, std::sqrt(most));
  }
}

void Stage::pose(const WorldMoment& moment) {
  pose_bodies(moment);
  for (std::size_t i = 0; i < colliders_.size(); ++i) {
    colliders_[i].pose = moment.colliders[i];
    if (colliders_[i].is_ground) ground_ = up_direction(up_).dot(moment.colliders[i].position);
  }
  hands_ = moment.hands;
  enclose();
}

void Stage::enclose() {
  GrownBox box;
  for (StagedBody& body : bodies_) {
    GrownBox own;
    add_vertices(body.positions, body.pose, own);
    body.middle = 0.5 * (own.low + own.high);
    box.add(own.low);
    box.add(own.high);
  }
  for (const StagedCollider& collider : colliders_) {
    if (collider.is_plane) continue;
    for (const Vector3f& x : collider.shape.positions) box.add(collider.pose * x.cast<double>());
  }
  if (box.empty()) return;
  const Vector3d centre = 0.5 * (box.low + box.high);
  const double radius = std::max(0.505 * (box.high - box.low).norm(), 1e-9);
  // The ball does not shrink: a ball that changes with every picture would make the shadows' edges
  // flicker.
  if (posed_ && (centre - ball_.centre).norm() + radius <= ball_.radius) return;
  ball_.radius = std::max(1.1 * radius, posed_ ? ball_.radius : 0.0);
  ball_.centre = centre;
  posed_ = true;
}

bool Stage::knows_stress() const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [](const StagedBody& body) { return body.stress.has_value(); });
}

void Stage::upload_numbers(StagedBody& body, const std::vector<float>& numbers) {
  const std::vector<float> own = body.sheet.spread(numbers, 1);
  body.number_paint.assign(4 * own.size(), 0.0f);
  for (std::size_t v = 0; v < own.size(); ++v) body.number_paint[4 * v] = own[v];
  body.mesh.paint(body.number_paint);
}

void Stage::upload_stress(StagedBody& body) {
  most_stressed_ = std::max(most_stressed_, body.stress->look(body.positions, body.stresses));
  upload_numbers(body, body.stresses);
}

void Stage::upload(const StageLook& look) {
  most_stressed_ = 0.0f;
  for (StagedBody& body : bodies_) {
    if (!body.is_rigid) body.mesh.move(body.sheet.positions(), body.sheet.normals());
    if (look.colour == ColourBy::kStress && body.stress)
      upload_stress(body);
    else if (const std::vector<float>* numbers = numbers_of(body, look.colour))
      upload_numbers(body, *numbers);
    else if (!body.stresses.empty() && !body.own_paint.empty())
      body.mesh.paint(body.own_paint);
  }
}

void Stage::add_hands(std::vector<DrawnThing>& things) const {
  for (const HandMoment& hand : hands_) {
    if (!hand.holds) continue;
    for (const Vector3d& place : {hand.held, hand.point}) {
      DrawnThing thing;
      thing.mesh = &hand_mesh_;
      thing.count = hand_mesh_.triangles();
      thing.pose.topRightCorner<3, 1>() = place.cast<float>();
      thing.colour = linear_colour(kHandColour);
      thing.shadow = thing.wire = false;
      thing.on_top = true;  // the held vertex may be inside the body
      things.push_back(thing);
    }
  }
}

// The middle of a cloth may be inside what it hangs over, which hides half of it: the collider
// hides a cloth if it hides nine tenths of its vertices.
template <class Hides>
bool Stage::hides_most(const StagedBody& cloth, const Hides& hides) {
  const std::size_t vertices = cloth.positions.size() / 3;
  const std::size_t stride = std::max<std::size_t>(1, vertices / kMostHidden);
  std::size_t hidden = 0, all = 0;
  for (std::size_t v = 0; v < vertices; v += stride, ++all)
    if (hides(Eigen::Map<const Vector3f>(cloth.positions.data() + 3 * v).cast<double>())) ++hidden;
  return 10 * hidden >= 9 * all;
}

bool Stage::hides_a_body(const StagedCollider& collider, const Vector3d& eye) const {
  const auto into = [&collider](const Vector3d& x) {
    return Vector3d(collider.pose.rotation.conjugate() * (x - collider.pose.position));
  };
  const auto hides = [&](const Vector3d& x) {
    return first_hit(collider.solid, into(eye), into(x)).has_value();
  };
  const std::size_t looks = std::min(bodies_.size(), kMostHidden);
  for (std::size_t i = 0; i < looks; ++i)
    if (bodies_[i].is_cloth ? hides_most(bodies_[i], hides) : hides(bodies_[i].middle)) return true;
  return false;
}

void Stage::add_body_things(const StagedBody& body, const StageLook& look) {
  for (const MaterialRange& range : body.ranges) {
    DrawnThing thing;
    thing.mesh = &body.mesh;
    thing.pose = matrix_of(body.pose);
    thing.first = range.first;
    thing.count = range.count;
    thing.colour = body.colour;
    // Materials without an image or colours of their own differ by brightness.
    if (body.ranges.size() > 1)
      thing.colour *= kMaterialShades[range.material % kMaterialShades.size()];
    thing.paint = body.paint;
    thing.image = range.image;
    thing.tiled = range.tiled;
    if (thing.image != 0) thing.paint = Paint::kImage;
    if (look.colour == ColourBy::kMoved && body.own_frame) thing.paint = Paint::kMoved;
    if (look.colour == ColourBy::kStress && body.stress) thing.paint = Paint::kNumber;
    if (!body.rest.empty()) thing.gloss = kGuestGloss;
    if (numbers_of(body, look.colour) != nullptr) thing.paint = Paint::kNumber;
    if (body.is_cloth && !colliders_.empty()) thing.lifted = static_cast<float>(0.5 * edge_);
    things_.push_back(thing);
  }
}

const std::vector<DrawnThing>& Stage::things(const StageLook& look, const Vector3d& eye) {
  things_.clear();
  for (const StagedBody& body : bodies_) add_body_things(body, look);
  for (const StagedCollider& collider : colliders_) {
    if (!look.colliders || collider.is_ground) continue;
    DrawnThing thing;
    thing.mesh = &collider.mesh;
    thing.count = collider.mesh.triangles();
    thing.pose = matrix_of(collider.pose);
    thing.colour = linear_colour(kColliderColour);
    thing.shadow = !collider.is_plane;
    thing.wire = !collider.is_plane;
    thing.gloss = 0.3f;
    thing.yields = collider.yields;
    if (hides_a_body(collider, eye)) {
      thing.glass = kGlass;
      thing.shadow = false;
    }
    things_.push_back(thing);
  }
  // Glass shows only things drawn before it.
  std::stable_partition(things_.begin(), things_.end(),
                        [](const DrawnThing& thing) { return thing.glass == 1.0f; });
  add_hands(things_);
  return things_;
}

std::vector<double> Stage::points() const {
  std::vector<double> points;
  for (const StagedBody& body : bodies_)
    for (std::size_t i = 0; i + 2 < body.positions.size(); i += 3) {
      const Vector3d x =
          body.pose * Eigen::Map<const Vector3f>(body.positions.data() + i).cast<double>();
      points.insert(points.end(), {x[0], x[1], x[2]});
    }
  return points;
}

}  // namespace tremolo
