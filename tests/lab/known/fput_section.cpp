#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "tests/lab/known/fput.h"
#include "tests/lab/known/quartic_model.h"
#include "tests/lab/known/sections.h"
#include "tests/lab/report/chart.h"

namespace tremolo::known {
namespace {

constexpr double kProducts[] = {0.5, 1.0, 1.5, 2.0, std::numbers::pi, 5.0, 10.0};  // h omega
constexpr double kReferenceStep = 2e-4;                                            // s
constexpr double kPi = std::numbers::pi;

// An independent computation of the same chain by a prototype that shares no code with this one:
// the times of the first I2 > I1 and I3 > I1, s; 0 for never.
struct Independent {
  const char* method;
  double product;
  double second, third;
};
constexpr Independent kIndependent[] = {
    {"imexv-linear", 0.5, 58.8, 76.9},
    {"imexv-linear", 1.5, 56.8, 73.6},
    {"imexv-linear", kPi, 55.1, 73.2},
    {"imexv-linear", 5.0, 55.2, 72.4},
    {"imexv-linear", 10.0, 51.6, 73.2},
    {"midpoint", 0.5, 61.4, 82.7},
    {"midpoint", 1.5, 90.4, 118.5},
    {"midpoint", kPi, 166.6, 0.0},
    {"avf", 1.5, 94.3, 119.9},
    {"ep2", 1.5, 87.3, 115.7},
    {"ep4", 0.5, 58.9, 77.3},
    {"ep4", 1.0, 58.9, 78.1},
    {"ep4", 1.5, 63.1, 85.1},
    {"ep4", 2.0, 83.2, 107.3},
    {"ep4", kPi, 0.0, 0.0},
};

std::string time_text(const FputRun& run, const std::optional<double>& t) {
  if (t) return fmt::format("{:.1f}", *t);
  if (!run.failure.empty()) return "fails";
  return run.lost ? fmt::format("I lost at {:.1f}", *run.lost) : "never";
}

std::string times_text(const FputRun& run) {
  const std::string second = time_text(run, run.second);
  const std::string third = time_text(run, run.third);
  return !run.second && second == third ? second : second + " / " + third;
}

Chart exchange_chart(const std::vector<FputRun>& runs, double reference) {
  Chart chart{.title = "first time when I2 > I1", .x_label = "h omega", .y_label = "t (s)"};
  chart.log_x = true;
  chart.x_range = {0.45, 11.0};
  chart.y_range = {0.0, 210.0};
  chart.curves.push_back({.label = "reference",
                          .x = {0.45, 11.0},
                          .y = {reference, reference},
                          .style = CurveStyle::kDashes,
                          .colour = "#444444"});
  std::map<std::string, std::size_t> place;
  for (const FputRun& run : runs) {
    if (!run.second) continue;
    const auto [at, fresh] = place.emplace(run.method, chart.curves.size());
    if (fresh)
      chart.curves.push_back({.label = run.method,
                              .x = {},
                              .y = {},
                              .style = CurveStyle::kLinesAndPoints,
                              .colour = {}});
    chart.curves[at->second].x.push_back(run.step * kFputOmega);
    chart.curves[at->second].y.push_back(*run.second);
  }
  return chart;
}

Chart energies_chart(const FputRun& run) {
  Chart chart{.title = fmt::format("{}, h omega = {:.3g}", run.method, run.step * kFputOmega),
              .x_label = "t (s)",
              .y_label = "energy"};
  chart.x_range = {0.0, kFputDuration};
  chart.y_range = {0.0, 1.5};
  chart.curves = {{.label = "I1"},
                  {.label = "I2"},
                  {.label = "I3"},
                  {.label = "I", .style = CurveStyle::kLines, .colour = "#444444"}};
  for (const FputEnergies& e : run.series) {
    const double values[] = {e.i[0], e.i[1], e.i[2], e.i[0] + e.i[1] + e.i[2]};
    for (std::size_t c = 0; c < 4; ++c) {
      chart.curves[c].x.push_back(e.t);
      chart.curves[c].y.push_back(values[c]);
    }
  }
  return chart;
}

Status add_run_tables(const SectionContext& context, const std::vector<FputRun>& references,
                      const std::vector<FputRun>& runs) {
  Table all{{"method", "h omega", "first I2 > I1 (s)", "first I3 > I1 (s)", "lowest I", "highest I",
             "max |H - H0| / H0", "steps in parts", "reached (s)", "failure"},
            {}};
  Table times{{"method"}, {}};
  for (const double product : kProducts) times.columns.push_back(fmt::format("{:.3g}", product));
  const auto append = [&](const FputRun& run) {
    all.rows.push_back({run.method, cell(run.step * kFputOmega), time_text(run, run.second),
                        time_text(run, run.third), cell(run.lowest), cell(run.highest),
                        cell(run.energy_error, 2), std::to_string(run.cut_steps), cell(run.reached),
                        run.failure});
  };
  for (const FputRun& run : references) append(run);
  for (const FputRun& run : runs) {
    append(run);
    if (times.rows.empty() || times.rows.back()[0] != run.method)
      times.rows.push_back({run.method});
    times.rows.back().push_back(times_text(run));
  }
  context.page.table(times,
                     "First I2 > I1 / first I3 > I1, s, over h omega. fails: the orbit left ten "
                     "times its energy or the solver gave up. I lost: the sum of the three left "
                     "[1/2, 2] of its start, so that a later crossing is no exchange.");
  return write_csv(all, context.directory + "/known-fput.csv");
}

void add_comparison(const SectionContext& context, const std::vector<FputRun>& runs) {
  Table table{{"method", "h omega", "I2 > I1, independent", "here", "I3 > I1, independent", "here"},
              {}};
  const auto independent = [](double t) { return t > 0.0 ? fmt::format("{:.1f}", t) : "never"; };
  for (const Independent& known : kIndependent)
    for (const FputRun& run : runs)
      if (run.method == known.method && std::abs(run.step * kFputOmega - known.product) < 1e-9)
        table.rows.push_back({run.method, cell(known.product), independent(known.second),
                              time_text(run, run.second), independent(known.third),
                              time_text(run, run.third)});
  context.page.table(table, "Beside an independent computation of the same chain (times in s).");
}

double relative_error(const std::vector<FputRun>& runs, std::string_view method, double product,
                      double reference) {
  for (const FputRun& run : runs)
    if (run.method == method && std::abs(run.step * kFputOmega - product) < 1e-9 && run.second)
      return std::abs(*run.second / reference - 1.0);
  return std::numeric_limits<double>::quiet_NaN();
}

std::vector<Criterion> judge(const std::vector<FputRun>& references,
                             const std::vector<FputRun>& runs, double reference) {
  std::vector<Criterion> criteria;
  criteria.push_back(at_most("FPUT, reference: |first I2 > I1 - 58.9 s|, the known time (s)",
                             std::abs(reference - 58.9), 0.1));
  if (references.size() > 1)
    criteria.push_back(at_most("FPUT, verlet and verlet4 at h omega = 0.01: difference (s)",
                               std::abs(*references[0].second - *references[1].second), 0.05));
  criteria.push_back(at_most("FPUT, ep4 at h omega = 1: first I2 > I1, relative error",
                             relative_error(runs, "ep4", 1.0, reference), 0.01));
  criteria.push_back(at_most("FPUT, ep4 at h omega = 1.5: first I2 > I1, relative error",
                             relative_error(runs, "ep4", 1.5, reference), 0.08));
  for (const double product : kProducts)
    criteria.push_back(
        at_most(fmt::format("FPUT, imexv-linear at h omega = {:.3g}: first I2 > I1, relative error",
                            product),
                relative_error(runs, "imexv-linear", product, reference), 0.15));
  return criteria;
}

}  // namespace

Criteria add_fput_section(const SectionContext& context) {
  context.page.section("Known answers: the chain of Fermi, Pasta, Ulam and Tsingou");
  context.page.paragraph(
      "Three stiff springs (omega = 50) joined by soft quartic ones (Hairer, Lubich & Wanner, "
      "Geometric Numerical Integration, I.5, m = 3), until t = 200. The energy I_j of a stiff "
      "spring passes slowly to its neighbour; does a method that does not resolve omega still get "
      "the time right? The potential is exactly quartic, so the chain is a model like any other. "
      "A model wants lambda > 0: the slow coordinates have 1e-12, which adds 5e-13 to an energy of "
      "about 2. The splitting methods take the three slow coordinates explicitly and the three "
      "fast ones implicitly; `imexv-adaptive` splits by its own rule. Times are read at the ends "
      "of steps.");
  std::vector<FputRun> references, runs;
  for (const std::string_view method : {"verlet", "verlet4"}) {
    Result<FputRun> run = stored_fput_run(context, method, kReferenceStep, 500);
    if (!run) return run.error();
    references.push_back(std::move(*run));
  }
  for (const std::string_view method : integrator_names())
    for (const double product : kProducts) {
      Result<FputRun> run = stored_fput_run(context, method, product / kFputOmega, 0);
      if (!run) return run.error();
      runs.push_back(std::move(*run));
    }
  if (references.empty() || !references[0].second)
    return Error{ErrorKind::kSolver, "the reference of the FPUT chain shows no exchange"};
  const double reference = *references[0].second;
  std::string line = "Reference:";
  for (const FputRun& run : references)
    line +=
        fmt::format(" `{}` at h = 2e-4: {:.2f} s and {:.2f} s, I in [{:.3f}, {:.3f}].", run.method,
                    run.second.value_or(0.0), run.third.value_or(0.0), run.lowest, run.highest);
  context.page.paragraph(line);
  if (Status status = add_run_tables(context, references, runs); !status) return status.error();
  add_comparison(context, runs);

  const Result<std::string> exchange = draw_svg({exchange_chart(runs, reference)}, 1, 900, 460);
  if (!exchange) return exchange.error();
  context.page.figure(*exchange,
                      "A method's curve ends where it shows no exchange until t = 200 or fails.");
  std::vector<Chart> panels{energies_chart(references[0])};
  const std::pair<const char*, double> shown[] = {
      {"ep4", 1.0}, {"ep4", 1.5}, {"midpoint", 1.5}, {"imexv-linear", kPi}, {"imexv-linear", 10.0}};
  for (const auto& [method, product] : shown) {
    const Result<FputRun> run = stored_fput_run(context, method, product / kFputOmega, 4);
    if (!run) return run.error();
    panels.push_back(energies_chart(*run));
  }
  const Result<std::string> energies = draw_svg(panels, 2, 480, 260);
  if (!energies) return energies.error();
  context.page.figure(*energies, "Energies of the three stiff springs and their sum I.");
  return judge(references, runs, reference);
}

}  // namespace tremolo::known
