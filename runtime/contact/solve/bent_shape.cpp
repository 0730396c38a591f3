#include "runtime/contact/solve/bent_shape.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

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
  slope.normal = signed_distance(*bent.shape, rest).normal;
  slope.through = at_rest1.transpose() * slope.normal;
  slope.gradient = slope.normal - slope.through + at_y.transpose() * slope.through;
  return slope;
}

}  // namespace

double bent_distance(const BentShape& bent, const Vector3d& y) {
  const ScatteredPoints& field = bent.points->field;
  const Vector3d rest1 = y - field_at(field, *bent.u, y);
  return signed_distance(*bent.shape, y - field_at(field, *bent.u, rest1)).distance;
}

Vector3d bent_gradient(const BentShape& bent, const Vector3d& y) {
  return bent_slope(bent, y).gradient;
}

Vector3d bent_change(const BentShape& bent, const Vector3d& y, BentScratch& scratch,
                     Eigen::VectorXd& change) {
  const BentSlope slope = bent_slope(bent, y);
  rows_at(*bent.points, y, scratch.weights, scratch.first);
  rows_at(*bent.points, slope.rest1, scratch.weights, scratch.second);
  change.noalias() = scratch.first * slope.through - scratch.second * slope.normal;
  return slope.gradient;
}

void bent_rows(const BentShape& bent, const Vector3d& y, BentScratch& scratch,
               Eigen::MatrixX3d& rows) {
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
