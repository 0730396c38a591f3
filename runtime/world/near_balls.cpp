#include "runtime/world/near_balls.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace tremolo {

void NearBalls::clear() {
  balls_.clear();
  at_.clear();
  largest_ = 0.0;
}

void NearBalls::add(std::size_t body, const Eigen::Vector3d& centre, double radius) {
  balls_.push_back({body, centre, radius});
  largest_ = std::max(largest_, radius);
}

void NearBalls::sort() {
  Eigen::AlignedBox3d box;
  std::size_t bodies = 0;
  for (const Ball& ball : balls_) {
    box.extend(ball.centre);
    bodies = std::max(bodies, ball.body + 1);
  }
  axis_ = 0;
  if (!balls_.empty()) box.sizes().maxCoeff(&axis_);
  std::sort(balls_.begin(), balls_.end(),
            [this](const Ball& a, const Ball& b) { return a.centre[axis_] < b.centre[axis_]; });
  at_.assign(bodies, 0);
  for (std::size_t i = 0; i < balls_.size(); ++i) at_[balls_[i].body] = i + 1;
}

std::span<const std::size_t> NearBalls::of(std::size_t body) {
  found_.clear();
  if (body >= at_.size() || at_[body] == 0) return found_;
  const Ball& own = balls_[at_[body] - 1];
  const double middle = own.centre[axis_], reach = own.radius + largest_;
  auto at = std::lower_bound(balls_.begin(), balls_.end(), middle - reach,
                             [this](const Ball& ball, double x) { return ball.centre[axis_] < x; });
  for (; at != balls_.end() && at->centre[axis_] <= middle + reach; ++at)
    if (at->body != body && (own.centre - at->centre).norm() <= own.radius + at->radius)
      found_.push_back(at->body);
  std::sort(found_.begin(), found_.end());
  return found_;
}

}  // namespace tremolo
