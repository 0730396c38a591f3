#include "runtime/math/kernels/scattered_field.h"

#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// A place among the points, and the field on them.
struct FieldLook {
  const double* x;
  const double* y;
  const double* z;
  const double* u;
  std::size_t stride;
  double softness2;
  double place[3];
};

// spread: column by column, of u (grad w)^T.
struct FieldSums {
  double weight;
  double total[3];
  double slope[3];
  double spread[9];
};

// Of the squares of the weights, and of twelve values with them.
struct SharpSums {
  double weight;
  double total[12];
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/kernels/scattered_field.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {
namespace {

constexpr double kFarAway = 1e100;  // m: its weight is 1e-400, which is zero

FieldLook look_at(const ScatteredPoints& points, const double* u, const Eigen::Vector3d& place) {
  return {points.x(),
          points.y(),
          points.z(),
          u,
          points.stride(),
          points.softness2(),
          {place.x(), place.y(), place.z()}};
}

}  // namespace

ScatteredPoints::ScatteredPoints(std::span<const Eigen::Vector3d> points, double softness2)
    : x_(padded(points.size()), kFarAway),
      y_(padded(points.size()), kFarAway),
      z_(padded(points.size()), kFarAway),
      softness2_(softness2) {
  move(points);
}

void ScatteredPoints::move(std::span<const Eigen::Vector3d> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    x_[i] = points[i].x();
    y_[i] = points[i].y();
    z_[i] = points[i].z();
  }
}

Eigen::Vector3d field_at(const ScatteredPoints& points, const Eigen::VectorXd& u,
                         const Eigen::Vector3d& place) {
  const FieldLook look = look_at(points, u.data(), place);
  FieldSums sums;
  TREMOLO_CALL(sum_field, look, sums);
  return Eigen::Vector3d::Map(sums.total) / sums.weight;
}

Eigen::Vector3d field_at(const ScatteredPoints& points, const Eigen::VectorXd& u,
                         const Eigen::Vector3d& place, Eigen::Matrix3d& gradient) {
  const FieldLook look = look_at(points, u.data(), place);
  FieldSums sums;
  TREMOLO_CALL(sum_field_slopes, look, sums);
  const Eigen::Vector3d mean = Eigen::Vector3d::Map(sums.total) / sums.weight;
  gradient =
      (Eigen::Matrix3d::Map(sums.spread) - mean * Eigen::Vector3d::Map(sums.slope).transpose()) /
      sums.weight;
  return mean;
}

Eigen::Matrix<double, 12, 1> sharp_mean(const ScatteredPoints& points, const TwelveValues& values,
                                        const Eigen::Vector3d& place) {
  const FieldLook look = look_at(points, values.data(), place);
  SharpSums sums;
  TREMOLO_CALL(sum_sharply, look, sums);
  return Eigen::Matrix<double, 12, 1>::Map(sums.total) / sums.weight;
}

void field_weights(const ScatteredPoints& points, const Eigen::Vector3d& place,
                   Eigen::VectorXd& weights) {
  weights.resize(points.stride());
  const FieldLook look = look_at(points, nullptr, place);
  const double sum = TREMOLO_CALL(write_weights, look, weights.data());
  weights /= sum;
}

}  // namespace tremolo
