#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tests/lab/reproduce/sections.h"

namespace tremolo::reproduce {
namespace {

constexpr const char* kOverlay = "#333333";  // ep4, dashed over the thesis's curve
constexpr double kAlpha = thesis::kAlpha;
constexpr std::array<const char*, 3> kStepMethods = {"imexv", "newmark", "ep4"};  // experiment 4

// alphas: the rows of panels. note: a remark about the thesis's own figure.
struct EnergyFigure {
  std::string number;
  std::string model;
  SignalKind load;
  std::vector<double> alphas;
  std::string note;
};

std::vector<EnergyFigure> energy_figures(const thesis::Thesis& thesis) {
  constexpr SignalKind kImpulse = SignalKind::kImpulse, kSquare = SignalKind::kSquare,
                       kSine = SignalKind::kSine;
  const std::vector<double> both{0.0, kAlpha};
  const std::string sampled =
      "In the thesis the two panels differ because the impulse is sampled: one method sees it with "
      "weight 1/2, the other with weight 1. Here every method receives the same impulse.";
  const auto reached = [&](const char* model, double alpha) {
    return thesis.run(model, kSine, alpha)->reached;
  };
  const std::string beam_fails = fmt::format(
      "The thesis's IMEXv breaks off in this figure at {:.2f} s undamped and {:.2f} s damped; our "
      "force is one at which ours does so too, at times of its own (table 3).",
      reached("beam", 0.0), reached("beam", kAlpha));
  const std::string tower_fails = fmt::format(
      "The thesis's IMEXv breaks off in this figure at {:.2f} s undamped and reaches {:g} s "
      "damped; our force is one at which ours does nearly the same (table 3).",
      reached("tower", 0.0), reached("tower", kAlpha));
  const std::string no_figure =
      "The thesis has no such figure: its figure 29 is captioned basket, sine, which figure 27 "
      "already is, and is probably the bridge's; an impulse on the bridge is missing.";
  return {{"13", "horse", kImpulse, {0.0}, sampled},
          {"14", "horse", kSquare, {0.0}, ""},
          {"15", "horse", kSine, {0.0}, ""},
          {"16", "horse", kImpulse, {kAlpha}, ""},
          {"22", "beam", kImpulse, both, ""},
          {"23", "beam", kSquare, both, ""},
          {"24", "beam", kSine, both, beam_fails},
          {"25", "basket", kImpulse, both, ""},
          {"26", "basket", kSquare, both, ""},
          {"27", "basket", kSine, both, ""},
          {"28", "bridge", kSquare, both, ""},
          {"29", "bridge", kSine, both,
           "Its caption says basket, sine; that is figure 27, so it is probably the bridge."},
          {"29a", "bridge", kImpulse, both, no_figure},
          {"30", "tower", kImpulse, both, ""},
          {"31", "tower", kSquare, both, ""},
          {"32", "tower", kSine, both, tower_fails},
          {"33", "heart", kImpulse, both, ""},
          {"34", "heart", kSquare, both, ""},
          {"35", "heart", kSine, both, ""}};
}

bool has(const Session& session, const std::string& model) {
  return std::ranges::find(session.models, model, &SampleModel::name) != session.models.end();
}

std::string damping_text(double alpha) {
  return alpha == 0.0 ? "no damping" : fmt::format("alpha = {:g}", alpha);
}

// Methods whose mean energies differ by less are called equal.
constexpr double kEqual = 0.005;

double mean_ratio(const EnergyFigure& figure, double alpha, const Orbits& orbits) {
  const auto mean_of = [&](const char* method) {
    return orbits.at(RunName{figure.model, method, figure.load, alpha}.text()).mean_energy;
  };
  return mean_of("newmark") / mean_of("imexv");
}

// The reason why the mean energies differ, as far as the energy balance shows it.
std::string reason_text(const EnergyFigure& figure, double alpha, double ratio,
                        const Orbits& orbits) {
  if (figure.load == SignalKind::kSine)
    return "the load lasts, and its work depends on the phase that a method's frequencies give";
  const double undamped = mean_ratio(figure, 0.0, orbits);
  if (alpha > 0.0 && std::abs(ratio / undamped - 1.0) >= kEqual)
    return "Newmark takes only 1/(1 + (h omega/2)^2) of its due off a fast mode and imexv all of "
           "it; the thesis calls the two decays very similar";
  if (alpha > 0.0) return "as undamped";
  const double swing =
      orbits.at(RunName{figure.model, "imexv", figure.load, alpha}.text()).energy_drift;
  if (std::abs(ratio - 1.0) <= swing)
    return fmt::format("within the swing of imexv's energy, {:.1f} %", 100.0 * swing);
  return fmt::format(
      "more than the swing of imexv's energy, {:.2f} %: the load has done different work",
      100.0 * swing);
}

// The differences between the panels of one row, and their reason.
std::string difference_text(const EnergyFigure& figure, double alpha, const Orbits& orbits) {
  const std::string start = fmt::format(" {}: ", alpha == 0.0 ? "Undamped" : "Damped");
  for (const char* method : {"imexv", "newmark"}) {
    const Orbit& one = orbits.at(RunName{figure.model, method, figure.load, alpha}.text());
    if (!one.finished())
      return start + fmt::format("{} breaks off at {:.2f} s, {}.", method, one.reached, one.reason);
  }
  const double ratio = mean_ratio(figure, alpha, orbits);
  if (std::abs(ratio - 1.0) < kEqual) return start + "the mean energies are equal to 0.5 %.";
  return start + fmt::format("newmark's mean energy is {:.3f} times imexv's ({}).", ratio,
                             reason_text(figure, alpha, ratio, orbits));
}

Curve curve_of(const Orbit& orbit, const std::string& label) {
  return {label, orbit.total.t, orbit.total.y, CurveStyle::kLines, {}};
}

Curve overlay_of(const Orbit& orbit) {
  return {"ep4", orbit.total.t, orbit.total.y, CurveStyle::kDashes, kOverlay};
}

void add_rows(Table& table, const std::string& panel, const Orbit& orbit) {
  for (std::size_t i = 0; i < orbit.total.t.size(); ++i)
    table.rows.push_back({panel, cell(orbit.total.t[i], 7), cell(orbit.total.y[i], 7)});
}

// The chart of one method with ep4 over it; their values are added to `series`. The chart of imexv
// adds ep4's.
Chart method_chart(const EnergyFigure& figure, const std::string& method, double alpha,
                   const Orbits& orbits, Table& series) {
  const RunName run{figure.model, method, figure.load, alpha};
  const RunName other{figure.model, "ep4", figure.load, alpha};
  const Orbit &orbit = orbits.at(run.text()), &ep4 = orbits.at(other.text());
  add_rows(series, run.text(), orbit);
  if (method == "imexv") add_rows(series, other.text(), ep4);
  return {
      .title = fmt::format("{}, {}", method == "imexv" ? "IMEXv" : "Newmark", damping_text(alpha)),
      .x_label = "t (s)",
      .y_label = "energy (J)",
      .x_range = {{0.0, thesis::kDuration}},
      .curves = {curve_of(orbit, method), overlay_of(ep4)}};
}

// The largest energy of the runs that reach the end: a run that blows up leaves its frame.
double highest_energy(const EnergyFigure& figure, double alpha, const Orbits& orbits) {
  double top = 0.0;
  for (const char* method : {"imexv", "newmark", "ep4"}) {
    const Orbit& orbit = orbits.at(RunName{figure.model, method, figure.load, alpha}.text());
    if (orbit.finished()) top = std::max(top, orbit.highest_energy);
  }
  return top;
}

void add_one(Report& report, const EnergyFigure& figure, const Orbits& orbits) {
  std::vector<Chart> charts;
  Table series{{"run", "t", "total"}, {}};
  for (const double alpha : figure.alphas) {
    const double top = highest_energy(figure, alpha, orbits);
    for (const char* method : {"imexv", "newmark"}) {
      charts.push_back(method_chart(figure, method, alpha, orbits, series));
      if (top > 0.0) charts.back().y_range = {{0.0, 1.08 * top}};
    }
  }
  std::string caption = fmt::format("Figure {}: {}, {}. Total energy.", figure.number, figure.model,
                                    thesis::load_name(figure.load));
  if (!figure.note.empty()) caption += " " + figure.note;
  for (const double alpha : figure.alphas) caption += difference_text(figure, alpha, orbits);
  report.figure(charts, 2, 300, caption);
  report.file(series, fmt::format("figure-{}.csv", figure.number));
}

// The effect of the longest step on each method's mean energy.
std::string step_text(const Orbits& orbits, double duration) {
  std::vector<std::string> parts;
  for (const char* method : kStepMethods) {
    const auto at = [&](double step) -> const Orbit& {
      return orbits.at(
          RunName{"beam", method, SignalKind::kSquare, 0.0, 1.0, step, duration}.text());
    };
    parts.push_back(at(10e-3).finished() ? fmt::format("{} {:.3f}", method,
                                                       at(10e-3).mean_energy / at(1e-3).mean_energy)
                                         : fmt::format("{} breaks off", method));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

// One figure: the methods side by side, with one curve for each step. The longer one adds its
// table.
void add_step_figure(Report& report, const Session& session, const std::string& number,
                     double duration) {
  std::vector<RunName> runs;
  for (const char* method : kStepMethods)
    for (const double step : {10e-3, 5e-3, 1e-3})
      runs.push_back({"beam", method, SignalKind::kSquare, 0.0, 1.0, step, duration});
  const Orbits orbits = run_all(session, runs, "figure " + number);
  std::vector<Chart> charts;
  Table series{{"run", "t", "total"}, {}};
  Table numbers{{"method", "h, ms", "reached, s", "mean energy, J", "drift", "iterations a step"},
                {}};
  for (const RunName& run : runs) {
    const Orbit& orbit = orbits.at(run.text());
    if (charts.empty() || charts.back().title != run.integrator)
      charts.push_back({.title = run.integrator,
                        .x_label = "t (s)",
                        .y_label = "energy (J)",
                        .x_range = {{0.0, duration}}});
    charts.back().curves.push_back(curve_of(orbit, fmt::format("h = {:g} ms", 1e3 * run.step)));
    add_rows(series, run.text(), orbit);
    numbers.rows.push_back({run.integrator, cell(1e3 * run.step),
                            fmt::format("{:.2f}{}", orbit.reached, orbit.finished() ? "" : "*"),
                            cell(orbit.mean_energy), cell(orbit.energy_drift, 2),
                            cell(orbit.iterations_per_step, 3)});
  }
  report.figure(
      charts, static_cast<int>(charts.size()), 300,
      fmt::format(
          "Figure {}: beam, square load, no damping, three steps, {:g} s. The thesis shows IMEXv "
          "and Newmark, in pictures without values. Mean energy at 10 ms over that at 1 ms: {}.",
          number, duration, step_text(orbits, duration)));
  report.file(series, fmt::format("figure-{}.csv", number));
  if (duration == thesis::kDuration)
    report.table(numbers, "Experiment 4 in numbers; * broke off.", "experiment-4.csv");
}

}  // namespace

void add_energy_figures(Report& report, const Session& session, const Orbits& orbits) {
  for (const EnergyFigure& figure : energy_figures(session.thesis))
    if (has(session, figure.model)) add_one(report, figure, orbits);
}

void add_step_figures(Report& report, const Session& session) {
  report.section("Experiment 4: the step");
  if (!has(session, "beam")) return;
  add_step_figure(report, session, "18", thesis::kDuration);
  add_step_figure(report, session, "19", 1.0);
}

}  // namespace tremolo::reproduce
