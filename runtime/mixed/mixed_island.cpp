#include "runtime/mixed/mixed_island.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/union_find.h"
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
// GMRES solves a correction to within these fractions: as far as the method converges anyway.
constexpr double kLeastTolerance = 1e-4, kMostTolerance = 0.1;
constexpr int kMoreLinear = 3;  // of needs_factor()
constexpr int kMostLinear = 100;
// After so many corrections that do not lower the least residual it is rounding, if it is as small
// as the last resort would take.
constexpr int kStalled = 10;
// After so many of them the attempt has failed.
constexpr int kHopeless = 20;
// A correction that GMRES did not solve to this is not used. After so many of them the step has
// failed: a shorter one costs less than the rest of its attempts.
constexpr double kUsable = 0.1;
constexpr int kMostUnsolved = 6;
// Members whose residual after a whole move is at least kFarShare of the largest are solved by
// themselves, if they have at most kFewUnknowns of all unknowns: in how many rounds of a step, with
// how many moves each, until their residual has fallen by that factor.
constexpr double kFarShare = 0.1, kFewUnknowns = 0.6;
constexpr int kMostRounds = 8, kMovesAlone = 6;
constexpr double kSolvedAlone = 0.1;
// They begin at the end of the whole move, unless the residual there is that many times larger.
constexpr double kFarOff = 10.0;

}  // namespace

// All members move, or those of one group of apart_.
void MixedIsland::choose_all() {
  moves_.assign(bodies_.size(), 1);
  seen_.assign(couplings_.begin(), couplings_.end());
}

void MixedIsland::choose_group(std::size_t root) {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    moves_[i] = far_[i] != 0 && apart_[i] == root ? 1 : 0;
  seen_.clear();
  for (PairForces* coupling : couplings_)
    if (moves_[coupling->first] != 0 ||
        (coupling->second != PairForces::kNobody && moves_[coupling->second] != 0))
      seen_.push_back(coupling);
}

// Computes the residuals of the members that move. Returns their size in units of the small sizes.
double MixedIsland::evaluate(const ContactRenewal& renewal) {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0) bodies_[i]->evaluate(renewal);
  for (PairForces* coupling : seen_) coupling->shared->rate = {};
  for (PairForces* coupling : seen_) coupling->approach(renewal);
  for (PairForces* coupling : seen_) coupling->press(renewal);
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0) sizes_[i] = bodies_[i]->close();
  return size_now();
}

double MixedIsland::size_now() const {
  double square = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0) square += std::pow(sizes_[i] / enough_[i], 2);
  return std::sqrt(square);
}

// Updates the small sizes; returns the size in these units. A body at rest that another begins to
// push has a small size far below the rounding errors of the other.
double MixedIsland::measure() {
  double momentum = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (moves_[i] != 0) enough_[i] = bodies_[i]->enough();
    momentum = std::max(momentum, enough_[i] * bodies_[i]->momentum_of_size());
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0)
      enough_[i] =
          std::max(enough_[i], kLeastOfLargest * momentum / bodies_[i]->momentum_of_size());
  return size_now();
}

// Members that do not move have zeros in all vectors.
void MixedIsland::multiply(StepBody::In x, StepBody::Out rows) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (moves_[i] != 0)
      bodies_[i]->multiply(part(x, i), part(rows, i));
    else
      part(rows, i).setZero();
  }
  for (PairForces* coupling : seen_) coupling->shared->growth = 0.0;
  for (PairForces* coupling : seen_) {
    if (coupling->second == PairForces::kNobody)
      coupling->add_growth(part(x, coupling->first), empty_);
    else
      coupling->add_growth(part(x, coupling->first), part(x, coupling->second));
  }
  for (const PairForces* coupling : seen_) {
    const std::size_t a = coupling->first, b = coupling->second;
    if (b == PairForces::kNobody)
      coupling->multiply(part(x, a), empty_, part(rows, a), empty_);
    else
      coupling->multiply(part(x, a), part(x, b), part(rows, a), part(rows, b));
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (moves_[i] != 0)
      part(rows, i) /= enough_[i];
    else
      part(rows, i).setZero();
  }
}

void MixedIsland::precondition(StepBody::In rows, StepBody::Out x) {
  scaled_.head(first_.back()) = rows;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (moves_[i] == 0) {
      part(x, i).setZero();
      continue;
    }
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
  if (unsolved_ >= kMostUnsolved) return false;
  // The others take up slopes of their contacts with those that move, too.
  for (StepBody* body : bodies_) body->make_tangent(heavier, follows);
  for (PairForces* coupling : seen_) coupling->make_slopes(follows);
  const bool fresh = needs_factor(heavier);
  factored_ = -1.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (moves_[i] == 0) {
      part(residual_, i).setZero();
      continue;
    }
    if (!bodies_[i]->factor(fresh)) return false;
    bodies_[i]->residual(part(residual_, i));
    part(residual_, i) /= enough_[i];
  }
  const Index n = first_.back();
  bool solved = gmres_.solve([this](StepBody::In x, StepBody::Out rows) { multiply(x, rows); },
                             [this](StepBody::In rows, StepBody::Out x) { precondition(rows, x); },
                             residual_.head(n), tolerance_, kMostLinear, move_.head(n));
  report_.linear += gmres_.iterations();
  factored_ = heavier;
  if (fresh) first_linear_ = gmres_.iterations();
  if (!solved && gmres_.residual() <= kUsable * residual_.head(n).norm()) solved = true;
  if (!solved) ++unsolved_;
  return solved && move_.head(n).allFinite();
}

// Change of the function that the step minimises, except for rotation, along the move.
double MixedIsland::slope() const {
  double work = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0) work += bodies_[i]->work_along(part(move_, i));
  return -work;
}

double MixedIsland::go(double length, const ContactRenewal& renewal) {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0) bodies_[i]->go(length, part(move_, i));
  return evaluate(renewal);
}

// Notes the members whose residuals are the largest now. False: they have most of the unknowns, so
// that solving them by themselves would take as long as all.
bool MixedIsland::find_farthest() {
  double most = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) most = std::max(most, sizes_[i] / enough_[i]);
  far_.assign(bodies_.size(), 0);
  Index unknowns = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (!(sizes_[i] / enough_[i] > kFarShare * most)) continue;
    far_[i] = 1;
    unknowns += bodies_[i]->unknowns();
  }
  return static_cast<double>(unknowns) <= kFewUnknowns * static_cast<double>(first_.back());
}

// Same as ContactStep::try_following(). apart: the members that keep a whole move from being
// accepted are to be noted, and no shorter move is tried if there are others.
MixedIsland::Outcome MixedIsland::try_following(int iteration, double size, bool apart) {
  const ContactRenewal limits{.normals = false, .limits = 1.0};
  if (!find_move(0.0, true)) return Outcome::kFailed;
  for (double length = 1.0; length >= shortest_following(iteration); length *= 0.5) {
    const double reached = go(length, limits);
    if (reached <= following_bound(length) * size) return Outcome::kMoved;
    // Below the small size this is rounding.
    if (size <= 1.0) {
      if (!(reached <= size)) go(0.0, limits);
      return Outcome::kDone;
    }
    if (length == 1.0 && apart && std::isfinite(reached) && find_farthest()) {
      if (reached > kFarOff * size) go(0.0, limits);
      return Outcome::kApart;
    }
  }
  go(0.0, limits);
  return Outcome::kFailed;
}

// One move of Newton's method of the members that move.
MixedIsland::Outcome MixedIsland::move(int iteration, bool hold, bool apart, double& heavier) {
  evaluate(renewal(iteration, measure(), hold));
  const double size = measure();
  if (!std::isfinite(size)) return Outcome::kFailed;
  if (size <= kConverged) return Outcome::kDone;
  const double ratio = before_ > 0.0 ? size / before_ : 1.0;
  before_ = size;
  tolerance_ = std::clamp(std::max(0.1 * ratio * ratio, 0.3 * kConverged / size), kLeastTolerance,
                          kMostTolerance);
  ++report_.iterations;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (moves_[i] != 0) bodies_[i]->keep();
  if (limits_follow(iteration, size, hold))
    if (const Outcome tried = try_following(iteration, size, apart); tried != Outcome::kFailed)
      return tried;
  const auto trial = [this](double length) {
    const double next = go(length, {});
    for (std::size_t k = 0; k < bodies_.size(); ++k)
      if (moves_[k] != 0) bodies_[k]->residual(part(residual_, k));
    return LineTrial{next, slope()};
  };
  const auto find = [this](double added) { return find_move(added, false) ? slope() : 0.0; };
  LineTrial reached;
  const bool near = size <= near_rounding(hold);
  if (!newton_move(find, trial, size, near, heavier, reached) || unsolved_ >= kMostUnsolved)
    return near ? Outcome::kDone : Outcome::kFailed;
  // At rounding level no move lowers the residual.
  if (!(reached.size < 0.9 * size) && near) {
    if (reached.size > size) go(0.0, {});
    return Outcome::kDone;
  }
  return Outcome::kMoved;
}

// Solves the members of far_ while the others rest, those in contact with each other at once: a
// contact that begins to act or to slide keeps a common move of all members short.
void MixedIsland::relax(int iteration, bool hold) {
  apart_.resize(bodies_.size());
  std::iota(apart_.begin(), apart_.end(), std::size_t{0});
  for (const PairForces* coupling : couplings_) {
    const std::size_t a = coupling->first, b = coupling->second;
    if (b != PairForces::kNobody && far_[a] != 0 && far_[b] != 0) join_sets(apart_, a, b);
  }
  for (std::size_t i = 0; i < apart_.size(); ++i) apart_[i] = root_of(apart_, i);
  for (std::size_t root = 0; root < bodies_.size(); ++root) {
    if (far_[root] == 0 || apart_[root] != root) continue;
    choose_group(root);
    evaluate({});
    const double stop = std::max(1.0, kSolvedAlone * measure());
    double heavier = 0.0;
    before_ = -1.0;
    for (int k = 0; k < kMovesAlone && measure() > stop; ++k)
      if (move(iteration, hold, false, heavier) != Outcome::kMoved) break;
  }
  choose_all();
  before_ = -1.0;
}

bool MixedIsland::solve(double heavier, bool hold) {
  choose_all();
  evaluate({});
  measure();
  before_ = -1.0;
  double least = std::numeric_limits<double>::infinity();
  int stalled = 0, rounds = 0;
  for (int i = 0; i < kMostIterations; ++i) {
    const Outcome outcome = move(i, hold, rounds < kMostRounds, heavier);
    if (outcome == Outcome::kDone) return true;
    if (outcome == Outcome::kFailed) return false;
    if (outcome == Outcome::kApart) {
      ++rounds;
      relax(i, hold);
      evaluate({});
    }
    const double size = size_now();
    stalled = size < 0.9 * least ? 0 : stalled + 1;
    least = std::min(least, size);
    if (stalled > kStalled && size <= near_rounding(true)) return true;
    if (stalled > kHopeless) return false;
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
  unsolved_ = 0;
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
    moves_.assign(bodies_.size(), 1);
    do {
      report_.converged = solve(heavier, hold);
    } while (report_.converged && add_missed());
    if (report_.converged || unsolved_ >= kMostUnsolved) break;
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
