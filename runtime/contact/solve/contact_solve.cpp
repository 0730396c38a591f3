// ContactStep: solves the step of a body that touches no other body by Newton's method.
#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/math/line_search.h"

namespace tremolo {
namespace {

using Eigen::Index;

constexpr double kMomentaTolerance = 1e-10;  // of the momenta in a step
constexpr int kNewtonIterations = 100;       // of Newton's method with the line search
constexpr int kShorter = 12;                 // halvings of a move
constexpr int kNormals = 20;                 // iterations in which normals are renewed,
constexpr double kHeldBelow = 1e6;           // except below this multiple of the small size
constexpr int kMostRenewals = 20;            // iterations that renew limits in a last resort
constexpr int kFullRenewals = 8;             // iterations in which limits are renewed wholly
constexpr double kRoundedWay = 1e-14;        // shortest move, as a fraction of the body's extent
// The same for what is left of the momenta, which adds up over steps: 1e-14 in a million of them.
// Bodies that begin at the edge of contact push each other by less than that. Such forces are the
// rounding of positions, and a solve relative to them need not converge.
constexpr double kNoWay = 1e-20;

// A bound of the rounding error of a position at that distance from the world's origin, m.
double rounding_of_place(double far) {
  return 4.0 * std::numeric_limits<double>::epsilon() * far;
}

}  // namespace

// Unit of size_of_residual(): momenta, and forces times h. The first residual of a step has the
// forces on a body that continues its motion, without those of contact: where contact is hard, that
// motion ends deep in an obstacle, with a force beyond all that occur.
double ContactStep::size_of_motion() const {
  const double h = options_.step;
  double size =
      first_size_ + v0_.norm() + h * (G_.norm() + load_->average.norm() + eq_.pushed.norm());
  if (free_ == nullptr) return size;
  const RigidState& rigid = free_->rigid();
  const double root = std::sqrt(surface().mass);
  size += root * (rigid.velocity.norm() + eq_.points().radius * rigid.spin.norm());
  size += h / root * (eq_.force.norm() + eq_.torque.norm() / eq_.points().radius);
  return size;
}

double ContactStep::grips_rounding() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    const Grip& grip = grips_[i];
    const double stiffness = 0.5 * grip.stiffness + grip.damping / options_.step;
    sum += eq_.spring_rounding(grip.place, stiffness, held_[i].x1.norm() + grip.end.norm());
  }
  return sum;
}

void ContactStep::hold_at(const VertexRows& place, double stiffness, double other) {
  const double own = eq_.motion.c0.norm(), far = own + std::max(own, other);
  joints_rounding_ += eq_.spring_rounding(place, 0.5 * stiffness, far);
  joints_far_ = std::max(joints_far_, far);
}

// What is left of the residual does work along the motion, and the force along the rounding errors
// of the positions.
double ContactStep::work_of_rounding() const {
  const double left = near_rounding(false) * (grips_rounding() + joints_rounding_);
  if (!(left > 0.0)) return 0.0;
  double work = left * std::sqrt(surface().mass) * eq_.way_of(eq_.z) / options_.step;
  if (free_ == nullptr) return work;
  double far = joints_far_;
  for (std::size_t i = 0; i < grips_.size(); ++i)
    far = std::max(far, held_[i].x1.norm() + grips_[i].end.norm());
  return work + eq_.force.norm() * rounding_of_place(far + eq_.points().extent);
}

double ContactStep::enough() const {
  const double none = kNoWay * std::sqrt(surface().mass) * eq_.points().extent / options_.step;
  return std::max({kMomentaTolerance * size_of_motion(), grips_rounding() + joints_rounding_, none,
                   std::numeric_limits<double>::min()});
}

ContactRenewal renewal(int iteration, double size, bool hold) {
  if (hold && iteration >= kMostRenewals) return {};
  return {.normals = iteration < kNormals && size >= kHeldBelow,
          .limits = iteration < kFullRenewals || size < kHeldBelow ? 1.0 : 0.5};
}

bool limits_follow(int iteration, double size, bool hold) {
  if (hold && iteration >= kMostRenewals) return false;
  return iteration > 1 || size < kHeldBelow;
}

double near_rounding(bool hold) {
  return hold ? 1e3 : 30.0;
}

double shortest_following(int iteration) {
  return iteration < kFullRenewals ? 1.0 : 0.01;
}

double following_bound(double length) {
  return 1.0 - 0.5 * length;
}

// Tries a move of Newton's method in which limits follow the force: a whole move if it halves the
// residual; after many failures also a shorter one that lowers it. False, with nothing changed, if
// none does.
bool ContactStep::try_following(int iteration, double size, double& reached) {
  const Index n = eq_.unknowns();
  make_jacobian(0.0, true);
  factor_.compute(eq_.jacobian.topLeftCorner(n, n));
  move_.head(n) = eq_.residual.head(n);
  factor_.solve_in_place(move_.head(n));
  const auto go = [&](double length) {
    eq_.z.head(n) = z_before_.head(n) - length * move_.head(n);
    evaluate({.normals = false, .limits = 1.0});
    return close();
  };
  for (double length = 1.0; length >= shortest_following(iteration); length *= 0.5) {
    reached = go(length);
    if (reached <= following_bound(length) * size) return true;
  }
  go(0.0);
  return false;
}

// heavier: factor of added inertia for the first moves.
bool ContactStep::solve(double heavier, bool hold, StepReport& report) {
  const double h = options_.step;
  const Index n = eq_.unknowns();
  evaluate({});
  double size = close(), enough = this->enough();
  bool followed_last = false;  // all limits are already those of the last move
  for (int i = 0; i < kNewtonIterations; ++i) {
    const ContactRenewal renewed = renewal(i, size / enough, hold);
    if (!touching().empty() && (!followed_last || renewed.normals)) {
      evaluate(renewed);
      size = close();
    }
    followed_last = false;
    report.residual = 0.5 * h * size;
    enough = this->enough();
    if (size <= enough) return true;
    if (!std::isfinite(size)) return false;
    z_before_ = eq_.z;
    double followed = 0.0;
    if (!touching().empty() && limits_follow(i, size / enough, hold) &&
        try_following(i, size, followed)) {
      ++report.iterations;
      size = followed;
      followed_last = true;
      continue;
    }
    const auto go = [&](double length) {
      eq_.z.head(n) = z_before_.head(n) - length * move_.head(n);
      evaluate({});
      const double next = close();
      return LineTrial{next, -eq_.work_along(move_.head(n))};
    };
    const auto find_move = [&](double added) {
      make_jacobian(added, false);
      factor_.compute(eq_.jacobian.topLeftCorner(n, n));
      move_.head(n) = eq_.residual.head(n);
      factor_.solve_in_place(move_.head(n));
      return -eq_.work_along(move_.head(n));
    };
    LineTrial reached;
    const bool small = size <= near_rounding(hold) * enough;
    if (!newton_move(find_move, go, size, small, heavier, reached)) return small;
    // The move is smaller than rounding of the points' positions.
    if (eq_.way_of(move_) <= kRoundedWay * eq_.points().extent) return true;
    ++report.iterations;
    // At rounding level no move lowers the residual.
    if (!(reached.size < 0.9 * size) && small) {
      if (reached.size > size) go(0.0);
      return true;
    }
    size = reached.size;
  }
  return false;
}

StepReport ContactStep::step(State& state, const StepLoad& load, FreeFrame* free, bool whole) {
  StepReport report;
  // Starts again with short moves where long ones did not converge.
  struct Attempt {
    double heavier;
    bool hold;
  };
  for (const auto [heavier, hold] :
       {Attempt{0.0, false}, Attempt{10.0, false}, Attempt{1000.0, false}, Attempt{10.0, true}}) {
    if (hold && !whole) break;
    begin(state, load, free);
    in_island_ = false;
    do {
      report.converged = solve(heavier, hold, report) && eq_.z.allFinite();
    } while (report.converged && add_missed());
    if (report.converged && hold) ++record_.held_steps;
    if (report.converged) break;
  }
  if (report.converged) finish(state, report);
  return report;
}

}  // namespace tremolo
