// The distance of a position from a deformed body (docs/theory.md, section "Contact"). It uses the
// body's shape at rest and a smooth field u through the displacements of its points. The position y
// of the body's frame is approximately the deformed X at rest: X1 = y - u(y), X = y - u(X1).
#pragma once

#include <Eigen/Core>

#include "runtime/contact/collider.h"
#include "runtime/contact/solve/contact_points.h"

namespace tremolo {

// A deformed shape. All pointers must outlive it.
struct BentShape {
  const Collider* shape = nullptr;
  const ContactPoints* points = nullptr;
  // U q of the points, same as ContactPoints::displacement(), m.
  const Eigen::VectorXd* u = nullptr;
};

// Buffers for rows, of r rows each.
struct BentScratch {
  Eigen::VectorXd weights;
  Eigen::MatrixX3d first, second;
};

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
