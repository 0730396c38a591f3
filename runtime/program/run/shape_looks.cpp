#include "runtime/program/run/shape_looks.h"

#include <algorithm>

namespace tremolo {

using Eigen::Index;

namespace {

constexpr double kRecord = 1.05;

}  // namespace

ShapeLooks::ShapeLooks(const Model& model, std::int64_t least, std::int64_t steps)
    : least_(least),
      every_(std::max(least, steps / kLooks)),
      reach_(Eigen::VectorXd::Zero(model.modes())),
      strain_(largest_gradients(model)) {
  const VertexBlock& surface = model.surface();
  for (Index v = 0; v < static_cast<Index>(surface.rest.size()); ++v)
    reach_ = reach_.cwiseMax(surface.rows.middleRows<3>(3 * v).colwise().norm().transpose());
}

bool ShapeLooks::due(std::int64_t step, const Eigen::VectorXd& q) {
  if (step % every_ == 0) return true;
  if (step % least_ != 0) return false;
  const double bound = q.cwiseAbs().dot(reach_);
  if (!(bound > kRecord * record_)) return false;
  record_ = bound;
  return true;
}

bool ShapeLooks::can_exceed(const Eigen::VectorXd& q, double displacement,
                            const StretchRange& range) const {
  const double strain = q.cwiseAbs().dot(strain_);
  return q.cwiseAbs().dot(reach_) > displacement || 1.0 + strain > range.largest ||
         1.0 - strain < range.smallest;
}

}  // namespace tremolo
