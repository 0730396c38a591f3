// The points of a body that feel contact: a subset of its boundary's vertices, in groups.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "runtime/contact/collider.h"
#include "runtime/kernels/scattered_field.h"
#include "runtime/model.h"

namespace tremolo {

// Neighbours, whose rest places lie within `radius` (m) of `centre` (m, the mesh's coordinates).
struct PointGroup {
  std::size_t first = 0, count = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
};

// rest: m. rows: r x 3n, columns 3 i .. 3 i + 2 are the transposed rows of U of point i. field: the
// points for fields through them; axis_rows: 3 stride x r, the same rows of U, all x, all y, all z,
// zero in padding. reach: r, the farthest that a unit of a coordinate moves any point: |u| <= sum_i
// |q_i| reach_i. centre, radius: of a ball around the boundary and the body's shape, which may
// extend beyond it (shape_reach.h), m. extent: the longest side of the boundary's box, m. gap: no
// vertex of the boundary is farther from the nearest point, m: what may slip between points. areas:
// of the boundary that each point stands for, m^2; area: their sum.
struct ContactPoints {
  std::vector<VertexId> ids;
  std::vector<Eigen::Vector3d> rest;
  Eigen::MatrixXd rows;
  ScatteredPoints field;
  Eigen::MatrixXd axis_rows;
  Eigen::VectorXd reach;
  std::vector<PointGroup> groups;
  std::vector<double> areas;
  double area = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  double extent = 0.0;
  double gap = 0.0;

  std::size_t size() const { return rest.size(); }
  // X + U q of point i.
  Eigen::Vector3d place(std::size_t i, const Eigen::VectorXd& q) const {
    const Eigen::Index column = 3 * i;
    return rest[i] + rows.middleCols<3>(column).transpose() * q;
  }
  // U q of all points, 3 stride: a field for field_at().
  void displacement(const Eigen::VectorXd& q, Eigen::VectorXd& u) const {
    u.noalias() = axis_rows * q;
  }
};

// At most `most` of the boundary's vertices, each the farthest from those before it, so that gap
// falls as fast as it can. shape: what other bodies bump into; null: nothing.
ContactPoints choose_contact_points(const Model& model, std::size_t most,
                                    const Collider* shape = nullptr);

// The same, made once for all bodies of the model that have as many points and as large a shape. It
// may be called on several threads at once.
std::shared_ptr<const ContactPoints> shared_contact_points(const Model::Pointer& model,
                                                           std::size_t most, const Collider* shape);

}  // namespace tremolo
