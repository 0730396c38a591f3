#include "runtime/exchange/recorded_modes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The squares of singular values resolve no smaller ones.
constexpr double kLeastSquare = 1e-13;

double farthest(const MatrixXd& rest) {
  double most = 0.0;
  for (Index frame = 0; frame < rest.cols(); ++frame)
    for (Index k = 0; k < rest.rows(); k += 3)
      most = std::max(most, rest.col(frame).segment<3>(k).squaredNorm());
  return std::sqrt(most);
}

// Leaves the body's shape with modes and q; the largest distance that is left, m.
double describe(AnimatedShape& shape, AnimatedBody& body, Index most, double enough) {
  const Index rows = 3 * shape.surface.vertices.size();
  const auto frames = static_cast<Index>(body.displacements.size()) / rows;
  const Eigen::Map<const MatrixXd> motion(body.displacements.data(), rows, frames);
  MatrixXd products = MatrixXd::Zero(frames, frames);
  products.selfadjointView<Eigen::Lower>().rankUpdate(motion.transpose());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(products);
  const double largest = solver.eigenvalues()[frames - 1];
  MatrixXd left = motion, modes(rows, std::min(most, frames));
  Index count = 0;
  double off = farthest(left);
  while (count < modes.cols() && off > enough) {
    const Index k = frames - 1 - count;
    if (!(solver.eigenvalues()[k] > kLeastSquare * largest)) break;
    modes.col(count) = motion * solver.eigenvectors().col(k);
    modes.col(count).normalize();
    // Coordinates of the residual, not of the whole motion: the next mode corrects the rounding of
    // this one.
    const VectorXd shares = left.transpose() * modes.col(count);
    left.noalias() -= modes.col(count) * shares.transpose();
    off = farthest(left);
    ++count;
  }
  shape.modes = modes.leftCols(count);
  const MatrixXd q = shape.modes.transpose() * motion;
  off = farthest(motion - shape.modes * q);
  body.q.assign(q.data(), q.data() + q.size());
  body.displacements.clear();
  return off;
}

}  // namespace

Result<double> describe_by_modes(Animation& animation, std::size_t most, double enough) {
  if (Status s = check_animation(animation); !s) return s.error();
  double worst = 0.0;
  for (AnimatedBody& body : animation.bodies) {
    if (body.displacements.empty()) continue;
    const bool shared =
        std::count_if(animation.bodies.begin(), animation.bodies.end(),
                      [&body](const AnimatedBody& other) { return other.shape == body.shape; }) > 1;
    if (shared) {
      animation.shapes.push_back(animation.shapes[body.shape]);
      animation.shapes.back().name = body.name;
      body.shape = animation.shapes.size() - 1;
    }
    AnimatedShape& shape = animation.shapes[body.shape];
    const double size = std::max(largest_extent(shape), 1e-300);
    worst = std::max(worst, describe(shape, body, static_cast<Index>(most), enough * size) / size);
  }
  return worst;
}

}  // namespace tremolo
