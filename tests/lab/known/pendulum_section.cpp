#include <cmath>

#include <fmt/format.h>

#include "tests/lab/known/known_answers.h"
#include "tests/lab/known/pendulum.h"

namespace tremolo::known {
namespace {

constexpr double kPendulumStep = 0.005;  // s
constexpr double kDuration = 20.0;       // s
constexpr double kSwings = 2.0;          // periods in the first and the last window

enum class Fate { kGrows, kShrinks, kStays };

struct Expected {
  std::string_view method;
  Fate fate;
  bool panel;  // has its panels in the figure
};
constexpr Expected kExpected[] = {
    {"explicit-euler", Fate::kGrows, true}, {"implicit-euler", Fate::kShrinks, true},
    {"verlet", Fate::kStays, true},         {"midpoint", Fate::kStays, true},
    {"imexv", Fate::kStays, true},          {"ep4", Fate::kStays, true},
    {"verlet4", Fate::kStays, false},       {"newmark", Fate::kStays, false},
    {"imexv-linear", Fate::kStays, false},  {"imexv-coupled", Fate::kStays, false},
    {"avf", Fate::kStays, false},           {"ep2", Fate::kStays, false},
};

Criterion judge(const PendulumRun& run, Fate fate) {
  const double ratio = run.last / run.first;
  Criterion criterion;
  const char* what = fate == Fate::kGrows ? "grows" : fate == Fate::kShrinks ? "shrinks" : "stays";
  criterion.what =
      fmt::format("pendulum, {}: amplitude {}, last over first swings", run.method, what);
  criterion.measured = cell(ratio, 5) + (run.failure.empty() ? "" : ", " + run.failure);
  if (fate == Fate::kGrows) {
    criterion.bound = "> 1";
    criterion.met = ratio > 1.0;
  } else if (fate == Fate::kShrinks) {
    criterion.bound = "< 1";
    criterion.met = ratio < 1.0 && run.failure.empty();
  } else {
    criterion.bound = "1 +- 0.01";
    criterion.met = std::abs(ratio - 1.0) <= 0.01 && run.failure.empty();
  }
  return criterion;
}

void add_panels(const PendulumRun& run, std::vector<Chart>& angles, std::vector<Chart>& paths) {
  Chart angle{.title = run.method, .x_label = "t (s)", .y_label = "angle (rad)"};
  angle.x_range = {0.0, kDuration};
  angle.y_range = {-3.2, 3.2};
  angle.curves.push_back({.x = run.t, .y = run.angle, .colour = "#0060a8"});
  angles.push_back(std::move(angle));
  Chart path{.title = run.method, .x_label = "x (m)", .y_label = "y (m)"};
  path.x_range = {-2.0, 2.0};
  path.y_range = {-2.0, 1.0};
  path.curves.push_back({.x = run.x, .y = run.y, .colour = "#0060a8"});
  paths.push_back(std::move(path));
}

}  // namespace

std::vector<Criterion> add_pendulum_section(const Experiments& experiments) {
  const Pendulum pendulum;
  const Model::Pointer model = pendulum_model(pendulum);
  Report& report = experiments.report;
  report.section("Known answers: the pendulum");
  report.paragraph(fmt::format(
      "After the thesis's figure 9. The ideal pendulum is one stiff StVK bar of 1 m, V = (k L^2/8) "
      "(|x|^2/L^2 - 1)^2 + g y per kg, which is exactly quartic: about its hanging rest it becomes "
      "a model of two coordinates. k = {:g} /s^2; h = {:g} s, so that h omega is {:.3f} for the "
      "swing and {:.3f} for the stretch, which keeps the explicit methods in their range; start at "
      "{:g} rad, at rest; {:g} s. Explicit Euler takes energy from nowhere, implicit Euler loses "
      "it, the variational methods and `ep4` keep the swing. Amplitudes are the largest |angle| "
      "over the first and the last {:g} periods.",
      pendulum.stiffness, kPendulumStep, kPendulumStep * std::sqrt(model->lambda()[0]),
      kPendulumStep * std::sqrt(model->lambda()[1]), pendulum.angle, kDuration, kSwings));
  Table table{
      {"method", "first swings (rad)", "last swings (rad)", "ratio", "reached (s)", "failure"}, {}};
  std::vector<Criterion> criteria;
  std::vector<Chart> angles, paths;
  for (const Expected& expected : kExpected) {
    const PendulumRun run =
        run_pendulum(pendulum, expected.method, kPendulumStep, kDuration, kSwings);
    table.rows.push_back({run.method, cell(run.first, 5), cell(run.last, 5),
                          cell(run.last / run.first, 5), cell(run.reached), run.failure});
    criteria.push_back(judge(run, expected.fate));
    if (expected.panel) add_panels(run, angles, paths);
  }
  report.table(table, "Amplitude of the swing.", "known-pendulum.csv");
  report.figure(angles, 2, 200, "Angle of the swing over time.");
  report.figure(paths, 3, 260, "Path of the bar's end; the pivot is at the origin.");
  return criteria;
}

}  // namespace tremolo::known
