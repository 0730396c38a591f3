#include "runtime/bodies/reduced/bones/bone_points.h"

#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/LU>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kMostCorrections = 5;    // of Newton's method for the end of a position
constexpr double kSmallError = 1e-13;  // of it, as a fraction of the distance from the origin, m/m
constexpr double kAgreement = 0.5;     // of the distance from the nearest point
constexpr double kLeastVolume = 0.05;  // of a slope that is inverted

Vector3d back(const Pose& pose, const Vector3d& x) {
  return pose.rotation.conjugate() * (x - pose.position);
}

}  // namespace

BonePoints::BonePoints(std::vector<Vector3d> rest, BoneWeights weights, double softness2)
    : rest_(std::move(rest)),
      weights_(std::move(weights)),
      poses_(static_cast<std::size_t>(weights_.cols())),
      maps_(rest_.size()),
      shares_(weights_.cols()) {
  for (End* end : {&start_, &end_}) {
    end->bones.resize(poses_.size());
    end->places = rest_;
    end->field = ScatteredPoints(rest_, softness2);
    end->fields.setZero(static_cast<Index>(end->field.stride()), 12);
  }
  nearness_.setZero(static_cast<Index>(start_.field.stride()));
}

void BonePoints::place(const DrivenFrame& frame) {
  for (std::size_t b = 0; b < poses_.size(); ++b) {
    poses_[b] = {frame.pose(b), frame.next_pose(b)};
    start_.bones[b] = bone_map(poses_[b].start);
    end_.bones[b] = bone_map(poses_[b].end);
  }
  for (std::size_t i = 0; i < rest_.size(); ++i)
    maps_[i] = maps_of(weights_.row(static_cast<Index>(i)));
  place(start_, false);
  place(end_, true);
}

void BonePoints::place(End& end, bool at_end) {
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const BoneMap& map = at_end ? maps_[i].end : maps_[i].start;
    end.places[i] = map.leftCols<3>() * rest_[i] + map.col(3);
    const Matrix3d turn_back = rotation(weights_.row(row), at_end).toRotationMatrix().transpose();
    end.fields.row(row).head<3>() = rest_[i] - turn_back * end.places[i];
    end.fields.row(row).tail<9>() = turn_back.reshaped().transpose();
  }
  end.field.move(end.places);
}

// The mean of quaternions with the sign of the heaviest bone's.
Eigen::Quaterniond BonePoints::rotation(const Eigen::Ref<const Eigen::RowVectorXd>& weights,
                                        bool at_end) const {
  const auto of = [&](std::size_t b) -> const Eigen::Quaterniond& {
    return (at_end ? poses_[b].end : poses_[b].start).rotation;
  };
  Index heaviest = 0;
  weights.maxCoeff(&heaviest);
  const Eigen::Quaterniond& first = of(static_cast<std::size_t>(heaviest));
  Eigen::Quaterniond sum(0.0, 0.0, 0.0, 0.0);
  for (std::size_t b = 0; b < poses_.size(); ++b) {
    const double weight = weights[static_cast<Index>(b)];
    if (weight != 0.0) sum.coeffs() += (of(b).dot(first) < 0.0 ? -weight : weight) * of(b).coeffs();
  }
  return sum.normalized();
}

Vector3d BonePoints::turn_of(std::span<const double> weights) const {
  const Eigen::Map<const Eigen::RowVectorXd> shares(weights.data(), std::ssize(weights));
  const Eigen::Quaterniond by = rotation(shares, true) * rotation(shares, false).conjugate();
  return 2.0 / by.w() * by.vec();
}

void BonePoints::find_nearness(const Vector3d& x, const End& end) const {
  field_weights(end.field, x, nearness_);
  nearness_ = nearness_.cwiseAbs2();
  nearness_ /= nearness_.sum();
}

Vector3d BonePoints::into_rest(const Vector3d& x, bool at_end) const {
  const End& end = at_end ? end_ : start_;
  const Eigen::Matrix<double, 12, 1> mean = sharp_mean(end.field, end.fields, x);
  return mean.head<3>() + Matrix3d::Map(mean.data() + 3) * x;
}

Vector3d BonePoints::into_rest(const Vector3d& x, bool at_end, Matrix3d& slope) const {
  const Vector3d y = into_rest(x, at_end);
  const End& end = at_end ? end_ : start_;
  find_nearness(x, end);
  slope.setZero();
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const double near = nearness_[row];
    if (near < 1e-14) continue;
    const Matrix3d turn_back = end.fields.row(row).tail<9>().reshaped(3, 3);
    const Vector3d way = x - end.places[i];
    const Vector3d apart = end.fields.row(row).head<3>().transpose() + turn_back * x - y;
    const Vector3d growth = (-8.0 / (way.squaredNorm() + end.field.softness2())) * way;
    slope += near * (turn_back + apart * growth.transpose());
  }
  return y;
}

// The nearest point's bones alone would move y elsewhere.
bool BonePoints::agree(const Vector3d& x, const Vector3d& y, bool at_end) const {
  const End& end = at_end ? end_ : start_;
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const double far = (x - end.places[i]).squaredNorm();
    if (far >= least) continue;
    least = far;
    nearest = i;
  }
  const auto row = end.fields.row(static_cast<Index>(nearest));
  const Matrix3d turn_back = row.tail<9>().reshaped(3, 3);
  const Vector3d alone = row.head<3>().transpose() + turn_back * x;
  return (y - alone).norm() <= kAgreement * (std::sqrt(least) + std::sqrt(end.field.softness2()));
}

StepPoses BonePoints::motion_at(const Vector3d& x) const {
  const Vector3d y = into_rest(x, false);
  find_nearness(x, start_);
  shares_.noalias() = nearness_.head(weights_.rows()).transpose() * weights_;
  StepPoses motion;
  motion.start.rotation = rotation(shares_, false);
  motion.end.rotation = rotation(shares_, true);
  Vector3d there = Vector3d::Zero();
  for (std::size_t b = 0; b < poses_.size(); ++b)
    there += shares_[static_cast<Index>(b)] * (poses_[b].end * back(poses_[b].start, x));
  for (int k = 0; k < kMostCorrections; ++k) {
    Matrix3d slope;
    const Vector3d off = into_rest(there, true, slope) - y;
    if (!(off.norm() > kSmallError * (y.norm() + there.norm()))) break;
    if (slope.determinant() > kLeastVolume)
      there -= slope.inverse() * off;
    else
      there -= motion.end.rotation * off;
  }
  motion.start.position = x - motion.start.rotation * y;
  motion.end.position = there - motion.end.rotation * y;
  return motion;
}

}  // namespace tremolo
