// A rigid body as a model without coordinates: what moves is the frame alone, with its six degrees
// of freedom. Mass and inertia are exact integrals of the shape or of a closed surface.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/contact/collider.h"
#include "runtime/model.h"

namespace tremolo {

// A rigid body's matter. One of shape and mesh gives its surface.
struct RigidSolid {
  // A sphere, capsule, box or cylinder, about the origin and along z as everywhere.
  std::optional<Collider> shape;
  std::string mesh;               // path of a closed surface, .obj or .ply, m; with it no shape
  std::optional<double> mass;     // kg; with it no density
  std::optional<double> density;  // kg/m^3; without both 1000
  // Moments about the centre of mass along the mesh's axes, kg m^2; none: those of the solid, whose
  // density is uniform.
  std::optional<Eigen::Vector3d> inertia;
};

inline constexpr double kUsualDensity = 1000.0;  // kg/m^3, of a rigid body that gives no mass

// Error kContent, naming key and value: both or none of shape and mesh, a plane or a grid as shape,
// a size, mass or density that is not positive and finite, both mass and density, moments that no
// solid has (each is positive and below the sum of the others).
Status check(const RigidSolid& solid);

// The model. points: the number of contact points, at most that many vertices of a shape's surface
// are chosen so that they are good points. Errors: those of check(); those of
// read_surface_triangles(); kContent for a surface that is not closed, naming an open edge, or one
// without volume.
Result<Model::Pointer> make_rigid_model(const RigidSolid& solid, int points = 200);

// A closed surface of a sphere, capsule, box or cylinder of about `points` vertices, which lie on
// it.
SurfaceMesh surface_of_shape(const Collider& shape, int points);

// Error kContent: an edge of the surface that not exactly two triangles share in opposite
// directions.
Status check_closed(const SurfaceMesh& surface);

}  // namespace tremolo
