#include "runtime/bodies/reduced/rigid/rigid_solid.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "common/overflow.h"
#include "common/text.h"
#include "formats/basis/basis_data.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

// Integrals over a solid of density 1: volume, of X, of X X^T.
struct SolidMoments {
  double volume = 0.0;                 // m^3
  Vector3d first = Vector3d::Zero();   // m^4
  Matrix3d second = Matrix3d::Zero();  // m^5

  SolidMoments operator*(double density) const {
    return {density * volume, density * first, density * second};
  }
};

// About the centre, along the shape's axes.
struct MomentsOf {
  SolidMoments operator()(const SphereShape& sphere) const {
    const double r = sphere.radius, volume = 4.0 / 3.0 * kPi * r * r * r;
    return symmetric(volume, Vector3d::Constant(volume * r * r / 5.0));
  }
  SolidMoments operator()(const BoxShape& box) const {
    const double volume = 8.0 * box.half_extents.prod();
    return symmetric(volume, volume / 3.0 * box.half_extents.cwiseAbs2());
  }
  SolidMoments operator()(const CylinderShape& cylinder) const {
    const double r = cylinder.radius, l = cylinder.half_length;
    const double volume = 2.0 * kPi * r * r * l, across = volume * r * r / 4.0;
    return symmetric(volume, {across, across, volume * l * l / 3.0});
  }
  // Two halves of a ball, with the centroid at 3/8 of the radius, at the ends of a cylinder.
  SolidMoments operator()(const CapsuleShape& capsule) const {
    const double r = capsule.radius, l = capsule.half_length;
    const double ball = 4.0 / 3.0 * kPi * r * r * r, middle = 2.0 * kPi * r * r * l;
    const double across = middle * r * r / 4.0 + ball * r * r / 5.0;
    const double along = middle * l * l / 3.0 + ball * (l * l + 0.75 * l * r + r * r / 5.0);
    return symmetric(ball + middle, {across, across, along});
  }
  SolidMoments operator()(const PlaneShape&) const { return {}; }
  SolidMoments operator()(const GridShape&) const { return {}; }

  static SolidMoments symmetric(double volume, const Vector3d& diagonal) {
    return {volume, Vector3d::Zero(), diagonal.asDiagonal()};
  }
};

// Sums over the tetrahedra from the origin to each triangle: int X X^T = V/20 (sum_i x_i x_i^T +
// (sum x)(sum x)^T) for a tetrahedron with one corner at the origin.
SolidMoments moments_of(const SurfaceMesh& surface) {
  SolidMoments sum;
  for (const Triangle& triangle : surface.triangles) {
    const Vector3d &a = surface.vertices[triangle[0]], &b = surface.vertices[triangle[1]],
                   &c = surface.vertices[triangle[2]];
    const double volume = a.dot(b.cross(c)) / 6.0;
    const Vector3d all = a + b + c;
    sum.volume += volume;
    sum.first += volume / 4.0 * all;
    sum.second +=
        volume / 20.0 *
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + all * all.transpose());
  }
  return sum;
}

Status check_positive(const char* key, double value, const char* unit) {
  if (value > 0.0 && std::isfinite(value)) return check_size(key, value, unit);
  return content_error(std::string(key) + " is " + number_text(value) +
                       ", must be positive and finite (" + unit + ")");
}

// Each moment of a solid is positive and smaller than the sum of the two others.
Status check_moments(const Vector3d& moments) {
  const double half = 0.5 * moments.sum();
  for (Eigen::Index k = 0; k < 3; ++k)
    if (!(moments[k] > 0.0) || !(half - moments[k] >= 0.0) || !std::isfinite(moments[k]))
      return content_error(
          "inertia is [" + number_text(moments.x()) + ", " + number_text(moments.y()) + ", " +
          number_text(moments.z()) +
          "]: no solid has these moments; each must be positive, finite and at most the sum of "
          "the two others (kg m^2)");
  return Success{};
}

// A surface that faces inwards is turned.
Result<SurfaceMesh> read_solid(const std::string& path, SolidMoments& moments) {
  Result<SurfaceMesh> surface = read_surface_triangles(path);
  if (!surface) return surface.error();
  if (Status s = check_closed(*surface); !s) return error_of_file(path, s.error());
  moments = moments_of(*surface);
  if (moments.volume < 0.0) {
    for (Triangle& triangle : surface->triangles) std::swap(triangle[1], triangle[2]);
    moments = moments * -1.0;
  }
  const BoundingBox box = bounding_box(surface->vertices);
  if (!(moments.volume > 1e-9 * std::pow((box.high - box.low).maxCoeff(), 3)))
    return error_of_file(path, content_error("the surface encloses no volume"));
  return surface;
}

BasisData data_of(const SurfaceMesh& surface, const SolidMoments& mass) {
  BasisData data;
  data.vertex_count = surface.vertices.size();
  data.rigid_mode_count = 6;
  data.total_mass = mass.volume;
  data.surface.vertex_ids.resize(surface.vertices.size());
  std::iota(data.surface.vertex_ids.begin(), data.surface.vertex_ids.end(), VertexId{0});
  data.surface.rest = surface.vertices;
  const auto rows = static_cast<Eigen::Index>(3 * surface.vertices.size());
  data.surface.rows.resize(rows, 0);
  data.interior.rows.resize(0, 0);
  data.triangles = surface.triangles;
  InertiaIntegrals inertia;
  inertia.mass = mass.volume;
  inertia.first_moment = mass.first;
  inertia.second_moment = mass.second;
  inertia.linear.resize(12, 0);
  inertia.B.resize(9, 0);
  data.inertia = std::move(inertia);
  return data;
}

}  // namespace

Status check(const RigidSolid& solid) {
  if (solid.shape.has_value() == !solid.mesh.empty())
    return content_error("a rigid body has either a shape or a mesh: give one of the two");
  if (solid.shape) {
    if (std::holds_alternative<PlaneShape>(*solid.shape) ||
        std::holds_alternative<GridShape>(*solid.shape))
      return content_error(std::string("shape: a ") + shape_name(*solid.shape) +
                           " is not the solid of a rigid body: use a sphere, capsule, box or "
                           "cylinder, or a mesh");
    if (Status s = check(*solid.shape); !s) return content_error("shape: " + s.error().message);
  }
  if (solid.mass && solid.density)
    return content_error("mass and density: one follows from the other, leave one of them out");
  if (solid.mass)
    if (Status s = check_positive("mass", *solid.mass, "kg"); !s) return s;
  if (solid.density)
    if (Status s = check_positive("density", *solid.density, "kg/m^3"); !s) return s;
  return solid.inertia ? check_moments(*solid.inertia) : Status(Success{});
}

Result<Model::Pointer> make_rigid_model(const RigidSolid& solid, int points) {
  if (Status s = check(solid); !s) return s.error();
  SurfaceMesh surface;
  SolidMoments moments;
  if (solid.shape) {
    surface = surface_of_shape(*solid.shape, points);
    moments = std::visit(MomentsOf{}, *solid.shape);
  } else if (Status s = take(surface, read_solid(solid.mesh, moments)); !s) {
    return s.error();
  }
  const double density =
      solid.mass ? *solid.mass / moments.volume : solid.density.value_or(kUsualDensity);
  SolidMoments mass = moments * density;
  if (solid.inertia) {
    const Vector3d about = Vector3d::Constant(0.5 * solid.inertia->sum()) - *solid.inertia;
    mass.second = about.asDiagonal();
    mass.second += mass.first * mass.first.transpose() / mass.volume;
  }
  if (!(mass.volume > 0.0) || !std::isfinite(mass.volume) || !mass.second.allFinite())
    return content_error("its mass is " + number_text(mass.volume) +
                         " kg, which is not positive and finite: change its size or density");
  return Model::from_data(data_of(surface, mass), {}, solid.shape);
}

}  // namespace tremolo
