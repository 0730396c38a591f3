#include "tests/lab/damping/damping_matrix.h"

#include <cmath>
#include <limits>

#include "tests/lab/bench/reference.h"
#include "tests/lab/bench/sampled_run.h"
#include "tests/lab/damping/stiff_orbit.h"
#include "tests/lab/work/failure.h"

namespace tremolo::damping {
namespace {

constexpr double kDuration = 2.0;  // s

double error_of(const StiffProblem& problem, std::string_view method,
                const Eigen::MatrixXd& reference) {
  bench::RunSpec spec;
  spec.model = problem.model;
  spec.integrator = method;
  spec.options.alpha = problem.alpha;
  spec.options.beta = problem.beta;
  spec.load = problem.load;
  spec.duration = problem.duration;
  spec.sample = problem.sample;
  spec.keep_orbit = true;
  return bench::trajectory_error(bench::run_sampled(spec).q, reference, reference.cols());
}

}  // namespace

bool Entry::judged() const {
  return method != "imexv-thesis" && std::isfinite(undamped) && undamped < 1.0;
}

std::vector<Entry> damping_matrix(const reproduce::SampleModel& sample) {
  StiffProblem problem;
  problem.model = sample.model;
  problem.strain_gram = sample.strain_gram;
  problem.duration = kDuration;
  problem.load = {{.kind = SignalKind::kSquare},
                  or_fail(reduce_load(*sample.model, sample.model->default_load()))};
  std::vector<Entry> entries;
  const std::size_t methods = integrator_names().size();
  for (const Rayleigh& damping : kRayleigh) {
    problem.alpha = damping.alpha;
    problem.beta = damping.beta;
    const Eigen::MatrixXd reference = stiff_orbit(problem);
    for (std::size_t i = 0; i < methods; ++i) {
      Entry entry{sample.name, std::string(integrator_names()[i]), damping};
      entry.error = error_of(problem, entry.method, reference);
      entry.undamped = entries.size() < methods ? entry.error : entries[i].error;
      entries.push_back(std::move(entry));
    }
  }
  return entries;
}

Table to_table(const std::vector<Entry>& entries) {
  Table table{{"model", "alpha 1/s", "beta s"}, {}};
  for (const std::string_view name : integrator_names()) table.columns.emplace_back(name);
  const std::size_t methods = integrator_names().size();
  for (std::size_t first = 0; first + methods <= entries.size(); first += methods) {
    std::vector<std::string> row = {entries[first].model, cell(entries[first].damping.alpha),
                                    cell(entries[first].damping.beta)};
    for (std::size_t i = 0; i < methods; ++i) row.push_back(cell(entries[first + i].error, 2));
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace tremolo::damping
