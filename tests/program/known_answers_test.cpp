// The experiments with a known answer against closed forms that have no code in common with them.
#include "tests/lab/known/known_answers.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/known/energy_trend.h"
#include "tests/lab/known/fput.h"
#include "tests/lab/known/pendulum.h"
#include "tests/lab/known/quartic_model.h"
#include "tests/lab/known/resonance.h"
#include "tests/lab/known/spring_chain.h"
#include "tests/lab/known/step_properties.h"
#include "tests/support/temporary_folder.h"

namespace tremolo::known {
namespace {

Eigen::VectorXd random_vector(Eigen::Index size, double scale, std::mt19937& generator) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  Eigen::VectorXd v(size);
  for (double& x : v) x = uniform(generator);
  return v;
}

// Explicit (kick from the old q) or symplectic Euler (kick from the new one), whose maps are known.
class EulerStep final : public Integrator {
 public:
  EulerStep(const Model& model, double h, bool symplectic)
      : model_(model), h_(h), symplectic_(symplectic) {}
  StepReport step(State& state, const StepLoad&) noexcept override {
    const Eigen::VectorXd q = state.q + h_ * state.p;
    state.p -= h_ * potential_force(model_, symplectic_ ? q : state.q);
    state.q = q;
    return {};
  }
  void carry(StateStream&) override {}
  std::string_view name() const override { return "euler"; }

 private:
  const Model& model_;
  double h_;
  bool symplectic_;
};

TEST(Fput, EnergyOfTheModelIsTheHamiltonianAndItsForceTheGradient) {
  const Model::Pointer model = fput_model();
  std::mt19937 generator(3);
  for (int trial = 0; trial < 20; ++trial) {
    State state{random_vector(6, 1.0, generator), Eigen::VectorXd::Zero(6)};
    const double energy = fput_hamiltonian(state);
    // kNoStiffness adds at most 1.5e-12, rounding 1e-16 of about 3000.
    EXPECT_NEAR(potential_energy(*model, state.q), energy, 4e-12);
    const Eigen::VectorXd force = potential_force(*model, state.q);
    const double step = 1e-3;
    for (Eigen::Index i = 0; i < 6; ++i) {
      // Fourth-order differences are exact for a quartic up to rounding, 1e-12/step.
      const auto at = [&](double shift) {
        State moved = state;
        moved.q[i] += shift;
        return fput_hamiltonian(moved);
      };
      const double slope =
          (8.0 * (at(step) - at(-step)) - at(2.0 * step) + at(-2.0 * step)) / (12.0 * step);
      EXPECT_NEAR(force[i], slope, 1e-8);
    }
  }
}

TEST(Fput, EnergyPassesToTheSecondSpringAtTheKnownTime) {
  // h omega = 0.05: the time is second order in it, and at 0.5 it is off by 1.8 s.
  const FputRun run = run_fput("verlet", 1e-3);
  ASSERT_TRUE(run.second && run.third);
  EXPECT_NEAR(*run.second, 58.9, 0.2);
  EXPECT_NEAR(*run.third, 77.3, 0.2);
  EXPECT_TRUE(run.failure.empty());
  EXPECT_GT(run.lowest, 0.93);
  EXPECT_LT(run.highest, 1.08);
}

TEST(Fput, AnUnstableStepIsReportedNotHidden) {
  const FputRun run = run_fput("verlet", 3.0 / kFputOmega);
  EXPECT_EQ(run.failure, "energy bound left");
  EXPECT_LT(run.reached, kFputDuration);
  EXPECT_TRUE(std::isfinite(run.energy_error));
}

TEST(Resonance, ClosedFormOfRespaIsTheProductOfItsThreeMaps) {
  const double k = 0.2;
  for (const double h : {0.1, 1.0, 3.0, 3.5, 7.0}) {
    Eigen::Matrix2d kick, turn;
    kick << 1.0, 0.0, -0.5 * h * k, 1.0;
    turn << std::cos(h), std::sin(h), -std::sin(h), std::cos(h);
    EXPECT_LT((kick * turn * kick - respa_map(h, k)).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_NEAR(respa_map(h, k).trace(), 2.0 * std::cos(h) - h * k * std::sin(h), 1e-14);
  }
}

TEST(Resonance, RespaIsUnstableJustBelowMultiplesOfPiOnly) {
  for (int n = 1; n <= 3; ++n) {
    const double resonant = n * std::numbers::pi;
    // The tongue is about h k = 0.03 n pi wide and lies below the multiple.
    EXPECT_GT(spectral_radius(respa_map(resonant - 0.02, kResonanceSlow)), 1.01);
    EXPECT_NEAR(spectral_radius(respa_map(resonant + 0.02, kResonanceSlow)), 1.0, 1e-12);
    EXPECT_NEAR(spectral_radius(respa_map(resonant - 1.0, kResonanceSlow)), 1.0, 1e-12);
  }
}

TEST(Resonance, MapOfTheMidpointRuleIsItsClosedForm) {
  const double k = 0.1;
  for (const double h : {0.3, 3.1, 9.0}) {
    const auto map = linear_map("midpoint", h, k);
    ASSERT_TRUE(map);
    const double z = 0.25 * h * h * (1.0 + k);
    Eigen::Matrix2d exact;
    exact << 1.0 - z, h, -h * (1.0 + k), 1.0 - z;
    exact /= 1.0 + z;
    // The neglected cubic terms are of size 1e-12 times the motion of s, h^2.
    EXPECT_LT((*map - exact).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(Resonance, MapOfImexvLinearIsKickMidpointKick) {
  const double k = 0.1;
  for (const double h : {0.3, 3.1, 6.0}) {
    const auto map = linear_map("imexv-linear", h, k);
    ASSERT_TRUE(map);
    Eigen::Matrix2d kick, turn;
    kick << 1.0, 0.0, -0.5 * h * k, 1.0;
    const double z = 0.25 * h * h;
    turn << 1.0 - z, h, -h, 1.0 - z;
    turn /= 1.0 + z;
    EXPECT_LT((*map - kick * turn * kick).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(Pendulum, EnergyOfTheModelIsThatOfTheBar) {
  const Pendulum pendulum{.length = 1.3, .gravity = 9.81, .stiffness = 300.0, .angle = 1.0};
  const Model::Pointer model = pendulum_model(pendulum);
  std::mt19937 generator(5);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd q = random_vector(2, 2.0, generator);
    const double energy = pendulum_potential(pendulum, pendulum_position(pendulum, q));
    // A missing linear term would show: it vanishes only if the hanging length is right.
    EXPECT_NEAR(potential_energy(*model, q), energy, 1e-12 * (1.0 + std::abs(energy)) + 1e-10);
  }
}

TEST(Pendulum, SmallSwingsHaveTheirTextbookPeriod) {
  const Pendulum pendulum{.length = 1.0, .gravity = 9.81, .stiffness = 4e4, .angle = 0.01};
  const PendulumRun run = run_pendulum(pendulum, "midpoint", 1e-3, 2.5, 1.0);
  double quarter = 0.0;  // when the angle first changes its sign
  for (std::size_t k = 0; quarter == 0.0 && k < run.t.size(); ++k)
    if (run.angle[k] < 0.0) quarter = run.t[k];
  const double period =
      2.0 * std::numbers::pi * std::sqrt(hanging_length(pendulum) / pendulum.gravity);
  EXPECT_NEAR(quarter, 0.25 * period, 1.1e-3);  // one step
}

TEST(SpringChain, EnergyOfTheModelIsThatOfTheBars) {
  const SpringChain chain = spring_chain();
  std::mt19937 generator(7);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d u = random_vector(3, 0.5, generator);
    const double energy = spring_chain_energy(u);
    EXPECT_NEAR(potential_energy(*chain.model, chain.modes.transpose() * u), energy,
                1e-13 * 5e5);  // the parts that cancel are of this size
  }
}

TEST(StepProperties, ADefectIsFoundAndHasItsKnownSize) {
  const SpringChain chain = spring_chain();
  const double h = 1e-3;
  EulerStep explicit_euler(*chain.model, h, false);
  const State near_rest = spring_chain_state(chain, 1e-9);
  const auto jacobian = step_jacobian(explicit_euler, near_rest, 20.0);
  ASSERT_TRUE(jacobian);
  // J = [1, h; -h K, 1] mode by mode: J^T Omega J = (1 + h^2 lambda) Omega.
  const double exact = h * h * chain.model->lambda()[2];
  EXPECT_NEAR(symplectic_defect(*jacobian), exact, 1e-8 * exact);
}

TEST(StepProperties, AnIrreversibleButSymplecticMapIsToldApart) {
  const SpringChain chain = spring_chain();
  EulerStep symplectic_euler(*chain.model, 1e-3, true);
  const State state = spring_chain_state(chain);
  const auto jacobian = step_jacobian(symplectic_euler, state, 20.0);
  ASSERT_TRUE(jacobian);
  EXPECT_LT(symplectic_defect(*jacobian), 1e-11);  // rounding over the difference step
  EXPECT_GT(reversal_error(symplectic_euler, state, 20.0).value_or(0.0), 1e-3);
}

TEST(StepProperties, DifferencesReproduceVerletsJacobian) {
  // Eighth order at a hundredth of the state: 1e-16 of truncation, rounding 1e-16 over 0.01.
  EXPECT_LT(jacobian_accuracy(3e-3, 1.0), 1e-12);
  EXPECT_LT(jacobian_accuracy(3e-3, 1e-6), 1e-12);
}

TEST(StepProperties, EveryMethodIsListedWithItsPromises) {
  for (const std::string_view method : integrator_names())
    EXPECT_TRUE(promise_of(method)) << method;
  EXPECT_FALSE(promise_of("nothing"));
}

TEST(EnergyTrend, FitFindsALineAndItsStandardError) {
  std::vector<double> values;
  for (int k = 0; k < 50; ++k) values.push_back(2.0 + 0.25 * k);
  EXPECT_NEAR(fit_line(values, 1.0).slope, 0.25, 1e-14);
  EXPECT_NEAR(fit_line(values, 1.0).slope_error, 0.0, 1e-14);
  // +-1 about the line: residual variance n/(n-2), spread of the index n (n^2 - 1)/12.
  for (int k = 0; k < 50; ++k) values[k] += k % 2 == 0 ? 1.0 : -1.0;
  const double expected = std::sqrt(50.0 / 48.0 / (50.0 * (2500.0 - 1.0) / 12.0));
  // The alternation itself is slightly sloped, by 3/n^2 of its size.
  EXPECT_NEAR(fit_line(values, 1.0).slope_error, expected, 2e-3 * expected);
}

TEST(EnergyTrend, ALossIsSeenAndOneThatIsNotThereIsNot) {
  const EnergyTrend kept = measure_trend("midpoint", 1e-12, 1e-3, 20000, 20);
  EXPECT_TRUE(kept.implicit);
  EXPECT_EQ(kept.reached, 20000);
  EXPECT_LT(std::abs(kept.slope), 5.0 * kept.standard_error);
  // Over 0.2 s at 1e-5 s it takes e^{-h omega^2 t}: 0.10 off the slowest mode's energy, 0.62 off
  // the fastest's.
  const EnergyTrend lost = measure_trend("implicit-euler", 1e-12, 1e-5, 20000, 20);
  EXPECT_LT(lost.slope, -0.1);
  EXPECT_GT(lost.slope, -0.7);
  EXPECT_GT(std::abs(lost.slope), 10.0 * lost.standard_error);
}

TEST(KnownAnswers, PageHoldsEveryPromiseAndASecondStartReadsWhatIsStored) {
#if defined(TREMOLO_SANITIZED)
  GTEST_SKIP() << "takes minutes; the tests above look at its parts";
#endif
  const testing::TemporaryFolder folder;
  const std::string directory = folder.path();
  const Result<Store> store = Store::open(directory + "/store");
  ASSERT_TRUE(store);
  const std::string published = TREMOLO_SOURCE_DIR "/assets/published";
  Report report(directory, "Known answers", "test");
  const std::vector<Criterion> first = add_known_answers({report, *store, published});
  for (const Criterion& criterion : first)
    EXPECT_TRUE(criterion.met || !criterion.decides)
        << criterion.what << ": " << criterion.measured << ", " << criterion.bound;
  for (const char* file : {"known-fput.csv", "known-resonance.csv", "known-resonance-respa.csv",
                           "known-pendulum.csv", "known-steps.csv", "known-trend.csv"})
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(directory) / file)) << file;
  Report again(directory, "Known answers", "test");
  const std::vector<Criterion> second = add_known_answers({again, *store, published});
  EXPECT_EQ(again.json(), report.json());
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(first[i].measured, second[i].measured) << first[i].what;
}

}  // namespace
}  // namespace tremolo::known
