#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "tests/lab/known/fput.h"
#include "tests/lab/known/known_answers.h"
#include "tests/lab/samples/published.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {

// The stored data of a run; its method and step are in the name.
template <class Archive>
void fields(Archive& archive, FputRun& run) {
  archive("second", run.second, "third", run.third, "lost", run.lost, "lowest", run.lowest,
          "highest", run.highest, "energy_error", run.energy_error, "reached", run.reached,
          "cut_steps", run.cut_steps, "failure", run.failure, "series", run.series);
}

inline void to_json(nlohmann::json& json, const FputEnergies& e) {
  json = {e.t, e.i[0], e.i[1], e.i[2]};
}
inline void from_json(const nlohmann::json& json, FputEnergies& e) {
  e = {to_number(json[0]), {to_number(json[1]), to_number(json[2]), to_number(json[3])}};
}

namespace {

constexpr double kProducts[] = {0.5, 1.0, 1.5, 2.0, std::numbers::pi, 5.0, 10.0};  // h omega
constexpr double kReferenceStep = 2e-4;                                            // s
constexpr double kPi = std::numbers::pi;

// A run of fput.csv, computed by others; empty: never.
struct Independent {
  std::string method;
  double product = 0.0;
  std::optional<double> second = {}, third = {};
};

std::vector<Independent> read_independent(const std::string& directory) {
  PublishedTable table(directory, "fput.csv", "method,h-omega,second,third");
  std::vector<Independent> runs;
  while (table.next()) {
    Independent run{.method = table.word("a method"), .product = table.number("h omega")};
    run.second = table.number_or("never", "the first time when I2 > I1");
    run.third = table.number_or("never", "the first time when I3 > I1");
    runs.push_back(std::move(run));
  }
  if (runs.empty() || runs.front().method != "reference" || !runs.front().second)
    table.fail("the first run is not the reference with its times");
  return runs;
}

FputRun stored_run(const Store& store, std::string_view method, double step, long every) {
  const nlohmann::json key = {{"experiment", "fput"},
                              {"version", 2},
                              {"method", std::string(method)},
                              {"step", step},
                              {"every", every}};
  FputRun run = store.get_as<FputRun>(fmt::format("known-fput-{}-{:.6g}-{}", method, step, every),
                                      key, [&] { return run_fput(method, step, every); });
  run.method = method;
  run.step = step;
  return run;
}

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

void add_run_tables(Report& report, const std::vector<FputRun>& references,
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
  report.table(times,
               "First I2 > I1 / first I3 > I1, s, over h omega. fails: the orbit left ten times "
               "its energy or the solver gave up. I lost: the sum of the three left [1/2, 2] of "
               "its start, so that a later crossing is no exchange.");
  report.file(all, "known-fput.csv");
}

void add_comparison(Report& report, const std::vector<Independent>& independent,
                    const std::vector<FputRun>& runs) {
  Table table{{"method", "h omega", "I2 > I1, independent", "here", "I3 > I1, independent", "here"},
              {}};
  const auto text = [](const std::optional<double>& t) {
    return t ? fmt::format("{:.1f}", *t) : "never";
  };
  for (const Independent& known : independent)
    for (const FputRun& run : runs)
      if (run.method == known.method && std::abs(run.step * kFputOmega - known.product) < 1e-9)
        table.rows.push_back({run.method, cell(known.product), text(known.second),
                              time_text(run, run.second), text(known.third),
                              time_text(run, run.third)});
  report.table(table, "Beside an independent computation of the same chain (times in s).");
}

double relative_error(const std::vector<FputRun>& runs, std::string_view method, double product,
                      double reference) {
  for (const FputRun& run : runs)
    if (run.method == method && std::abs(run.step * kFputOmega - product) < 1e-9 && run.second)
      return std::abs(*run.second / reference - 1.0);
  return std::numeric_limits<double>::quiet_NaN();
}

std::vector<Criterion> judge(const std::vector<FputRun>& references,
                             const std::vector<FputRun>& runs, double reference, double known) {
  std::vector<Criterion> criteria;
  criteria.push_back(
      at_most(fmt::format("FPUT, reference: |first I2 > I1 - {:g} s|, the known time (s)", known),
              std::abs(reference - known), 0.1));
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

// As charts, the energies of the reference and of some runs.
void add_energies(const Experiments& experiments, const FputRun& reference) {
  std::vector<Chart> panels{energies_chart(reference)};
  const std::pair<const char*, double> shown[] = {
      {"ep4", 1.0}, {"ep4", 1.5}, {"midpoint", 1.5}, {"imexv-linear", kPi}, {"imexv-linear", 10.0}};
  for (const auto& [method, product] : shown)
    panels.push_back(
        energies_chart(stored_run(experiments.store, method, product / kFputOmega, 4)));
  experiments.report.figure(panels, 2, 260, "Energies of the three stiff springs and their sum I.");
}

}  // namespace

std::vector<Criterion> add_fput_section(const Experiments& experiments) {
  Report& report = experiments.report;
  const std::vector<Independent> independent = read_independent(experiments.published);
  report.section("Known answers: the chain of Fermi, Pasta, Ulam and Tsingou");
  report.paragraph(
      "Three stiff springs (omega = 50) joined by soft quartic ones (Hairer, Lubich & Wanner, "
      "Geometric Numerical Integration, I.5, m = 3), until t = 200. The energy I_j of a stiff "
      "spring passes slowly to its neighbour; does a method that does not resolve omega still get "
      "the time right? The potential is exactly quartic, so the chain is a model like any other. A "
      "model wants lambda > 0: the slow coordinates have 1e-12, which adds 5e-13 to an energy of "
      "about 2. The splitting methods take the three slow coordinates explicitly and the three "
      "fast ones implicitly; `imexv-adaptive` splits by its own rule. Times are read at the ends "
      "of steps.");
  std::vector<FputRun> references, runs;
  for (const std::string_view method : {"verlet", "verlet4"})
    references.push_back(stored_run(experiments.store, method, kReferenceStep, 500));
  for (const std::string_view method : integrator_names())
    for (const double product : kProducts)
      runs.push_back(stored_run(experiments.store, method, product / kFputOmega, 0));
  if (!references[0].second || !references[1].second)
    throw Failure({ErrorKind::kSolver, "the reference of the FPUT chain shows no exchange"});
  const double reference = *references[0].second;
  std::string line = "Reference:";
  for (const FputRun& run : references)
    line +=
        fmt::format(" `{}` at h = 2e-4: {:.2f} s and {:.2f} s, I in [{:.3f}, {:.3f}].", run.method,
                    run.second.value_or(0.0), run.third.value_or(0.0), run.lowest, run.highest);
  report.paragraph(line);
  add_run_tables(report, references, runs);
  add_comparison(report, independent, runs);
  report.figure({exchange_chart(runs, reference)}, 1, 460,
                "A method's curve ends where it shows no exchange until t = 200 or fails.");
  add_energies(experiments, references[0]);
  return judge(references, runs, reference, *independent.front().second);
}

}  // namespace tremolo::known
