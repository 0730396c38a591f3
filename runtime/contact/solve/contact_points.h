// The contact points of a body: a subset of its boundary's vertices, in groups.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/entry_side.h"
#include "runtime/math/kernels/scattered_field.h"
#include "runtime/model.h"

namespace tremolo {

// Neighbouring points.
struct PointGroup {
  std::size_t first = 0, count = 0;
  // Of a ball around their positions at rest, m, the mesh's coordinates.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;  // of that ball, m
};

// The contact points of a body with r coordinates.
struct ContactPoints {
  std::vector<VertexId> ids;
  std::vector<Eigen::Vector3d> rest;  // m
  // r x 3n: columns 3 i .. 3 i + 2 are the transposed rows of U of point i.
  Eigen::MatrixXd rows;
  ScatteredPoints field;  // the points, for fields through them
  // 3 stride x r: the same rows of U, all x, all y, all z, zero in padding.
  Eigen::MatrixXd axis_rows;
  // r: the largest displacement of any point by a unit of a coordinate: |u| <= sum_i |q_i| reach_i.
  Eigen::VectorXd reach;
  std::vector<PointGroup> groups;
  // The first points of a rigid sphere or capsule are round (contact_law.h): the centre, or points
  // of the axis. They feel what does not deform; the others feel what does.
  std::size_t round = 0;
  double round_radius = 0.0;  // m
  std::vector<double> areas;  // of the boundary nearest to each point, m^2
  double area = 0.0;          // sum of areas, m^2
  // Ball around the boundary and the body's shape, which may extend beyond it (shape_reach.h), m.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  double extent = 0.0;  // longest side of the boundary's box, m
  // Largest distance of a vertex of the boundary from the nearest point, m: smaller obstacles may
  // slip between points.
  double gap = 0.0;

  std::size_t size() const { return rest.size(); }
  bool rigid() const { return rows.rows() == 0; }
  double radius_of(std::size_t i) const { return i < round ? round_radius : 0.0; }
  // True if point i meets an obstacle that is rigid, or that deforms.
  bool meets(std::size_t i, bool rigid_obstacle) const {
    return round == 0 || (i < round) == rigid_obstacle;
  }
  // True if these points need not feel the shape of `other`, whose round points feel this body's.
  bool yield_to(const ContactPoints& other, bool has_shape) const {
    return has_shape && rigid() && round == 0 && other.round != 0;
  }
  // X + U q of point i, m.
  Eigen::Vector3d place(std::size_t i, const Eigen::VectorXd& q) const {
    const Eigen::Index column = 3 * i;
    return rest[i] + rows.middleCols<3>(column).transpose() * q;
  }
  // U q of all points, 3 stride long, m: a field for field_at().
  void displacement(const Eigen::VectorXd& q, Eigen::VectorXd& u) const {
    u.noalias() = axis_rows * q;
  }
};

// Chooses at most `most` of the boundary's vertices, each the farthest from those before it, so
// that gap falls as fast as possible. shape: the shape with which other bodies collide; null: none.
ContactPoints choose_contact_points(const Model& model, std::size_t most,
                                    const Collider* shape = nullptr);

// The same, made once for all bodies of the model that have as many points and as large a shape. It
// may be called on several threads at once.
std::shared_ptr<const ContactPoints> shared_contact_points(const Model::Pointer& model,
                                                           std::size_t most, const Collider* shape);

// The distance of a position from a deformed body (docs/theory.md, section "Contact"). It uses the
// body's shape at rest and a smooth field u through the displacements of its points; of a rigid
// body the distance of the shape itself. The position y of the body's frame is approximately the
// deformed X at rest: X1 = y - u(y), X = y - u(X1).

// A deformed shape. All pointers must outlive it.
struct BentShape {
  const Collider* shape = nullptr;
  const ContactPoints* points = nullptr;
  // U q of the points, same as ContactPoints::displacement(), m.
  const Eigen::VectorXd* u = nullptr;
  EntrySide side = {};  // of the point in question
};

// Buffers for rows, of r rows each.
struct BentScratch {
  Eigen::VectorXd weights;
  Eigen::MatrixX3d first, second;
};

// X.
Eigen::Vector3d bent_rest(const BentShape& bent, const Eigen::Vector3d& y);

// Distance of X from the shape, m, and its gradient by y.
double bent_distance(const BentShape& bent, const Eigen::Vector3d& y);
Eigen::Vector3d bent_gradient(const BentShape& bent, const Eigen::Vector3d& y);

// Derivative of that distance with respect to the coordinates, r: -n.(N(X1) - (grad u)(X1) N(y)), N
// the rows of U. Returns its gradient by y.
Eigen::Vector3d bent_change(const BentShape& bent, const Eigen::Vector3d& y, BentScratch& scratch,
                            Eigen::VectorXd& change);

// The transposed rows R, r x 3, by which the position moves with the coordinates, so that the
// distance changes by gradient.(dy - R^T dq): N(X1) with a correction for the deformation.
void bent_rows(const BentShape& bent, const Eigen::Vector3d& y, BentScratch& scratch,
               Eigen::MatrixX3d& rows);

}  // namespace tremolo
