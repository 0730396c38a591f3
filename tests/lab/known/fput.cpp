#include "tests/lab/known/fput.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/lab/known/quartic_model.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {
namespace {

constexpr double kSquare = kFputOmega * kFputOmega;

FputEnergies spring_energies(double t, const Eigen::VectorXd& q, const Eigen::VectorXd& p) {
  FputEnergies energies{.t = t};
  for (int j = 0; j < 3; ++j)
    energies.i[j] = 0.5 * (p[3 + j] * p[3 + j] + kSquare * q[3 + j] * q[3 + j]);
  return energies;
}

}  // namespace

Model::Pointer fput_model() {
  Eigen::VectorXd lambda(6);
  lambda << Eigen::Vector3d::Constant(kNoStiffness), Eigen::Vector3d::Constant(kSquare);
  BasisData data = quadratic_basis(lambda);
  Eigen::Matrix<double, 4, 6> soft;  // the extensions of the soft springs
  soft << 1, 0, 0, -1, 0, 0,         //
      -1, 1, 0, -1, -1, 0,           //
      0, -1, 1, 0, -1, -1,           //
      0, 0, 1, 0, 0, 1;
  for (Eigen::Index s = 0; s < 4; ++s) add_fourth_power(data, 0.25, soft.row(s).transpose());
  return or_fail(Model::from_data(data));
}

State fput_start() {
  State state{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
  state.q[0] = 1.0;
  state.q[3] = 1.0 / kFputOmega;
  state.p[0] = 1.0;
  state.p[3] = 1.0;
  return state;
}

double fput_hamiltonian(const State& state) {
  const auto x0 = state.q.head<3>();
  const auto x1 = state.q.tail<3>();
  double soft = std::pow(x0[0] - x1[0], 4) + std::pow(x0[2] + x1[2], 4);
  for (int i = 0; i < 2; ++i) soft += std::pow(x0[i + 1] - x1[i + 1] - x0[i] - x1[i], 4);
  return 0.5 * state.p.squaredNorm() + 0.5 * kSquare * x1.squaredNorm() + 0.25 * soft;
}

FputRun run_fput(std::string_view method, double step, long every) {
  IntegratorOptions options{.step = step};
  options.split = {.rule = SplitRule::kCount, .count = 3};
  options.tolerance = 1e-10;
  const std::unique_ptr<Integrator> integrator =
      or_fail(make_integrator(method, fput_model(), options));
  State state = fput_start();
  State synchronized = state;
  const StepLoad none = make_step_load(6);
  const long count = std::lround(std::ceil(kFputDuration / step - 1e-9));
  const double start_energy = fput_hamiltonian(state);
  constexpr double start_sum = 1.0;  // I of fput_start()
  FputRun run;
  run.method = method;
  run.step = step;
  run.lowest = std::numeric_limits<double>::infinity();
  for (long k = 0;; ++k) {
    integrator->synchronized_momentum(state, synchronized.p);
    synchronized.q = state.q;
    run.reached = static_cast<double>(k) * step;
    const FputEnergies now = spring_energies(run.reached, synchronized.q, synchronized.p);
    const double sum = now.i[0] + now.i[1] + now.i[2];
    const double energy = fput_hamiltonian(synchronized);
    run.lowest = std::min(run.lowest, sum);
    run.highest = std::max(run.highest, sum);
    run.energy_error = std::max(run.energy_error, std::abs(energy - start_energy) / start_energy);
    if (every > 0 && k % every == 0) run.series.push_back(now);
    if (!(energy <= 10.0 * start_energy)) {
      run.failure = "energy bound left";
      return run;
    }
    if (!run.lost && !(sum >= 0.5 * start_sum && sum <= 2.0 * start_sum)) run.lost = run.reached;
    if (!run.second && !run.lost && now.i[1] > now.i[0]) run.second = run.reached;
    if (!run.third && !run.lost && now.i[2] > now.i[0]) run.third = run.reached;
    if (k == count) return run;
    const StepReport report = integrator->step(state, none);
    if (report.parts > 1) ++run.cut_steps;
    if (!report.converged) {
      run.failure = "solver gave up";
      return run;
    }
  }
}

}  // namespace tremolo::known
