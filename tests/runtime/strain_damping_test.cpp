// Stiffness damping by the rates of the strains: its force, what it takes in a step, what it leaves
// alone, and what happens to models that do not know their strains.
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "runtime/body.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using namespace testing;
using Eigen::VectorXd;

// All of the damping force of beta = 1: the rest and that of the linear terms.
VectorXd damping_of(StrainDamping& damping, const StrainModel& strain, const VectorXd& q,
                    const VectorXd& v) {
  VectorXd force(q.size());
  const double power = damping.force_at(q, v, force);
  EXPECT_NEAR(power, v.dot(force), 1e-12 * force.norm() * v.norm());
  return force + strain.omega.cwiseAbs2().cwiseProduct(v);
}

// Sizes on both sides of each length of a vector.
TEST(StrainMatrixKernel, TheForceIsThatOfTheStrainsRatesForEveryNumberOfCoordinates) {
  for (Eigen::Index r = 1; r <= 41; ++r) {
    const StrainModel strain = random_strain_model(spread_omega(r, 3.0, 400.0), 0.5, 11);
    const Model::Pointer model = make_model(strain);
    ASSERT_TRUE(model->strain_matrix());
    StrainDamping damping(*model, 1.0);
    const VectorXd q = random_vector(r, 0.6, 1), v = random_vector(r, 2.0, 2);
    const VectorXd expected = strain_damping_force(strain, q, v);
    // Sums of up to 900 products.
    EXPECT_LE((damping_of(damping, strain, q, v) - expected).norm(), 1e-12 * expected.norm()) << r;
  }
}

TEST(StrainDamping, LeadingCoordinatesTakeThePartOfTheMatrixThatIsTheirs) {
  const StrainModel strain = random_strain_model(spread_omega(7, 3.0, 90.0), 0.5, 12);
  const BasisData data = sample_basis(strain);
  for (int modes = 1; modes <= 7; ++modes) {
    const auto model = Model::from_data(data, {.modes = modes});
    ASSERT_TRUE(model);
    ASSERT_TRUE((*model)->strain_matrix());
    StrainDamping damping(**model, 1.0);
    VectorXd q = random_vector(7, 0.5, 3), v = random_vector(7, 1.0, 4);
    q.tail(7 - modes).setZero();
    v.tail(7 - modes).setZero();
    VectorXd force(modes);
    damping.force(q.head(modes), v.head(modes), force);
    force += (*model)->lambda().cwiseProduct(v.head(modes));
    const VectorXd expected = strain_damping_force(strain, q, v).head(modes);
    EXPECT_LE((force - expected).norm(), 1e-13 * expected.norm()) << modes;
  }
}

// Two coordinates on a circle through the origin keep the strain omega q0 + b (q0^2 + q1^2) at
// zero; a third vibrates.
StrainModel circle(double omega) {
  StrainModel strain = random_strain_model(Eigen::Vector3d(1e-3, omega, 2 * omega), 0.0, 1);
  strain.b[1](0, 0) = strain.b[1](1, 1) = 0.5 * omega;
  return strain;
}

TEST(StrainDamping, AMotionThatDoesNotStrainIsNotDamped) {
  const StrainModel strain = circle(50.0);
  const Model::Pointer model = make_model(strain);
  ASSERT_TRUE(model->strain_matrix());
  for (const double tolerance : {0.0, 1e-6}) {
    StrainDamping damping(*model, 1.0, tolerance);
    for (double angle = 0.0; angle < 6.0; angle += 0.3) {
      const Eigen::Vector3d q(std::sin(angle), std::cos(angle) - 1.0, 0.0);
      const Eigen::Vector3d v(std::cos(angle), -std::sin(angle), 0.0);
      // The soft strain of 1e-3 rad/s is all that is left of 2500.
      EXPECT_LE(damping_of(damping, strain, q, v).norm(), 2e-6 + 1e-12) << angle;
    }
  }
}

// The leading r coordinates of a model with `more`: the strains of the others are quadratic in
// them, so that no coordinate cancels these.
Model::Pointer make_leading(const StrainModel& strain, int r) {
  const auto model = Model::from_data(sample_basis(strain), {.modes = r});
  EXPECT_TRUE(model && (*model)->strain_matrix());
  return *model;
}

TEST(StrainDampingInFloat, TheForceHasTheRoundingOfFloatForEveryNumberOfCoordinates) {
  for (int r = 1; r <= 41; ++r) {
    const StrainModel strain = random_strain_model(spread_omega(r + 6, 3.0, 400.0), 0.5, 13);
    const Model::Pointer model = make_leading(strain, r);
    StrainDamping exact(*model, 1.0), quick(*model, 1.0, 1e-6);
    StrainModel positive = strain;
    for (auto& b : positive.b) b = b.cwiseAbs();
    // Of q and of v: a damped body becomes slower and smaller for as long as it is stepped.
    for (const auto& [shape, size] : {std::pair{0.6, 0.6},
                                      {0.6, 1e-30},
                                      {0.6, 1e30},
                                      {2e-20, 0.6},
                                      {5e-21, 0.6},
                                      {1e-60, 1e-60},
                                      {0.6, 1e-299}}) {
      VectorXd q = VectorXd::Zero(r + 6), v = q;
      q.head(r) = random_vector(r, shape, 5);
      v.head(r) = random_vector(r, size, 6);
      VectorXd expected(r), force(r);
      exact.force(q.head(r), v.head(r), expected);
      const double power = quick.force(q.head(r), v.head(r), force);
      EXPECT_NEAR(power, v.head(r).dot(force), 1e-12 * force.norm() * v.norm());
      // A coefficient, a rate, their product and a sum are each rounded by 2^-24 of the terms
      // without their signs.
      const double terms =
          strain_damping_force(positive, q.cwiseAbs(), v.cwiseAbs()).head(r).norm();
      EXPECT_LE((force - expected).norm(), std::ldexp(4.0, -24) * terms)
          << r << ", " << shape << ", " << size;
    }
  }
}

// Three strains that are quadratic in nine soft coordinates: six directions at each q do not
// strain them.
TEST(StrainDampingInFloat, NoVelocityGainsEnergyByRounding) {
  constexpr Eigen::Index kSoft = 9, kStrains = 3;
  VectorXd omega = VectorXd::LinSpaced(kSoft + kStrains, 1.0, 2.0);
  omega.head(kSoft) *= 1e-10;
  StrainModel strain = random_strain_model(omega, 1.0, 14);
  for (Eigen::Index e = 0; e < kSoft; ++e) strain.b[e].setZero();
  const Model::Pointer model = make_leading(strain, kSoft);
  StrainDamping damping(*model, 1.0, 1e-6);
  int rounded_away = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const VectorXd q = random_vector(kSoft, 1.0, seed);
    Eigen::MatrixXd rates(kStrains, kSoft);
    for (Eigen::Index e = 0; e < kStrains; ++e)
      rates.row(e) = 2.0 * (strain.b[kSoft + e].topLeftCorner(kSoft, kSoft) * q).transpose();
    VectorXd v = random_vector(kSoft, 1.0, 300 + seed);
    v -= rates.transpose() * (rates * rates.transpose()).ldlt().solve(rates * v);
    VectorXd force(kSoft);
    const double power = damping.force(q, v, force) + v.dot(model->lambda().cwiseProduct(v));
    EXPECT_GE(power, -1e-15 * rates.norm() * v.norm()) << seed;
    if (power < 1e-15) ++rounded_away;
  }
  EXPECT_GT(rounded_away, 20);  // without the bound these would gain energy
}

TEST(StrainDampingInFloat, ARunClosesItsEnergyAndFollowsTheExactOneInAsManyCorrections) {
  constexpr int kModes = 8;
  const StrainModel strain = random_strain_model(spread_omega(kModes + 6, 20.0, 600.0), 0.5, 15);
  const Model::Pointer model = make_leading(strain, kModes);
  const auto energy = [&](const State& s) {
    VectorXd q = VectorXd::Zero(kModes + 6);
    q.head(kModes) = s.q;
    return 0.5 * s.p.squaredNorm() + strain_energy(strain, q);
  };
  for (const char* name : {"avf", "ep2", "ep4", "newmark", "midpoint"}) {
    // The tolerances on both sides of the one from which on float is used.
    State ends[2];
    int corrections[2] = {};
    for (const bool quick : {false, true}) {
      const double tolerance = kQuickTolerance * (quick ? 1.0 : 0.999);
      const auto integrator =
          make(name, model, {.step = 2e-3, .beta = 3e-4, .tolerance = tolerance, .halvings = 0});
      State state{random_vector(kModes, 0.02, 7), random_vector(kModes, 5.0, 8)};
      const double start = energy(state);
      StepLoad load = make_step_load(kModes);
      double dissipated = 0.0;
      for (int k = 0; k < 300; ++k) {
        const StepReport report = integrator->step(state, load);
        ASSERT_TRUE(report.converged) << name;
        dissipated += report.dissipated;
        corrections[quick ? 1 : 0] += report.iterations;
      }
      ends[quick ? 1 : 0] = state;
      EXPECT_LT(energy(state), 0.9 * start) << name;
      if (name[0] != 'n' && name[0] != 'm') {
        EXPECT_NEAR(energy(state) + dissipated, start, 1e-13 * start) << name;
      }
    }
    EXPECT_NEAR(corrections[0], corrections[1], 0.02 * corrections[0]) << name;
    // The tolerance of 300 steps, which leave the orbits apart anyway.
    EXPECT_LE((ends[0].q - ends[1].q).norm(), 300 * kQuickTolerance * ends[0].q.norm()) << name;
  }
}

// The strains y(q) of the model: omega_e q_e + q^T B_e q.
VectorXd strains_at(const StrainModel& model, const VectorXd& q) {
  VectorXd strains(q.size());
  for (Eigen::Index e = 0; e < q.size(); ++e)
    strains[e] = model.omega[e] * q[e] + q.dot(model.b[e] * q);
  return strains;
}

// theta's part is never negative and known for small h D: theta h D Dp^2, theta = 1/12 at most 1/4.
TEST(StrainDamping, AnEnergyPreservingStepTakesTheSquareOfTheStrainsChange) {
  const StrainModel strain = strong_strain_model();
  const Model::Pointer model = make_model(strain);
  for (const char* name : {"avf", "ep2", "ep4"})
    for (const double beta : {1e-6, 1e-3, 1.0}) {
      const IntegratorOptions options{.step = 5e-3, .beta = beta};
      const auto integrator = make(name, model, options);
      State state = strong_state();
      StepLoad load = make_step_load(4);
      for (int k = 0; k < 100; ++k) {
        const State before = state;
        const StepReport report = integrator->step(state, load);
        ASSERT_TRUE(report.converged);
        const double taken =
            beta / options.step *
            (strains_at(strain, state.q) - strains_at(strain, before.q)).squaredNorm();
        const VectorXd dp = state.p - before.p;
        const double most = 0.25 * options.step * beta * dp.cwiseAbs2().dot(model->lambda());
        EXPECT_GE(report.dissipated, taken * (1.0 - 1e-6) - 1e-15) << name << ", " << beta;
        EXPECT_LE(report.dissipated, taken * (1.0 + 1e-6) + most + 1e-15) << name << ", " << beta;
      }
    }
}

// Energy left after 6 halves of a period about zero of a pendulum of a soft spring on a stiff rod.
// q0 swings, q1 follows on a circle of radius one: what is stiff does not strain.
TEST(StrainDamping, TheDecayOfASwingDoesNotDependOnHowFarItGoes) {
  StrainModel strain = circle(300.0);
  strain.omega[0] = 10.0;
  const Model::Pointer model = make_model(strain);
  const double beta = 2.0 * 0.02 / 10.0;  // 2 % of critical
  for (const char* name : {"ep4", "ep2", "newmark", "midpoint"})
    for (const double velocity : {0.1, 1.0, 2.0}) {
      const auto integrator = make(name, model, {.step = 1e-3, .beta = beta});
      State state{VectorXd::Zero(3), Eigen::Vector3d(velocity, 0.0, 0.0)};
      StepLoad load = make_step_load(3);
      const auto energy = [&] {
        return 0.5 * state.p.squaredNorm() + strain_energy(strain, state.q);
      };
      const double start = energy();
      double time = 0.0;
      for (int crossings = 0; crossings < 6; time += 1e-3) {
        const double q = state.q[0];
        ASSERT_TRUE(integrator->step(state, load).converged);
        if (time > 0.0 && (q < 0.0) != (state.q[0] < 0.0)) ++crossings;
      }
      // A swing of 0.2 of the radius has a period longer by a hundredth and a path longer than its
      // chord: 2 %, the bound that bodies have to keep too.
      EXPECT_NEAR(energy() / start, std::exp(-12.0 * 3.14159265 * 0.02), 0.02 * 0.47)
          << name << ", " << velocity;
    }
}

// The pendulum again, its rod now stiff: h omega is 6 at 2 ms, and its damping is far beyond
// critical, so that q1 only follows. Its inertia is that of the swing.
TEST(StrainDamping, AStiffCoordinateThatFollowsOthersLeavesTheOrder) {
  StrainModel strain = circle(3000.0);
  strain.omega[0] = 10.0;
  const Model::Pointer model = make_model(strain);
  const auto end_of = [&](std::string_view name, double step) {
    const auto integrator = make(name, model, {.step = step, .beta = 4e-3, .tolerance = 1e-11});
    State state{VectorXd::Zero(3), Eigen::Vector3d(6.0, 0.0, 0.0)};
    StepLoad load = make_step_load(3);
    for (int k = 0, steps = static_cast<int>(std::lround(0.3 / step)); k < steps; ++k) {
      EXPECT_TRUE(integrator->step(state, load).converged) << name;
    }
    return state.q;
  };
  const VectorXd exact = end_of("rk4", 2e-5);
  for (const char* name : {"avf", "ep2", "ep4", "midpoint"}) {
    double error = 0.0;
    for (const double step : {2e-3, 1e-3, 5e-4, 2.5e-4}) {
      const double before = std::exchange(error, (end_of(name, step) - exact).norm());
      EXPECT_LE(error, 1e-3 * exact.norm()) << name << ", " << step;
      if (before > 0.0) {
        EXPECT_GE(std::log2(before / error), 1.8) << name << ", " << step;
      }
    }
  }
}

BasisData without_strains(const StrainModel& strain) {
  BasisData data = sample_basis(strain);
  data.strain_gram.clear();
  return data;
}

TEST(StrainDamping, AModelWithoutItsStrainsIsDampedByThePositivePartOfItsTangent) {
  const StrainModel strain = strong_strain_model();
  const auto model = Model::from_data(without_strains(strain));
  ASSERT_TRUE(model);
  EXPECT_FALSE((*model)->has_strain_gram());
  StrainDamping damping(**model, 1.0);
  Evaluation at = (*model)->potential().make_evaluation();
  PotentialWorkspace workspace = (*model)->potential().make_workspace();
  bool indefinite = false;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const VectorXd q = random_vector(4, 0.5, seed), v = random_vector(4, 1.0, 100 + seed);
    (*model)->potential().evaluate(q, kWantTangent, workspace, at);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(at.tangent);
    indefinite = indefinite || eigen.eigenvalues().minCoeff() < 0.0;
    const VectorXd expected = eigen.eigenvectors() *
                              eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                              (eigen.eigenvectors().transpose() * v);
    const VectorXd force = damping_of(damping, strain, q, v);
    EXPECT_LE((force - expected).norm(), 1e-12 * expected.norm());
    EXPECT_GE(v.dot(force), 0.0);
  }
  EXPECT_TRUE(indefinite);
}

TEST(StrainDamping, WithoutStrainsEveryMethodTakesEnergyAndTheFamilyBalances) {
  const StrainModel strain = strong_strain_model();
  const auto model = Model::from_data(without_strains(strain));
  ASSERT_TRUE(model);
  const auto energy = [&](const State& s) {
    return 0.5 * s.p.squaredNorm() + strain_energy(strain, s.q);
  };
  for (const std::string_view name : integrator_names()) {
    if (name == "explicit-euler") continue;  // it feeds more than this damping takes
    const auto integrator = make(name, *model, {.step = 1e-3, .beta = 3e-3});
    State state = strong_state();
    StepLoad load = make_step_load(4);
    double dissipated = 0.0;
    for (int k = 0; k < 400; ++k) {
      const StepReport report = integrator->step(state, load);
      ASSERT_TRUE(report.converged) << name;
      dissipated += report.dissipated;
    }
    EXPECT_LT(energy(state), 0.5 * energy(strong_state())) << name;
    if (name == "avf" || name == "ep2" || name == "ep4") {
      EXPECT_NEAR(energy(state) + dissipated, energy(strong_state()), 1e-11) << name;
    }
  }
}

TEST(StrainDamping, ALinearModelHasTheDampingOfTheRestShapeAndReadsNothing) {
  const auto model = Model::from_data(sample_basis(strong_strain_model()), {.linear = true});
  ASSERT_TRUE(model);
  EXPECT_FALSE((*model)->has_strain_gram());
  EXPECT_FALSE(StrainDamping(**model, 1.0).present());
}

TEST(StrainDamping, DataOfAnotherSizeOrWithoutSenseAreRefused) {
  for (int what = 0; what < 3; ++what) {
    BasisData data = sample_basis(strong_strain_model());
    if (what == 0) data.strain_gram.pop_back();
    if (what == 1) data.strain_gram.front() = -1.0;
    if (what == 2) data.strain_gram[1] = std::nan("");
    const auto model = Model::from_data(data);
    ASSERT_FALSE(model) << what;
    EXPECT_EQ(model.error().kind, ErrorKind::kContent);
  }
}

}  // namespace
}  // namespace tremolo
