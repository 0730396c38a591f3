// Energy, force and tangent against the textbook's tables.
#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "common/packed_index.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/speed/textbook.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

using Eigen::VectorXd;

// Random coefficients: the time does not depend on their values.
Potential random_potential(std::size_t r) {
  std::mt19937_64 generator(r);
  std::normal_distribution<double> normal;
  std::vector<double> cubic(triple_count(r)), quartic(quad_count(r));
  for (double& value : cubic) value = normal(generator);
  for (double& value : quartic) value = normal(generator);
  return or_fail(Potential::create(VectorXd::LinSpaced(static_cast<Eigen::Index>(r), 1.0, 50.0),
                                   cubic, quartic));
}

struct Bench {
  Potential potential;
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  Textbook textbook{potential};
  VectorXd q0 = 0.1 * VectorXd::Ones(potential.size());
  VectorXd q1 = 0.2 * VectorXd::Ones(potential.size());
  VectorXd average = q0;
  Eigen::MatrixXd jacobian = evaluation.tangent;

  void evaluate(unsigned want) { potential.evaluate(q0, want, workspace, evaluation); }
};

// The least time that `bytes` and `operations` need: those of a pass over the coefficients alone.
void set_pass_limit(SpeedRow& row, const MachineProbe& probe) {
  const double arithmetic = 1e-3 * row.operations / probe.gflops;
  const bool level2 = row.bytes < 0.9e6;
  const double memory = 1e-3 * row.bytes / (level2 ? probe.l2_bandwidth : probe.l3_bandwidth);
  row.limit = std::max(arithmetic, memory);
  row.limited_by = arithmetic > memory ? "multiply-adds"
                   : level2            ? "level-2 reads"
                                       : "level-3 reads";
}

Criterion ratio_criterion(const SpeedRow& row, double bound, std::string_view bound_text) {
  return {row.what + ", over the textbook's time", fmt::format("<= {}", bound_text),
          fmt::format("{:.3f} = 1/{:.1f}", row.ratio(), 1.0 / row.ratio()), row.ratio() <= bound};
}

void add_rows(std::size_t r, const MachineProbe& probe, SpeedSection& section) {
  Bench bench{random_potential(r)};
  const int calls = r > 40 ? 50 : r > 20 ? 200 : 500;
  const auto average = [&](Eigen::MatrixXd* jacobian) {
    bench.potential.averaged_gradient(bench.q0, bench.q1, bench.workspace, bench.average, jacobian);
  };
  const std::vector<double> seconds =
      by_turns({[&] { bench.textbook.force(bench.q0); }, [&] { bench.evaluate(kWantForce); },
                [&] { bench.textbook.force_and_tangent(bench.q0, true); },
                [&] { bench.evaluate(kWantEnergy | kWantForce | kWantTangent); },
                [&] { average(nullptr); }, [&] { average(&bench.jacobian); }},
               calls, r > 40 ? 20 : 60);
  const double unique = static_cast<double>(triple_count(r) + quad_count(r));
  const double pairs = static_cast<double>(pair_count(r));
  const double size = static_cast<double>(r);
  const double matrix = pairs * (pairs + 1.0) / 2.0;
  const auto add = [&](const char* what, double value, double baseline, double coefficients,
                       double per_coefficient) {
    SpeedRow row = microseconds(fmt::format("{}, r = {}", what, r), value, baseline);
    row.bytes = 8.0 * coefficients;
    row.operations = 2.0 * per_coefficient * coefficients;
    set_pass_limit(row, probe);
    section.rows.push_back(row);
    return row;
  };
  add("textbook: force", seconds[0], SpeedRow::kNone,
      size * (size + pairs + static_cast<double>(triple_count(r))), 1.0);
  add("force", seconds[1], seconds[0], unique, 2.0);
  add("textbook: force + tangent + energy", seconds[2], SpeedRow::kNone,
      static_cast<double>(bench.textbook.doubles()), 1.0);
  const SpeedRow all = add("force + tangent + energy", seconds[3], seconds[2], unique, 3.0);
  for (const auto& [what, at] :
       {std::pair{"averaged gradient", 4}, {"averaged gradient + tangent", 5}})
    add(what, seconds[at], SpeedRow::kNone, matrix + size * pairs, 2.0);
  if (r <= 20) section.criteria.push_back(ratio_criterion(all, 0.25, "1/4"));
  if (r == 30)
    section.criteria.push_back(probe.vectors == "AVX-512" ? ratio_criterion(all, 0.125, "1/8")
                                                          : ratio_criterion(all, 0.2, "1/5"));
  if (r == 60)
    section.criteria.push_back(
        {all.what + ", over its limit (" + all.limited_by + " of the unique coefficients)", "<= 2",
         fmt::format("{:.2f}", all.value / all.limit), all.value <= 2.0 * all.limit});
}

}  // namespace

SpeedSection measure_kernel_speed(const Options&, const MachineProbe& probe) {
  SpeedSection section;
  section.title = "The kernel";
  for (const std::size_t r : {15, 20, 30, 60}) add_rows(r, probe, section);
  section.text =
      "Energy V, force R and tangent K of one body, warm cache, one core. The textbook keeps a "
      "dense table for each degree and multiplies by " +
      Textbook(random_potential(2)).blas() +
      ". The limit counts a pass over the coefficients alone: unique entries, two multiply-adds "
      "each for the force and three with the tangent; the averaged gradient multiplies the matrix "
      "over index pairs.";
  return section;
}

}  // namespace tremolo::bench
