#include "runtime/mixed/mixed_island.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/math/line_search.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kMostIterations = 60;
constexpr double kConverged = 0.02;  // fraction of the small size at which a residual is converged
// A body's small size, as a momentum, is at least this fraction of the largest in the island.
constexpr double kLeastOfLargest = 0.01;
constexpr double kLinearTolerance = 1e-4;
constexpr int kMoreLinear = 8;  // of needs_factor()
constexpr int kMostLinear = 400;
// After so many corrections that do not lower the least residual it is rounding, if it is as small
// as the last resort would take.
constexpr int kStalled = 10;
// A correction that GMRES did not solve to this is not used.
constexpr double kUsable = 1e-2;

}  // namespace

// Computes the residuals. Returns their size in units of the small sizes.
double MixedIsland::evaluate(const ContactRenewal& renewal) {
  for (StepBody* body : bodies_) body->evaluate(renewal);
  for (PairForces* coupling : couplings_) coupling->shared->rate = {};
  for (PairForces* coupling : couplings_) coupling->approach();
  for (PairForces* coupling : couplings_) coupling->press(renewal);
  for (std::size_t i = 0; i < bodies_.size(); ++i) sizes_[i] = bodies_[i]->close();
  double square = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) square += std::pow(sizes_[i] / enough_[i], 2);
  return std::sqrt(square);
}

// Updates the small sizes; returns the size in these units. A body at rest that another begins to
// push has a small size far below the rounding errors of the other.
double MixedIsland::measure() {
  double momentum = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    enough_[i] = bodies_[i]->enough();
    momentum = std::max(momentum, enough_[i] * bodies_[i]->momentum_of_size());
  }
  double square = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    enough_[i] = std::max(enough_[i], kLeastOfLargest * momentum / bodies_[i]->momentum_of_size());
    square += std::pow(sizes_[i] / enough_[i], 2);
  }
  return std::sqrt(square);
}

void MixedIsland::multiply(StepBody::In x, StepBody::Out rows) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i]->multiply(part(x, i), part(rows, i));
  for (PairForces* coupling : couplings_) coupling->shared->growth = 0.0;
  for (PairForces* coupling : couplings_) {
    if (coupling->second == PairForces::kNobody)
      coupling->add_growth(part(x, coupling->first), empty_);
    else
      coupling->add_growth(part(x, coupling->first), part(x, coupling->second));
  }
  for (const PairForces* coupling : couplings_) {
    const std::size_t a = coupling->first, b = coupling->second;
    if (b == PairForces::kNobody)
      coupling->multiply(part(x, a), empty_, part(rows, a), empty_);
    else
      coupling->multiply(part(x, a), part(x, b), part(rows, a), part(rows, b));
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) part(rows, i) /= enough_[i];
}

void MixedIsland::precondition(StepBody::In rows, StepBody::Out x) {
  scaled_.head(first_.back()) = rows;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    part(scaled_, i) *= enough_[i];
    bodies_[i]->precondition(part(scaled_, i), part(x, i));
  }
}

// A decomposition serves for several corrections, until GMRES needs many more iterations with it.
bool MixedIsland::needs_factor(double heavier) const {
  return heavier != factored_ || gmres_.iterations() > 2 * first_linear_ + kMoreLinear;
}

// Newton's correction at the present unknowns, in move_. False: there is none.
bool MixedIsland::find_move(double heavier, bool follows) {
  for (StepBody* body : bodies_) body->make_tangent(heavier, follows);
  for (PairForces* coupling : couplings_) coupling->make_slopes(follows);
  const bool fresh = needs_factor(heavier);
  factored_ = -1.0;
  for (StepBody* body : bodies_)
    if (!body->factor(fresh)) return false;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i]->residual(part(residual_, i));
    part(residual_, i) /= enough_[i];
  }
  const Index n = first_.back();
  bool solved = gmres_.solve([this](StepBody::In x, StepBody::Out rows) { multiply(x, rows); },
                             [this](StepBody::In rows, StepBody::Out x) { precondition(rows, x); },
                             residual_.head(n), kLinearTolerance, kMostLinear, move_.head(n));
  report_.linear += gmres_.iterations();
  factored_ = heavier;
  if (fresh) first_linear_ = gmres_.iterations();
  if (!solved && gmres_.residual() <= kUsable * residual_.head(n).norm()) solved = true;
  return solved && move_.head(n).allFinite();
}

// Change of the function that the step minimises, except for rotation, along the move.
double MixedIsland::slope() const {
  double work = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) work += bodies_[i]->work_along(part(move_, i));
  return -work;
}

double MixedIsland::go(double length, const ContactRenewal& renewal) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i]->go(length, part(move_, i));
  return evaluate(renewal);
}

// Same as ContactStep::try_following().
bool MixedIsland::try_following(int iteration, double size) {
  const ContactRenewal limits{.normals = false, .limits = 1.0};
  if (!find_move(0.0, true)) return false;
  for (double length = 1.0; length >= shortest_following(iteration); length *= 0.5)
    if (go(length, limits) <= following_bound(length) * size) return true;
  go(0.0, limits);
  return false;
}

bool MixedIsland::solve(double heavier, bool hold) {
  evaluate({});
  measure();
  double least = std::numeric_limits<double>::infinity();
  int stalled = 0;
  for (int i = 0; i < kMostIterations; ++i) {
    evaluate(renewal(i, measure(), hold));
    double size = measure();
    if (!std::isfinite(size)) return false;
    if (size <= kConverged) return true;
    stalled = size < 0.9 * least ? 0 : stalled + 1;
    least = std::min(least, size);
    if (stalled > kStalled && size <= near_rounding(true)) return true;
    ++report_.iterations;
    for (StepBody* body : bodies_) body->keep();
    if (limits_follow(i, size, hold) && try_following(i, size)) continue;
    const auto trial = [this](double length) {
      const double next = go(length, {});
      for (std::size_t k = 0; k < bodies_.size(); ++k) bodies_[k]->residual(part(residual_, k));
      return LineTrial{next, slope()};
    };
    const auto find = [this](double added) { return find_move(added, false) ? slope() : 0.0; };
    LineTrial reached;
    const bool near = size <= near_rounding(hold);
    if (!newton_move(find, trial, size, near, heavier, reached)) return near;
    // At rounding level no move lowers the residual.
    if (!(reached.size < 0.9 * size) && near) {
      if (reached.size > size) go(0.0, {});
      return true;
    }
  }
  return false;
}

bool MixedIsland::add_missed() {
  bool any = false;
  for (StepBody* body : bodies_) any = body->add_missed() || any;
  for (PairForces* coupling : couplings_) any = coupling->add_missed() || any;
  return any;
}

void MixedIsland::settle() {
  accounts_.assign(bodies_.size() + 1, {});
  starts_.assign(bodies_.size() + 1, 0.0);
  for (const PairForces* coupling : couplings_) {
    const std::size_t b =
        coupling->second == PairForces::kNobody ? bodies_.size() : coupling->second;
    coupling->settle(accounts_[coupling->first], accounts_[b], starts_[coupling->first],
                     starts_[b]);
  }
  const bool jumped = std::any_of(bodies_.begin(), bodies_.end(),
                                  [](const StepBody* body) { return body->jumped(); });
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    bodies_[i]->finish(accounts_[i], starts_[i], jumped);
  for (PairForces* coupling : couplings_) coupling->remember();
  for (StepBody* body : bodies_) body->end();
}

MixedReport MixedIsland::step(std::span<StepBody* const> bodies,
                              std::span<PairForces* const> couplings) {
  bodies_ = bodies;
  couplings_ = couplings;
  report_ = {};
  struct Attempt {
    double heavier;
    bool hold;
  };
  for (const auto [heavier, hold] :
       {Attempt{0.0, false}, Attempt{10.0, false}, Attempt{1000.0, false}, Attempt{10.0, true}}) {
    for (StepBody* body : bodies_) body->begin();
    for (PairForces* coupling : couplings_) coupling->begin();
    factored_ = -1.0;
    first_.assign(1, 0);
    for (const StepBody* body : bodies_) first_.push_back(first_.back() + body->unknowns());
    for (VectorXd* v : {&residual_, &move_, &scaled_})
      if (v->size() < first_.back()) v->resize(first_.back());
    sizes_.assign(bodies_.size(), 0.0);
    enough_.assign(bodies_.size(), 1.0);
    do {
      report_.converged = solve(heavier, hold);
    } while (report_.converged && add_missed());
    if (report_.converged) break;
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    report_.residual = std::max(report_.residual, sizes_[i] / enough_[i]);
  if (report_.converged)
    settle();
  else
    for (StepBody* body : bodies_) body->give_up();
  return report_;
}

}  // namespace tremolo
