// A smooth field through values on scattered points, as their mean by the weights
// w_i = 1/(|x - x_i|^2 + e^2)^2 (Shepard's), and its gradient.
#pragma once

#include <span>

#include <Eigen/Core>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {

// The points, coordinate by coordinate, padded to whole vectors by points so far away that their
// weight is zero.
class ScatteredPoints {
 public:
  ScatteredPoints() = default;
  // points: m. softness2: e^2, m^2, above zero.
  ScatteredPoints(std::span<const Eigen::Vector3d> points, double softness2);

  // Moves the points, as many as before.
  void move(std::span<const Eigen::Vector3d> points);

  // The number of points with padding: the length of a field's coordinate.
  std::size_t stride() const { return x_.size(); }
  const double* x() const { return x_.data(); }
  const double* y() const { return y_.data(); }
  const double* z() const { return z_.data(); }
  double softness2() const { return softness2_; }

 private:
  AlignedDoubles x_, y_, z_;
  double softness2_ = 1.0;
};

// u: 3 stride() entries, all x, all y, all z; those of padding are finite. Returns the mean at a
// position.
Eigen::Vector3d field_at(const ScatteredPoints& points, const Eigen::VectorXd& u,
                         const Eigen::Vector3d& place);
// gradient(i, j): of component i along j.
Eigen::Vector3d field_at(const ScatteredPoints& points, const Eigen::VectorXd& u,
                         const Eigen::Vector3d& place, Eigen::Matrix3d& gradient);
// The mean of twelve values per point at a position by the squares of the weights. values: stride()
// rows; those of padding are finite.
using TwelveValues = Eigen::Matrix<double, Eigen::Dynamic, 12>;
Eigen::Matrix<double, 12, 1> sharp_mean(const ScatteredPoints& points, const TwelveValues& values,
                                        const Eigen::Vector3d& place);
// The weights at a position, which sum to one. weights: stride() entries.
void field_weights(const ScatteredPoints& points, const Eigen::Vector3d& place,
                   Eigen::VectorXd& weights);

}  // namespace tremolo
