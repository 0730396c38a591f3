#include "runtime/contact/solve/contact_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <tuple>

#include "common/mesh/refined_surface.h"
#include "runtime/contact/solve/shape_reach.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr std::size_t kGroupSize = 8;
// Of the round points of a capsule: their spacing as a fraction of the radius, and most intervals.
constexpr double kRoundSpacing = 0.25;
constexpr double kMostRoundGaps = 200.0;
// Most vertices inside the triangles of a rigid body, for each contact point.
constexpr std::size_t kMostInner = 10;
// A vertex of the mesh is chosen before one inside a triangle that is farther by this factor.
constexpr double kPreferOwn = 1.5;

// The boundary on which points are chosen. The vertices of a model come first; of a rigid body
// others follow inside its large triangles.
struct Boundary {
  std::vector<Vector3d> places;  // m
  std::vector<Triangle> triangles;
  std::vector<VertexId> origin;   // of each vertex one of the model's
  std::size_t own = 0;            // the number of the model's vertices
  std::vector<Vector3d> normals;  // of length one; empty without vertices inside triangles
  double spacing = 0.0;           // of points that are distributed evenly, m
};

std::vector<Vector3d> normals_of(const SurfaceMesh& mesh) {
  std::vector<Vector3d> normals(mesh.vertices.size(), Vector3d::Zero());
  for (const Triangle& triangle : mesh.triangles) {
    const Vector3d& at = mesh.vertices[triangle[0]];
    const Vector3d area = (mesh.vertices[triangle[1]] - at).cross(mesh.vertices[triangle[2]] - at);
    for (const VertexId vertex : triangle) normals[vertex] += area;
  }
  for (Vector3d& normal : normals) normal.normalize();
  return normals;
}

// A body that deforms is known at its vertices alone.
Boundary boundary_of(const Model& model, std::size_t most) {
  Boundary boundary;
  boundary.places = model.surface().rest;
  boundary.own = boundary.places.size();
  boundary.triangles = model.triangles();
  if (model.modes() == 0) {
    double area = 0.0;
    for (const Triangle& triangle : boundary.triangles) {
      const Vector3d& at = boundary.places[triangle[0]];
      area +=
          0.5 * (boundary.places[triangle[1]] - at).cross(boundary.places[triangle[2]] - at).norm();
    }
    boundary.spacing = std::sqrt(area / static_cast<double>(most));
    if (area > 0.0) {
      RefinedSurface refined = refine_surface({boundary.places, boundary.triangles},
                                              boundary.spacing, kMostInner * most);
      boundary.origin = std::move(refined.origin);
      if (refined.mesh.vertices.size() != boundary.own) boundary.normals = normals_of(refined.mesh);
      boundary.places = std::move(refined.mesh.vertices);
      boundary.triangles = std::move(refined.mesh.triangles);
      return boundary;
    }
  }
  boundary.origin.resize(boundary.own);
  std::iota(boundary.origin.begin(), boundary.origin.end(), VertexId{0});
  return boundary;
}

// Square of a distance between vertices, by which points are chosen, m^2. The two sides of a plate
// are far from each other, however thin it is.
double distance2_of(const Boundary& boundary, std::size_t a, std::size_t b) {
  double distance2 = (boundary.places[a] - boundary.places[b]).squaredNorm();
  if (!boundary.normals.empty())
    distance2 += boundary.spacing * boundary.spacing *
                 (boundary.normals[a] - boundary.normals[b]).squaredNorm();
  return distance2;
}

// Returns indices into the boundary's vertices. gap receives the largest remaining distance;
// nearest receives for each vertex the number of the nearest chosen vertex. The model's own
// vertices, its corners among them, are preferred to those inside triangles.
std::vector<std::size_t> farthest_points(const Boundary& boundary, std::size_t most, double& gap,
                                         std::vector<std::size_t>& nearest) {
  const std::vector<Vector3d>& places = boundary.places;
  nearest.assign(places.size(), 0);
  std::vector<double> distance2(places.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> chosen;
  // The lowest vertex along x is first, so that the choice depends on no other rule.
  const auto own_end = places.begin() + static_cast<std::ptrdiff_t>(boundary.own);
  const auto least = std::min_element(
      places.begin(), own_end, [](const Vector3d& a, const Vector3d& b) { return a.x() < b.x(); });
  std::size_t next = least - places.begin();
  while (chosen.size() < std::min(most, places.size())) {
    chosen.push_back(next);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double from = distance2_of(boundary, i, next);
      if (!(from < distance2[i])) continue;
      distance2[i] = from;
      nearest[i] = chosen.size() - 1;
    }
    const auto inner = distance2.begin() + static_cast<std::ptrdiff_t>(boundary.own);
    const auto own = std::max_element(distance2.begin(), inner);
    const auto inside = std::max_element(inner, distance2.end());
    const bool take_own = inside == distance2.end() || kPreferOwn * kPreferOwn * *own >= *inside;
    next = static_cast<std::size_t>((take_own ? own : inside) - distance2.begin());
    if (distance2[next] == 0.0) break;
  }
  gap = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i)
    gap = std::max(gap, (places[i] - places[chosen[nearest[i]]]).norm());
  return chosen;
}

// Divides along the longest side until groups are small; reorders `order`.
void divide(const std::vector<Vector3d>& places, std::vector<std::size_t>& order, std::size_t first,
            std::size_t last, std::vector<PointGroup>& groups) {
  Vector3d low = places[order[first]], high = low;
  for (std::size_t i = first; i < last; ++i) {
    low = low.cwiseMin(places[order[i]]);
    high = high.cwiseMax(places[order[i]]);
  }
  if (last - first <= kGroupSize) {
    PointGroup group{first, last - first, 0.5 * (low + high), 0.0};
    for (std::size_t i = first; i < last; ++i)
      group.radius = std::max(group.radius, (places[order[i]] - group.centre).norm());
    groups.push_back(group);
    return;
  }
  Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = first + (last - first) / 2;
  const auto at = [&](std::size_t i) { return order.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(middle), at(last),
                   [&](std::size_t a, std::size_t b) { return places[a][axis] < places[b][axis]; });
  divide(places, order, first, middle, groups);
  divide(places, order, middle, last, groups);
}

// The size of the whole boundary: a few points, or a single one, do not show the body's size.
void measure(const std::vector<Vector3d>& boundary, const Collider* shape, ContactPoints& points) {
  const BoundingBox box = bounding_box(boundary);
  points.centre = 0.5 * (box.low + box.high);
  points.extent = (box.high - box.low).maxCoeff();
  for (const Vector3d& x : boundary)
    points.radius = std::max(points.radius, (x - points.centre).norm());
  if (shape != nullptr)
    points.radius = std::max(points.radius, radius_about(*shape, points.centre));
}

// The area of the boundary that is nearest to each of `count` points, m^2. A triangle's area is
// divided among its corners by their angles, so that it does not depend on the diagonal that
// divides a face. A boundary without triangles counts as a ball.
std::vector<double> areas_of(const Boundary& boundary, const std::vector<std::size_t>& nearest,
                             std::size_t count, double extent) {
  const std::vector<Vector3d>& rest = boundary.places;
  std::vector<double> areas(count, 0.0);
  for (const Triangle& triangle : boundary.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d& at = rest[triangle[i]];
      const Vector3d one = rest[triangle[(i + 1) % 3]] - at,
                     other = rest[triangle[(i + 2) % 3]] - at;
      const double twice = one.cross(other).norm();
      const double angle = std::atan2(twice, one.dot(other));
      areas[nearest[triangle[i]]] += 0.5 * twice * angle / std::numbers::pi;
    }
  }
  const double whole = std::accumulate(areas.begin(), areas.end(), 0.0);
  if (!(whole > 0.0))
    std::fill(areas.begin(), areas.end(),
              std::numbers::pi * extent * extent / static_cast<double>(count));
  return areas;
}

// The round points of a rigid body of that shape: positions, and their radius; none for others.
std::vector<Vector3d> round_points(const Collider& shape, double& radius) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) {
    radius = sphere->radius;
    return {Vector3d::Zero()};
  }
  const auto* capsule = std::get_if<CapsuleShape>(&shape);
  if (capsule == nullptr) return {};
  radius = capsule->radius;
  if (capsule->half_length == 0.0) return {Vector3d::Zero()};
  // Between two of them the surface is s^2/(8 radius) too low, 1/128 of the radius.
  const double gaps = std::ceil(2.0 * capsule->half_length / (kRoundSpacing * radius));
  const int count = 1 + static_cast<int>(std::clamp(gaps, 1.0, kMostRoundGaps));
  std::vector<Vector3d> places;
  for (int k = 0; k < count; ++k)
    places.emplace_back(0.0, 0.0, capsule->half_length * (2.0 * k / (count - 1) - 1.0));
  return places;
}

// True if all vertices lie on the shape: it is the solid, and not a stand-in for a mesh.
bool lies_on(const std::vector<Vector3d>& boundary, const Collider& shape, double extent) {
  return std::all_of(boundary.begin(), boundary.end(), [&](const Vector3d& x) {
    return std::abs(signed_distance(shape, x).distance) < 1e-9 * extent;
  });
}

// Puts the round points before the others, which have been chosen.
void add_round_points(const Collider& shape, ContactPoints& points) {
  const std::vector<Vector3d> places = round_points(shape, points.round_radius);
  points.round = places.size();
  if (places.empty()) return;
  for (PointGroup& group : points.groups) group.first += points.round;
  PointGroup group{0, points.round, Vector3d::Zero(), points.round_radius};
  for (const Vector3d& x : places)
    group.radius = std::max(group.radius, x.norm() + points.round_radius);
  points.groups.insert(points.groups.begin(), group);
  points.rest.insert(points.rest.begin(), places.begin(), places.end());
  points.ids.insert(points.ids.begin(), places.size(), points.ids.front());
  points.areas.insert(points.areas.begin(), places.size(),
                      points.area / static_cast<double>(places.size()));
  points.rows.resize(0, static_cast<Index>(3 * points.rest.size()));
}

}  // namespace

ContactPoints choose_contact_points(const Model& model, std::size_t most, const Collider* shape) {
  const VertexBlock& surface = model.surface();
  ContactPoints points;
  std::vector<std::size_t> nearest;
  if (surface.rest.empty() || most == 0) return points;
  const Boundary boundary = boundary_of(model, most);
  const std::vector<std::size_t> chosen = farthest_points(boundary, most, points.gap, nearest);
  std::vector<std::size_t> order = chosen;
  divide(boundary.places, order, 0, order.size(), points.groups);
  const Index r = model.modes();
  points.rows.resize(r, 3 * order.size());
  points.reach.setZero(r);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Index from = 3 * boundary.origin[order[i]];
    const Index to = 3 * i;
    points.ids.push_back(surface.vertex_ids[boundary.origin[order[i]]]);
    points.rest.push_back(boundary.places[order[i]]);
    points.rows.middleCols<3>(to) = surface.rows.middleRows<3>(from).transpose();
    points.reach = points.reach.cwiseMax(points.rows.middleCols<3>(to).rowwise().norm());
  }
  measure(surface.rest, shape, points);
  // Positions near the surface are near several points, and the field is smooth between them.
  points.field = ScatteredPoints(
      points.rest, 0.25 * points.gap * points.gap + 1e-6 * points.extent * points.extent);
  const Index stride = points.field.stride();
  points.axis_rows.setZero(3 * stride, r);
  for (Index i = 0; i < static_cast<Index>(points.size()); ++i)
    for (Index axis = 0; axis < 3; ++axis)
      points.axis_rows.row(axis * stride + i) = points.rows.col(3 * i + axis).transpose();
  const std::vector<double> areas = areas_of(boundary, nearest, chosen.size(), points.extent);
  std::vector<double> area_of(boundary.places.size(), 0.0);
  for (std::size_t k = 0; k < chosen.size(); ++k) area_of[chosen[k]] = areas[k];
  for (const std::size_t vertex : order) points.areas.push_back(area_of[vertex]);
  points.area = std::accumulate(areas.begin(), areas.end(), 0.0);
  if (shape != nullptr && points.rigid() && lies_on(surface.rest, *shape, points.extent))
    add_round_points(*shape, points);
  return points;
}

std::shared_ptr<const ContactPoints> shared_contact_points(const Model::Pointer& model,
                                                           std::size_t most,
                                                           const Collider* shape) {
  // Of the shape the points hold the size of a ball alone; of a rigid body also its round points.
  struct Made {
    std::weak_ptr<const Model> model;
    std::weak_ptr<const ContactPoints> points;
  };
  static std::mutex mutex;
  static std::map<std::tuple<const Model*, std::size_t, double, std::size_t>, Made> made;
  double radius = 0.0;
  if (shape != nullptr) {
    const BoundingBox box = bounding_box(model->surface().rest);
    radius = radius_about(*shape, 0.5 * (box.low + box.high));
  }
  const std::lock_guard hold(mutex);
  const std::size_t kind = shape != nullptr && model->modes() == 0 ? shape->index() + 1 : 0;
  Made& known = made[{model.get(), most, radius, kind}];
  if (auto points = known.points.lock(); points && known.model.lock() == model) return points;
  auto points = std::make_shared<const ContactPoints>(choose_contact_points(*model, most, shape));
  known = {model, points};
  std::erase_if(made, [](const auto& entry) { return entry.second.points.expired(); });
  return points;
}

namespace {

using Eigen::Matrix3d;

// The transposed rows of U at a position, by the field's weights.
void rows_at(const ContactPoints& points, const Vector3d& place, Eigen::VectorXd& weights,
             Eigen::MatrixX3d& rows) {
  field_weights(points.field, place, weights);
  const Index stride = weights.size();
  rows.resize(points.axis_rows.cols(), 3);
  for (Index axis = 0; axis < 3; ++axis)
    rows.col(axis).noalias() =
        points.axis_rows.middleRows(axis * stride, stride).transpose() * weights;
}

// through: (grad u)(X1)^T n, n the shape's normal at X.
struct BentSlope {
  Vector3d rest1, normal, through, gradient;
};

BentSlope bent_slope(const BentShape& bent, const Vector3d& y) {
  const ScatteredPoints& field = bent.points->field;
  BentSlope slope;
  Matrix3d at_y, at_rest1;
  slope.rest1 = y - field_at(field, *bent.u, y, at_y);
  const Vector3d rest = y - field_at(field, *bent.u, slope.rest1, at_rest1);
  slope.normal = distance_by(*bent.shape, bent.side, rest).normal;
  slope.through = at_rest1.transpose() * slope.normal;
  slope.gradient = slope.normal - slope.through + at_y.transpose() * slope.through;
  return slope;
}

}  // namespace

Vector3d bent_rest(const BentShape& bent, const Vector3d& y) {
  if (bent.points->rigid()) return y;
  const ScatteredPoints& field = bent.points->field;
  const Vector3d rest1 = y - field_at(field, *bent.u, y);
  return y - field_at(field, *bent.u, rest1);
}

double bent_distance(const BentShape& bent, const Vector3d& y) {
  return distance_by(*bent.shape, bent.side, bent_rest(bent, y)).distance;
}

Vector3d bent_gradient(const BentShape& bent, const Vector3d& y) {
  if (bent.points->rigid()) return distance_by(*bent.shape, bent.side, y).normal;
  return bent_slope(bent, y).gradient;
}

Vector3d bent_change(const BentShape& bent, const Vector3d& y, BentScratch& scratch,
                     Eigen::VectorXd& change) {
  if (bent.points->rigid()) {
    change.resize(0);
    return bent_gradient(bent, y);
  }
  const BentSlope slope = bent_slope(bent, y);
  rows_at(*bent.points, y, scratch.weights, scratch.first);
  rows_at(*bent.points, slope.rest1, scratch.weights, scratch.second);
  change.noalias() = scratch.first * slope.through - scratch.second * slope.normal;
  return slope.gradient;
}

void bent_rows(const BentShape& bent, const Vector3d& y, BentScratch& scratch,
               Eigen::MatrixX3d& rows) {
  if (bent.points->rigid()) return rows.resize(0, 3);
  const ScatteredPoints& field = bent.points->field;
  Matrix3d at_y, at_rest1;
  const Vector3d rest1 = y - field_at(field, *bent.u, y, at_y);
  field_at(field, *bent.u, rest1, at_rest1);
  rows_at(*bent.points, y, scratch.weights, scratch.first);
  rows_at(*bent.points, rest1, scratch.weights, scratch.second);
  const Matrix3d unit = Matrix3d::Identity();
  const Matrix3d by_y = unit - at_rest1 * (unit - at_y);
  rows.noalias() =
      (scratch.second - scratch.first * at_rest1.transpose()).eval() * by_y.inverse().transpose();
}

}  // namespace tremolo
