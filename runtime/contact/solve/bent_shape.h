// How far a place is from a body that has bent (docs/theory.md, section "Contact"): by the body's
// shape at rest and a smooth field u through the displacements of its points. A place y of the
// body's frame is where the place X at rest is now, nearly: X1 = y - u(y), X = y - u(X1).
#pragma once

#include <Eigen/Core>

#include "runtime/contact/collider.h"
#include "runtime/contact/solve/contact_points.h"

namespace tremolo {

// u: U q of the points as ContactPoints::displacement() gives it. All must outlive this.
struct BentShape {
  const Collider* shape = nullptr;
  const ContactPoints* points = nullptr;
  const Eigen::VectorXd* u = nullptr;
};

// For the making of rows, of r rows each.
struct BentScratch {
  Eigen::VectorXd weights;
  Eigen::MatrixX3d first, second;
};

// Distance of X from the shape, m, and its gradient by y.
double bent_distance(const BentShape& bent, const Eigen::Vector3d& y);
Eigen::Vector3d bent_gradient(const BentShape& bent, const Eigen::Vector3d& y);

// How that distance changes with the coordinates, r: -n.(N(X1) - (grad u)(X1) N(y)), N the rows of
// U; returns its gradient by y.
Eigen::Vector3d bent_change(const BentShape& bent, const Eigen::Vector3d& y, BentScratch& scratch,
                            Eigen::VectorXd& change);

// The transposed rows R, r x 3, by which the place moves with the coordinates, so that the distance
// changes by gradient.(dy - R^T dq): N(X1) but for what bends.
void bent_rows(const BentShape& bent, const Eigen::Vector3d& y, BentScratch& scratch,
               Eigen::MatrixX3d& rows);

}  // namespace tremolo
