// The energy-preserving methods in lanes: against one body, against an orbit of another method, and
// by their laws.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "runtime/bodies/lanes/lane_group.h"
#include "runtime/body.h"
#include "runtime/crowd.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;
using Eigen::VectorXd;

constexpr const char* kMethods[] = {"avf", "ep2", "ep4"};

GroupOptions crowd_options(std::string_view method, double step, double alpha = 0.0,
                           double tolerance = 1e-6) {
  GroupOptions options;
  options.integrator = method;
  options.options = {.step = step, .alpha = alpha, .tolerance = tolerance};
  options.sleep.time = kNever;
  return options;
}

struct Troop {
  Crowd crowd;
  std::vector<BodyId> bodies;

  Troop(const Model::Pointer& model, const GroupOptions& options, const std::vector<State>& states,
        unsigned threads = 1)
      : crowd(std::move(*Crowd::create(threads))) {
    const GroupId group = *crowd.add_group(model, options);
    for (const State& state : states) {
      bodies.push_back(*crowd.add_body(group));
      EXPECT_TRUE(crowd.set_state(bodies.back(), state.q, state.p));
    }
  }
  void run(int steps) {
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(crowd.step().failed.empty()) << k;
  }
  State state(std::size_t body) const { return *crowd.state(bodies[body]); }
  double energy(std::size_t body) const { return crowd.energy(bodies[body])->total(); }
};

// States of the model of nine coordinates, from small to far beyond linear.
std::vector<State> crowd_states(unsigned count, double size = 1.0) {
  std::vector<State> states;
  for (unsigned b = 0; b < count; ++b)
    states.push_back({random_vector(kCrowdModes, 0.02 * size * (1 + b % 3), 100 + b),
                      random_vector(kCrowdModes, size * (1 + b % 3), 500 + b)});
  return states;
}

double difference(const State& a, const State& b) {
  return std::max((a.q - b.q).norm() / b.q.norm(), (a.p - b.p).norm() / b.p.norm());
}

// The largest difference of 11 bodies in lanes to bodies that step alone, under pushes.
double difference_to_lone(const GroupOptions& options, int steps, double nonlinearity = 0.02) {
  const Model::Pointer model = crowd_model(nonlinearity);
  const std::vector<State> states = crowd_states(11);
  Troop troop(model, options, states);
  std::vector<Body> lone;
  for (const State& state : states) {
    lone.push_back(std::move(*Body::create(model, options.integrator, options.options)));
    EXPECT_TRUE(lone.back().set_state(state.q, state.p));
  }
  for (int k = 0; k < steps; ++k) {
    if (k % 9 == 4)
      for (std::size_t b = 0; b < lone.size(); b += 2) {
        const Eigen::Vector3d force(0.5 * static_cast<double>(b), -3.0, 2.0);
        EXPECT_TRUE(troop.crowd.apply_force(troop.bodies[b], 5, force, 2));
        EXPECT_TRUE(lone[b].apply_force(5, force, 2));
      }
    troop.run(1);
    for (Body& body : lone) EXPECT_TRUE(body.step().converged);
  }
  double worst = 0.0;
  for (std::size_t b = 0; b < lone.size(); ++b)
    worst = std::max(worst, difference(troop.state(b), lone[b].state()));
  return worst;
}

// Solved to rounding, both are the same map: 100 steps of a few roundings, amplified by the stiff
// coordinates. ep4's N is that of the third correction at most, which is exact to rounding at the
// shorter step.
TEST(LanePreserving, SolvedToRoundingLanesAreTheBodysOwnMap) {
  for (const char* method : kMethods)
    for (const double alpha : {0.0, 0.3, 60.0}) {  // the last one changes the Jacobian
      const double step = method == std::string_view("ep4") ? 1e-3 : 3e-3;
      EXPECT_LE(difference_to_lone(crowd_options(method, step, alpha, 1e-13), 100), 1e-9)
          << method << " " << alpha;
    }
}

// Each of the two solves leaves at most 1e-6 of h |p| in the change of q and twice that of |p| in
// p, in each of 100 steps.
TEST(LanePreserving, LanesFollowABodyToTheTolerance) {
  for (const char* method : kMethods)
    for (const double alpha : {0.0, 0.3})
      EXPECT_LE(difference_to_lone(crowd_options(method, 3e-3, alpha), 100), 4e-4) << method;
}

// Error of 0.5 s in the strongly nonlinear state.
double error_at(std::string_view method, double alpha, int steps, const State& exact) {
  Troop troop(make_model(strong_strain_model()), crowd_options(method, 0.5 / steps, alpha, 1e-12),
              {strong_state()});
  troop.run(steps);
  return (troop.state(0).q - exact.q).norm();
}

// Against Runge and Kutta's method on the strain form of the energy, whose error at 2 000 steps is
// below 1e-9.
TEST(LanePreserving, Ep4IsOfFourthOrderAndTheOthersOfSecond) {
  for (const double alpha : {0.0, 2.0}) {
    const State exact = reference_orbit(
        strong_strain_model(), strong_state(), alpha, 0.0,
        [](double) { return VectorXd::Zero(4).eval(); }, 0.5, 2000);
    for (const char* method : kMethods) {
      const double order =
          std::log2(error_at(method, alpha, 100, exact) / error_at(method, alpha, 200, exact));
      EXPECT_NEAR(order, method == std::string_view("ep4") ? 4.0 : 2.0, 0.2) << method << alpha;
    }
  }
}

// The residual of the solve is given back, so that a step leaves a few roundings of the energy;
// they may all have one sign.
TEST(LanePreserving, EnergyStaysToRounding) {
  for (const char* method : kMethods) {
    Troop troop(crowd_model(), crowd_options(method, 3e-3), crowd_states(9));
    std::vector<double> before;
    for (std::size_t b = 0; b < 9; ++b) before.push_back(troop.energy(b));
    troop.run(2000);
    for (std::size_t b = 0; b < 9; ++b)
      EXPECT_NEAR(troop.energy(b) / before[b], 1.0, 2000 * 1e-15) << method;
  }
}

// H1 - H0 = work - dissipated, step by step, for a load that changes with each step.
TEST(LanePreserving, DampingAndLoadsBalanceTheEnergyToRounding) {
  const Model::Pointer model = crowd_model();
  const auto r = static_cast<std::size_t>(kCrowdModes);
  PotentialWorkspace workspace = model->potential().make_workspace();
  Evaluation evaluation = model->potential().make_evaluation();
  const auto energy = [&](const State& state) {
    model->potential().evaluate(state.q, kWantEnergy, workspace, evaluation);
    return evaluation.energy + 0.5 * state.p.squaredNorm();
  };
  for (const char* method : kMethods)
    for (const double alpha : {0.3, 60.0}) {
      Result<LaneGroup> lanes = LaneGroup::create(model, method, {.step = 3e-3, .alpha = alpha}, r,
                                                  LanePrecision::kDouble);
      ASSERT_TRUE(lanes);
      LaneScratch scratch;
      lanes->make_scratch(scratch);
      State now = crowd_states(1)[0];
      std::vector<double> saved;
      for (const VectorXd& part : {now.q, now.p, now.q, now.p})
        saved.insert(saved.end(), part.begin(), part.end());
      EnergyBound bound;
      bound.restart();
      lanes->insert(saved.data(), bound);
      double largest = energy(now), sum = 0.0;
      const double start = largest;
      for (int k = 0; k < 200; ++k) {
        const VectorXd force = random_vector(kCrowdModes, 3.0, 40 + static_cast<unsigned>(k));
        lanes->add_force(0, force.data());
        EXPECT_EQ(lanes->step_block(0, {.since_last = k % 8 == 7 ? 8 : 0}, scratch).failed, 0u);
        State next = now;
        lanes->read(0, next.q.data(), next.p.data());
        EXPECT_GT(lanes->dissipated(0), 0.0);
        sum += force.dot(next.q - now.q) - lanes->dissipated(0);
        now = next;
        largest = std::max(largest, energy(now));
        EXPECT_NEAR(energy(now) - start, sum, 1e-13 * largest) << method << " " << k;
      }
    }
}

// ep4's N is that of the midpoint to a share of the tolerance; the others are reversible exactly.
TEST(LanePreserving, MotionRunsBackWhenMomentaAreReversed) {
  for (const char* method : kMethods) {
    const std::vector<State> start = crowd_states(3);
    Troop troop(crowd_model(), crowd_options(method, 3e-3, 0.0, 1e-13), start);
    troop.run(100);
    for (std::size_t b = 0; b < 3; ++b) {
      const State end = troop.state(b);
      EXPECT_TRUE(troop.crowd.set_state(troop.bodies[b], end.q, -end.p));
    }
    troop.run(100);
    for (std::size_t b = 0; b < 3; ++b) {
      State end = troop.state(b);
      end.p = -end.p;
      EXPECT_LE(difference(end, start[b]), 1e-8) << method;
    }
  }
}

// A body that is far beyond what the lanes' solve can do is stepped alone, as that body would be;
// the others keep their bits.
TEST(LanePreserving, ALaneThatNeedsTheSolverOfOneBodyDoesNotChangeTheOthers) {
  const Model::Pointer model = crowd_model(0.3);
  std::vector<State> states = crowd_states(8);
  Troop calm(model, crowd_options("ep4", 3e-3), states);
  states[3].q *= 40.0;
  states[3].p *= 300.0;
  Troop wild(model, crowd_options("ep4", 3e-3), states);
  Result<Body> body = Body::create(model, "ep4", {.step = 3e-3});
  ASSERT_TRUE(body);
  ASSERT_TRUE(body->set_state(states[3].q, states[3].p));
  const double before = wild.energy(3);
  int corrections = 0;  // of that body
  for (int k = 0; k < 50; ++k) {
    calm.run(1);
    wild.run(1);
    const StepReport report = body->step();
    ASSERT_TRUE(report.converged);
    corrections += report.iterations;
  }
  EXPECT_GT(corrections, 50 * 4);  // it is one that needs more than the lanes do
  EXPECT_NEAR(wild.energy(3) / before, 1.0, 1e-10);
  for (const std::size_t b : {0u, 1u, 2u, 4u, 5u, 6u, 7u}) {
    EXPECT_EQ(calm.state(b).q, wild.state(b).q) << b;
    EXPECT_EQ(calm.state(b).p, wild.state(b).p) << b;
  }
}

// Its lane, its block and the thread may change, and so may the lanes next to it.
TEST(LanePreserving, ABodysBitsDependNeitherOnTheOthersNorOnThreads) {
  for (const char* method : kMethods)
    for (const LanePrecision precision : {LanePrecision::kDouble, LanePrecision::kFloat}) {
      GroupOptions options = crowd_options(method, 3e-3, 0.3);
      options.precision = precision;
      const std::vector<State> states = crowd_states(37);
      Troop alone(crowd_model(), options, {states[35], states[36]});
      Troop troop(crowd_model(), options, states, 3);
      std::mt19937 random(5);
      for (int k = 0; k < 60; ++k) {
        for (int change = 0; change < 6; ++change) {
          const BodyId other = troop.bodies[random() % 35];
          ASSERT_TRUE(random() % 2 == 0 ? troop.crowd.sleep(other) : troop.crowd.wake(other));
        }
        alone.run(1);
        troop.run(1);
      }
      for (const std::size_t b : {0u, 1u}) {
        EXPECT_EQ(alone.state(b).q, troop.state(35 + b).q) << method;
        EXPECT_EQ(alone.state(b).p, troop.state(35 + b).p) << method;
      }
    }
}

// Float lanes keep the energy of the exact potential to a few thousand of their roundings, 6e-8 of
// the nonlinear force each.
TEST(LanePreserving, FloatLanesKeepTheEnergyToFloatRounding) {
  for (const char* method : kMethods) {
    GroupOptions options = crowd_options(method, 3e-3);
    options.precision = LanePrecision::kFloat;
    Troop troop(crowd_model(), options, crowd_states(17));
    std::vector<double> before;
    for (std::size_t b = 0; b < 17; ++b) before.push_back(troop.energy(b));
    troop.run(500);
    for (std::size_t b = 0; b < 17; ++b)
      EXPECT_NEAR(troop.energy(b) / before[b], 1.0, 500 * 6e-8) << method;
  }
}

}  // namespace
}  // namespace tremolo
