#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/processor.h"
#include "runtime/apps/tremolo/output/statistics.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/step/nodal_integrator.h"
#include "tests/lab/cloth/cloth_sections.h"
#include "tests/lab/cloth/cloth_study.h"
#include "tests/lab/work/failure.h"

namespace tremolo::cloth_study {
namespace {

constexpr double kSpeedStep = 1.0 / 60.0;  // s
constexpr double kStiffNumber = 30.0;      // h omega_max of the structural springs

struct SpeedCase {
  const char* method;
  NodalSolver solver;
  std::size_t edge;
  int steps;
  double bound;         // s
  bool account = true;  // whether energies are asked for
};

struct SpeedRow {
  SpeedCase known;
  std::vector<double> each;  // s
  double iterations = 0.0;   // a step
  double step = 0.0;         // s
};

// Half a metre for 100 particles, whatever their number: the spacing stays.
SheetSpec speed_sheet(std::size_t edge, double stiffness) {
  return {edge, 0.005 * static_cast<double>(edge), stiffness, 1e-3, true};
}

// The largest eigenvalue is proportional to the stiffness.
double stiffness_for(std::size_t edge) {
  const ClothModel soft = study_model(speed_sheet(edge, 1.0), Eigen::Vector3d::Zero());
  const double omega = kStiffNumber / kSpeedStep;
  return omega * omega / largest_eigenvalue(soft, soft.parts().x, ForcePart::kStiff);
}

SpeedRow measure_speed(const SpeedCase& known) {
  SpeedRow row{known, {}};
  const ClothModel model =
      study_model(speed_sheet(known.edge, stiffness_for(std::min<std::size_t>(known.edge, 100))),
                  {0.0, 0.0, -9.81});
  NodalOptions options;
  options.step = kSpeedStep;
  options.solver = known.solver;
  // An explicit method at four fifths of its stable step.
  if (std::isfinite(stability_number(known.method)))
    options.step = 0.8 * stable_step(known.method, model, model.parts().x);
  options.account = known.account;
  row.step = options.step;
  const auto integrator = or_fail(make_nodal_integrator(known.method, model, options));
  NodalState state{model.parts().x, Eigen::VectorXd::Zero(model.parts().x.size()), 0.0};
  std::int64_t iterations = 0;
  for (int k = 0; k < known.steps; ++k) {
    const double before = processor_time();
    const NodalReport report = integrator->step(state);
    row.each.push_back(processor_time() - before);
    if (!report.made) throw Failure({ErrorKind::kSolver, "a step of the speed test failed"});
    iterations += report.iterations;
  }
  row.iterations = static_cast<double>(iterations) / known.steps;
  return row;
}

const char* solver_name(NodalSolver solver) {
  if (solver == NodalSolver::kCholesky) return "cholesky";
  return solver == NodalSolver::kConjugateGradients ? "conjugate-gradients" : "automatic";
}

}  // namespace

std::vector<Criterion> add_cloth_speed(Report& report) {
  const SpeedCase cases[] = {
      {"implicit-euler", NodalSolver::kAutomatic, 100, 120, 60e-3},
      {"implicit-euler", NodalSolver::kCholesky, 100, 60, 0.0},
      {"implicit-euler", NodalSolver::kConjugateGradients, 100, 60, 0.0},
      {"implicit-euler-linear", NodalSolver::kAutomatic, 100, 120, 0.0},
      {"implicit-euler", NodalSolver::kAutomatic, 317, 12, 1.2},
      {"symplectic-euler", NodalSolver::kAutomatic, 50, 4000, 120e-6, false},
      {"symplectic-euler", NodalSolver::kAutomatic, 50, 4000, 0.0},
      {"rk4", NodalSolver::kAutomatic, 50, 1000, 0.0},
  };
  Table table{{"method", "solver", "energies", "particles", "step ms", "median ms a step",
               "largest ms", "iterations a step"},
              {}};
  std::vector<Criterion> criteria;
  for (const SpeedCase& known : cases) {
    const SpeedRow row = measure_speed(known);
    const double middle = median(row.each);
    const char* energies = known.account ? "computed" : "not requested";
    tell("tremolo: {} of {} particles, {}, energies {}: {:.4g} ms a step\n", known.method,
         known.edge * known.edge, solver_name(known.solver), energies, 1e3 * middle);
    const std::size_t particles = known.edge * known.edge;
    table.rows.push_back({known.method, solver_name(known.solver), energies,
                          std::to_string(particles), cell(1e3 * row.step, 3), cell(1e3 * middle, 3),
                          cell(1e3 * *std::ranges::max_element(row.each), 3),
                          cell(row.iterations, 3)});
    if (known.bound <= 0.0) continue;
    Criterion criterion =
        at_most(fmt::format("cloth: {} particles, {}, median ms a step", particles, known.method),
                1e3 * middle, 1e3 * known.bound);
    criterion.decides = false;
    criteria.push_back(std::move(criterion));
  }
  report.section("Cloth: what a step costs");
  report.paragraph(
      "Hanging sheets from their release on; structural springs with h "
      "omega_max = 30 at 1/60 s; Newton to 1e-6 of the load; processor time of one thread. "
      "symplectic-euler and rk4 take four fifths of what they stand.");
  report.table(table, "What a step costs.", "cloth-speed.csv");
  return criteria;
}

}  // namespace tremolo::cloth_study
