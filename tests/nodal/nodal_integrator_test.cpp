// The integrators of masses in space against closed forms on linear springs: what a step does to an
// oscillation, the order, energies, fixed nodes that move, steps that fail.
#include "runtime/step/nodal_integrator.h"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "runtime/step/halved_step.h"
#include "tests/support/linear_nodes.h"
#include "tests/support/nodal_orders.h"

namespace tremolo {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::VectorXd;
using testing::LinearNodes;

std::unique_ptr<NodalIntegrator> made(std::string_view name, const NodalSystem& system, double step,
                                      double tolerance = 1e-13) {
  NodalOptions options;
  options.step = step;
  options.tolerance = tolerance;
  auto integrator = make_nodal_integrator(name, system, options);
  EXPECT_TRUE(integrator) << name;
  return std::move(*integrator);
}

NodalState start(const VectorXd& x, const VectorXd& v) {
  return {x, v, 0.0};
}

// (x, v) of one coordinate after a step, for omega = 1 / s; the other two stay at rest.
Matrix2d step_matrix(std::string_view name, double y) {
  const LinearNodes nodes = LinearNodes::oscillator(1.0, 0.0, 1.0);
  Matrix2d matrix;
  for (Eigen::Index column = 0; column < 2; ++column) {
    NodalState state = start(VectorXd::Zero(3), VectorXd::Zero(3));
    (column == 0 ? state.x : state.v)[0] = 1.0;
    const auto integrator = made(name, nodes, y);
    EXPECT_TRUE(integrator->step(state).made) << name;
    matrix.col(column) << state.x[0], state.v[0];
  }
  return matrix;
}

double spectral_radius(const Matrix2d& a) {
  const std::complex<double> half = 0.5 * a.trace();
  const std::complex<double> root = std::sqrt(half * half - a.determinant());
  return std::max(std::abs(half + root), std::abs(half - root));
}

TEST(NodalIntegrators, DampAndGrowOneOscillationAsTheirClosedFormsSay) {
  for (const double y : {0.1, 0.7, 1.3, 1.9, 2.6}) {
    const double square = y * y;
    const std::complex<double> iy(0.0, y);
    const double rk4 =
        std::abs(1.0 + iy + iy * iy / 2.0 + iy * iy * iy / 6.0 + iy * iy * iy * iy / 24.0);
    const std::pair<std::string_view, double> forms[] = {
        {"explicit-euler", std::sqrt(1.0 + square)},
        {"explicit-midpoint", std::sqrt(1.0 + 0.25 * square * square)},
        {"rk4", rk4},
        {"implicit-euler", 1.0 / std::sqrt(1.0 + square)},
        {"implicit-euler-linear", 1.0 / std::sqrt(1.0 + square)},
        {"midpoint", 1.0},
        {"newmark", 1.0},
        {"energy", 1.0}};
    for (const auto& [name, form] : forms)
      EXPECT_NEAR(spectral_radius(step_matrix(name, y)), form, 1e-12) << name << " " << y;
    const double symplectic = spectral_radius(step_matrix("symplectic-euler", y));
    if (y < 2.0)
      EXPECT_NEAR(symplectic, 1.0, 1e-12);
    else
      EXPECT_GT(symplectic, 1.5);
  }
  EXPECT_EQ(stability_number("symplectic-euler"), 2.0);
  EXPECT_EQ(stability_number("rk4"), 2.0 * std::numbers::sqrt2);
  for (const std::string_view name : {"symplectic-euler", "rk4", "implicit-euler-sweep"}) {
    const double limit = stability_number(name);
    EXPECT_LE(spectral_radius(step_matrix(name, 0.999 * limit)), 1.0 + 1e-12) << name;
    EXPECT_GT(spectral_radius(step_matrix(name, 1.001 * limit)), 1.0 + 1e-6) << name;
  }
  EXPECT_LE(spectral_radius(step_matrix("rk4", 2.0 * std::numbers::sqrt2 * 0.999)), 1.0);
  EXPECT_GT(spectral_radius(step_matrix("rk4", 2.0 * std::numbers::sqrt2 * 1.001)), 1.0);
}

// x(t) = e^(-z t) (cos w t + z/w sin w t) for x'' + 2 z x' + o^2 x = 0 from (1, 0).
double damped_error(std::string_view name, double step) {
  const double omega = 3.0, zeta = 0.4;
  const LinearNodes nodes = LinearNodes::oscillator(omega * omega, 2.0 * zeta, 1.0);
  NodalState state = start(VectorXd::Ones(3), VectorXd::Zero(3));
  const auto integrator = made(name, nodes, step);
  const int steps = static_cast<int>(std::lround(2.0 / step));
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(integrator->step(state).made);
  const double t = 2.0, w = std::sqrt(omega * omega - zeta * zeta);
  const double exact = std::exp(-zeta * t) * (std::cos(w * t) + zeta / w * std::sin(w * t));
  const double speed = -std::exp(-zeta * t) * omega * omega / w * std::sin(w * t);
  return std::hypot(omega * (state.x[0] - exact), state.v[0] - speed);
}

TEST(NodalIntegrators, HaveTheOrderOfTheirNamesOnADampedOscillation) {
  EXPECT_EQ(std::size(testing::kNodalOrders), nodal_integrator_names().size());
  for (const auto& [name, order] : testing::kNodalOrders) {
    const double coarse = damped_error(name, 0.01), fine = damped_error(name, 0.005);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.12) << name;
  }
}

TEST(NodalIntegrators, TellWhereTheEnergyWentAndEnergyLosesNone) {
  LinearNodes nodes = LinearNodes::random(5, 30.0, 2e-3, 7);
  nodes.holds[2] = 1;
  nodes.way = 0.3;
  for (const std::string_view name : nodal_integrator_names()) {
    if (stability_number(name) == 0.0) continue;
    NodalState state = start(VectorXd::Constant(15, 0.1), VectorXd::Zero(15));
    nodes.put_held(0.0, state.x);
    const auto integrator = made(name, nodes, 2e-3);
    const double before = nodes.potential(state.x) + free_kinetic(nodes, state.v);
    NodalReport sum;
    double largest = 0.0;
    for (int k = 0; k < 500; ++k) {
      const NodalReport report = integrator->step(state);
      ASSERT_TRUE(report.made) << name << k;
      sum.damped += report.damped;
      sum.held_work += report.held_work;
      sum.numerical += report.numerical;
      largest = std::max(largest, std::abs(report.numerical));
    }
    EXPECT_EQ(state.x[6], nodes.way * state.time);
    const double after = nodes.potential(state.x) + free_kinetic(nodes, state.v);
    EXPECT_NEAR(after - before, sum.held_work - sum.damped + sum.numerical, 1e-11 * before) << name;
    EXPECT_GT(sum.damped, 0.01 * before) << name;
    // The midpoint rule is the same for a linear system.
    if (name == "energy" || name == "midpoint") {
      EXPECT_LE(largest, 1e-13 * before) << name;
    }
    if (name == "implicit-euler") {
      EXPECT_LT(sum.numerical, -1e-3 * before);
    }
  }
}

TEST(NodalIntegrators, StepBackwardsReturnWhereTheMethodIsSymmetric) {
  const LinearNodes nodes = LinearNodes::random(4, 30.0, 0.0, 3);
  for (const std::string_view name : {"midpoint", "newmark", "energy", "imex"}) {
    NodalState state = start(VectorXd::Constant(12, 0.1), VectorXd::LinSpaced(12, -1.0, 1.0));
    const NodalState first = state;
    const auto integrator = made(name, nodes, 5e-3);
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(integrator->step(state).made);
    state.v = -state.v;
    integrator->reset();
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(integrator->step(state).made);
    EXPECT_LE((state.x - first.x).norm(), 1e-9) << name;
    EXPECT_LE((state.v + first.v).norm(), 1e-8) << name;
  }
}

TEST(NodalIntegrators, FactorsAndConjugateGradientsGiveTheSame) {
  const LinearNodes nodes = LinearNodes::random(6, 300.0, 1e-3, 5);
  VectorXd ends[2];
  for (int kind = 0; kind < 2; ++kind) {
    NodalOptions options;
    options.step = 0.02;
    options.tolerance = 1e-11;
    options.solver = kind == 0 ? NodalSolver::kCholesky : NodalSolver::kConjugateGradients;
    NodalState state = start(VectorXd::Constant(18, 0.1), VectorXd::Zero(18));
    const auto integrator = std::move(*make_nodal_integrator("implicit-euler", nodes, options));
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(integrator->step(state).made);
    ends[kind] = state.x;
  }
  EXPECT_LE((ends[0] - ends[1]).norm(), 1e-10 * ends[0].norm());
}

// Counts what is evaluated; its weight may be changed between steps.
struct Counted : LinearNodes {
  explicit Counted(const LinearNodes& nodes) : LinearNodes(nodes) {}
  mutable int potentials = 0, forces = 0;
  double weight = 0.0;
  std::optional<std::uint64_t> version = 0;

  double potential(const VectorXd& x) const override {
    ++potentials;
    return LinearNodes::potential(x) - weight * x.sum();
  }
  void force(const VectorXd& x, const VectorXd& v, ForcePart part, VectorXd& f) const override {
    ++forces;
    LinearNodes::force(x, v, part, f);
    f.array() += weight;
  }
  std::optional<std::uint64_t> potential_version() const override { return version; }
};

TEST(NodalIntegrators, EvaluateThePotentialOnceAStepAndNotAtAllWhereNobodyAsks) {
  for (const bool account : {true, false}) {
    Counted nodes(LinearNodes::random(3, 30.0, 1e-3, 5));
    NodalOptions options;
    options.step = 1e-3;
    options.account = account;
    const auto integrator = std::move(*make_nodal_integrator("symplectic-euler", nodes, options));
    NodalState state = start(VectorXd::Constant(9, 0.1), VectorXd::Zero(9));
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(integrator->step(state).made);
    EXPECT_EQ(nodes.forces, 10);
    EXPECT_EQ(nodes.potentials, account ? 11 : 0);
    // A system that does not say whether its potential changes.
    nodes.version.reset();
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(integrator->step(state).made);
    EXPECT_EQ(nodes.potentials, account ? 31 : 0);
  }
}

TEST(NodalIntegrators, AWeightThatChangesBetweenStepsIsNotTakenForTheMethodsOwnEnergy) {
  Counted nodes(LinearNodes::random(3, 30.0, 0.0, 5));
  const auto integrator = made("midpoint", nodes, 1e-2);
  NodalState state = start(VectorXd::Constant(9, 0.1), VectorXd::Zero(9));
  for (int k = 0; k < 20; ++k) {
    nodes.weight = 0.3 * k;
    nodes.version = static_cast<std::uint64_t>(k);
    const NodalReport report = integrator->step(state);
    ASSERT_TRUE(report.made);
    // The midpoint rule adds rounding alone to some 10 J of a linear system.
    EXPECT_LE(std::abs(report.numerical), 1e-12) << k;
  }
  // Broken on purpose: without the notice the change of weight looks like the method's.
  nodes.weight += 5.0;
  EXPECT_GT(std::abs(integrator->step(state).numerical), 1e-3);
}

// A force that is not a number beyond a position, so that long steps fail.
struct Edge : LinearNodes {
  using LinearNodes::LinearNodes;
  double edge = 1.0;
  void force(const VectorXd& x, const VectorXd& v, ForcePart part, VectorXd& f) const override {
    LinearNodes::force(x, v, part, f);
    if (x.maxCoeff() > edge) f.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
};

TEST(NodalIntegrators, AStepThatFailsIsTakenInPartsOrLeavesTheStateAsItWas) {
  Edge nodes{Eigen::MatrixXd::Identity(3, 3), Eigen::MatrixXd::Zero(3, 3), VectorXd::Ones(1)};
  // The guess of a long step is beyond the edge, its end is not.
  NodalState state = start(VectorXd::Constant(3, 0.5), VectorXd::Constant(3, 0.6));
  const auto integrator = made("midpoint", nodes, 2.0);
  NodalReport report = integrator->step(state);
  ASSERT_TRUE(report.made);
  EXPECT_GT(report.parts, 1);
  EXPECT_DOUBLE_EQ(state.time, 2.0);
  nodes.edge = -5.0;
  const NodalState before = state;
  report = integrator->step(state);
  EXPECT_FALSE(report.made);
  EXPECT_EQ(state.x, before.x);
  EXPECT_EQ(state.v, before.v);
  EXPECT_EQ(state.time, before.time);
}

TEST(NodalIntegrators, ANodeThatIsLetGoFallsUnderEveryMethod) {
  for (const std::string_view name : nodal_integrator_names()) {
    LinearNodes nodes = LinearNodes::oscillator(1.0, 0.0, 1.0);
    nodes.holds[0] = 1;
    nodes.rest.setOnes();
    NodalState state = start(nodes.rest, VectorXd::Zero(3));
    const auto integrator = made(name, nodes, 0.1);
    ASSERT_TRUE(integrator->step(state).made) << name;
    EXPECT_EQ(state.x, nodes.rest) << name;
    nodes.holds[0] = 0;
    nodes.rest.setZero();
    integrator->reset();
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(integrator->step(state).made) << name;
    EXPECT_LT(state.x[0], 0.99) << name;
  }
}

// A floor at x = 0 that pushes one mass back as a spring does, -k x, in a step that would end below
// it. It is linear in the step's end, so that one Newton step finds it. It stores the impulse of
// the last part of a step.
struct Floor : NodalContact {
  double k = 400.0;      // N/m
  double impulse = 0.0;  // N s, of the last part of a step
  bool below = false;
  double push(double x) const { return below ? -k * x : 0.0; }
  void start() override { below = false; }
  bool revise(const VectorXd&, const VectorXd& x1, double) override {
    if (below || x1[0] >= 0.0) return false;
    return below = true;
  }
  void add_force(const VectorXd& x1, VectorXd& f) const override { f[0] += push(x1[0]); }
  void add_tangent(BlockMatrix& a) const override { a.diagonal(0)(0, 0) += below ? k : 0.0; }
  double work(const VectorXd& x0, const VectorXd& x1, double share) const override {
    return share * push(x1[0]) * (x1[0] - x0[0]);
  }
  void keep(const VectorXd& x1, double h, double share) override {
    impulse = share * h * push(x1[0]);
  }
  bool pressed() const override { return impulse != 0.0; }
};

struct AboveFloor : LinearNodes {
  mutable Floor floor;
  AboveFloor() : LinearNodes(oscillator(0.0, 0.0, 2.0)) {}
  NodalContact* contact() const override { return &floor; }
};

// Nothing but the floor acts, so what the mass gained in momentum is the impulse, and the energy
// that the floor gave is force times displacement: (impulse / h) (x1 - x0).
TEST(NodalIntegrators, ReactionsAreToldByTheMomentumThatTheyGave) {
  const double h = 0.05, m = 2.0;
  for (const std::string_view name : nodal_integrator_names()) {
    if (std::isfinite(stability_number(name)) && name != "imex") continue;  // no solve, no floor
    const AboveFloor nodes;
    const auto integrator = made(name, nodes, h);
    NodalState state = start(VectorXd::Zero(3), VectorXd::Zero(3));
    state.x[0] = 0.12;
    state.v[0] = -1.0;
    int pressed = 0;
    for (int k = 0; k < 10; ++k) {
      const NodalState before = state;
      const NodalReport report = integrator->step(state);
      ASSERT_TRUE(report.made) << name << k;
      ASSERT_EQ(report.parts, 1) << name << k;
      const double impulse = m * (state.v[0] - before.v[0]);
      const double kinetic = 0.5 * m * (state.v.squaredNorm() - before.v.squaredNorm());
      EXPECT_NEAR(nodes.floor.impulse, impulse, 1e-12) << name << k;
      EXPECT_NEAR(report.pressed, impulse / h * (state.x[0] - before.x[0]), 1e-11) << name << k;
      EXPECT_NEAR(report.numerical, kinetic - report.pressed, 1e-12) << name << k;
      pressed += impulse > 0.0 ? 1 : 0;
    }
    EXPECT_GE(pressed, 2) << name;
    EXPECT_GT(state.v[0], 0.3) << name;
  }
}

TEST(NodalIntegrators, WrongOptionsAreNamed) {
  const LinearNodes nodes = LinearNodes::oscillator(1.0, 0.0, 1.0);
  NodalOptions options;
  EXPECT_NE(make_nodal_integrator("euler", nodes, options).error().message.find("bdf2"),
            std::string::npos);
  options.step = -1.0;
  EXPECT_FALSE(make_nodal_integrator("rk4", nodes, options));
  options.step = 1.0;
  options.tolerance = 0.0;
  EXPECT_FALSE(make_nodal_integrator("rk4", nodes, options));
}

TEST(NodalSpectrum, LanczosFindsTheLargestEigenvalue) {
  LinearNodes nodes = LinearNodes::random(12, 20.0, 0.0, 11);
  nodes.holds[3] = 1;
  Eigen::MatrixXd scaled = nodes.K;
  for (Eigen::Index i = 0; i < 36; ++i)
    for (Eigen::Index j = 0; j < 36; ++j)
      scaled(i, j) *= i / 3 == 3 || j / 3 == 3
                          ? 0.0
                          : 1.0 / std::sqrt(nodes.masses[i / 3] * nodes.masses[j / 3]);
  const double exact =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues().maxCoeff();
  EXPECT_NEAR(largest_eigenvalue(nodes, nodes.rest, ForcePart::kAll, 1e-10), exact, 1e-9 * exact);
  EXPECT_NEAR(largest_eigenvalue(nodes, nodes.rest, ForcePart::kSoft), 0.1 * exact, 1e-4 * exact);
}

}  // namespace
}  // namespace tremolo
