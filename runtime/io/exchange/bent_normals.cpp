#include "runtime/io/exchange/bent_normals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "runtime/math/dense/decompositions.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostFrames = 128;  // that are collected, over all bodies
constexpr double kMostNumbers = 3e7;      // of all of them together
constexpr double kLeastSeen = 0.2;        // a first-order normal that is farther off is replaced
constexpr double kNoise = 1e-12;          // of the largest square or of one: floats hold no more
constexpr double kShortestBase = 0.1;     // a base that would be shorter has no direction to keep

struct BodyFrame {
  const AnimatedBody* body = nullptr;
  std::size_t frame = 0;
};

std::vector<BodyFrame> chosen_frames(const Animation& animation, std::size_t shape,
                                     std::size_t most) {
  std::vector<BodyFrame> all, chosen;
  for (const AnimatedBody& body : animation.bodies)
    for (std::size_t frame = 0; body.shape == shape && frame < animation.frames(); ++frame)
      all.push_back({&body, frame});
  const std::size_t count = std::min(most, all.size());
  for (std::size_t k = 0; k < count; ++k)
    chosen.push_back(all[count < 2 ? 0 : k * (all.size() - 1) / (count - 1)]);
  return chosen;
}

// The error of the normals of a frame, 3s numbers.
class MissingNormals {
 public:
  MissingNormals(const Animation& animation, std::size_t shape, const TargetRanges& ranges,
                 const Eigen::MatrixXf& normals)
      : animation_(animation),
        shape_(animation.shapes[shape]),
        ranges_(ranges),
        normals_(normals),
        places_(shape_.surface.vertices.size()) {}

  VectorXd operator()(const BodyFrame& at) {
    const std::vector<float> weights =
        target_weights(coordinates_at(animation_, *at.body, at.frame), ranges_);
    const Map<const Eigen::VectorXf> w(weights.data(), static_cast<Index>(weights.size()));
    const Eigen::VectorXf shown = normals_.col(0) + normals_.middleCols(1, w.size()) * w;
    local_positions(animation_, *at.body, at.frame, {places_.front().data(), 3 * places_.size()});
    const std::vector<Vector3d> bent = smooth_normals(shape_, places_);
    VectorXd missing(3 * static_cast<Index>(bent.size()));
    for (std::size_t v = 0; v < bent.size(); ++v) {
      const Index row = 3 * static_cast<Index>(v);
      const Vector3d first = shown.segment<3>(row).cast<double>();
      missing.segment<3>(row) =
          bent[v].isZero(0.0)
              ? Vector3d(Vector3d::Zero())
              : Vector3d(std::max(bent[v].dot(first), kLeastSeen) * bent[v] - first);
    }
    return missing;
  }

 private:
  const Animation& animation_;
  const AnimatedShape& shape_;
  const TargetRanges& ranges_;
  const Eigen::MatrixXf& normals_;
  std::vector<Vector3d> places_;
};

// The first left singular vectors of the frames' columns, 3s x count at most.
MatrixXd first_vectors(const MatrixXd& columns, std::size_t count) {
  const SymmetricEigen solver = symmetric_eigen(columns.transpose() * columns);
  const VectorXd& squares = solver.values;  // ascending
  const Index all = squares.size();
  Index kept = 0;
  while (kept < std::min(all, static_cast<Index>(count)) &&
         squares[all - 1 - kept] > kNoise * std::max(squares[all - 1], 1.0))
    ++kept;
  MatrixXd vectors(columns.rows(), kept);
  for (Index k = 0; k < kept; ++k)
    vectors.col(k) = columns * solver.vectors.col(all - 1 - k) / std::sqrt(squares[all - 1 - k]);
  return vectors;
}

// Brings the weights into [0, 1]; the base takes what they have at zero, and targets whose weight
// never changes are gone.
void bound_weights(MatrixXd& vectors, std::vector<MatrixXd>& weights, VectorXd& base) {
  Index kept = 0;
  for (Index k = 0; k < vectors.cols(); ++k) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const MatrixXd& w : weights) {
      if (w.size() == 0) continue;
      low = std::min(low, w.row(k).minCoeff());
      high = std::max(high, w.row(k).maxCoeff());
    }
    base += low * vectors.col(k);
    if (!(high > low)) continue;
    vectors.col(kept) = (high - low) * vectors.col(k);
    for (MatrixXd& w : weights)
      if (w.size() > 0) w.row(kept) = (w.row(k).array() - low) / (high - low);
    ++kept;
  }
  vectors.conservativeResize(Eigen::NoChange, kept);
  for (MatrixXd& w : weights)
    if (w.size() > 0) w.conservativeResize(kept, Eigen::NoChange);
}

// Appends the columns. Each vertex's numbers are divided by what makes its base a unit vector; one
// whose base has no length stays as the first order has it.
void append(const MatrixXd& vectors, const VectorXd& base, MorphTargets& targets) {
  const Index before = targets.normals.cols();
  targets.normals.conservativeResize(Eigen::NoChange, before + vectors.cols());
  targets.normals.rightCols(vectors.cols()) = vectors.cast<float>();
  for (Index row = 0; row < base.size(); row += 3) {
    const double length = base.segment<3>(row).norm();
    if (length < kShortestBase) {
      targets.normals.block(row, before, 3, vectors.cols()).setZero();
      continue;
    }
    targets.normals.block<3, 1>(row, 0) = base.segment<3>(row).cast<float>();
    targets.normals.middleRows<3>(row) /= static_cast<float>(length);
  }
}

}  // namespace

BentNormals add_bent_normals(const Animation& animation, std::size_t shape,
                             const TargetRanges& ranges, bool plain, std::size_t count,
                             MorphTargets& targets) {
  BentNormals bent;
  bent.weights.resize(animation.bodies.size());
  if (count == 0 || targets.normals.cols() == 0 || animation.shapes[shape].modes.cols() == 0)
    return bent;
  const auto fit =
      static_cast<std::size_t>(kMostNumbers / static_cast<double>(targets.normals.rows()));
  const std::vector<BodyFrame> frames =
      chosen_frames(animation, shape, std::clamp<std::size_t>(fit, 8, kMostFrames));
  if (frames.empty()) return bent;
  MissingNormals missing(animation, shape, ranges, targets.normals);
  MatrixXd columns(targets.normals.rows(), static_cast<Index>(frames.size()));
  for (std::size_t k = 0; k < frames.size(); ++k)
    columns.col(static_cast<Index>(k)) = missing(frames[k]);
  MatrixXd vectors = first_vectors(columns, count);
  std::vector<MatrixXd> weights(animation.bodies.size());
  for (std::size_t b = 0; b < animation.bodies.size(); ++b) {
    if (animation.bodies[b].shape != shape) continue;
    weights[b].resize(vectors.cols(), static_cast<Index>(animation.frames()));
    for (std::size_t frame = 0; frame < animation.frames(); ++frame)
      weights[b].col(static_cast<Index>(frame)) =
          vectors.transpose() * missing({&animation.bodies[b], frame});
  }
  VectorXd base = targets.normals.col(0).cast<double>();
  if (!plain) bound_weights(vectors, weights, base);
  append(vectors, base, targets);
  bent.targets = static_cast<std::size_t>(vectors.cols());
  for (std::size_t b = 0; b < weights.size(); ++b) bent.weights[b] = weights[b].cast<float>();
  return bent;
}

}  // namespace tremolo
