#include "tests/lab/bench/precision_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/statistics.h"

namespace tremolo::bench {
namespace {

bool ran(const Precision& precision, const std::string& integrator) {
  return std::ranges::find(precision.integrators, integrator) != precision.integrators.end();
}

Chart empty_chart(std::string title) {
  Chart chart;
  chart.title = std::move(title);
  chart.x_label = "computing (ms) a simulated second";
  chart.y_label = "trajectory error";
  chart.log_x = chart.log_y = true;
  return chart;
}

Chart scene_chart(const Precision& precision, std::size_t i) {
  Chart chart = empty_chart(fmt::format("{}, {}", precision.scenes[i].subject->sample.name,
                                        percent(precision.scenes[i].amplitude)));
  for (const std::string& integrator : precision.integrators) {
    Curve curve{.label = integrator, .style = CurveStyle::kLinesAndPoints};
    for (const Entry& entry : precision.curve(i, integrator)) {
      // An error above 200 % says nothing about the method any more.
      const bool counts = !entry.below_reference && entry.error < 2.0;
      curve.x.push_back(entry.cost());
      curve.y.push_back(counts ? entry.error : NAN);
    }
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

// Geometric means over the square-load scenes up to 15 %, at each step where all runs finished.
Chart summary_chart(const Precision& precision, const std::string& load) {
  Chart chart = empty_chart("all models, up to 15 %, " + load + " load");
  for (const std::string& integrator : precision.integrators) {
    Curve curve{.label = integrator, .style = CurveStyle::kLinesAndPoints};
    for (std::size_t s = 0; s < precision.steps.size(); ++s) {
      double cost = 0.0, error = 0.0, count = 0.0;
      for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
        const Scene& scene = precision.scenes[i];
        if (scene.load != load || scene.amplitude > 0.15 || !precision.measured(i)) continue;
        const Entry& entry = precision.curve(i, integrator)[s];
        cost += std::log(entry.cost());
        error += std::log(std::max(entry.error, kAbove * precision.references[i].gap));
        ++count;
      }
      curve.x.push_back(std::exp(cost / count));
      curve.y.push_back(error / count < std::log(2.0) ? std::exp(error / count) : NAN);
    }
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

// A figure an entry of the chart's group, in the order in which the groups come.
void draw_curves(const Precision& precision, const std::string& load, Report& report) {
  for (const Subject& subject : precision.subjects) {
    std::vector<Chart> charts;
    for (std::size_t i = 0; i < precision.scenes.size(); ++i)
      if (precision.scenes[i].subject == &subject && precision.scenes[i].load == load &&
          precision.measured(i))
        charts.push_back(scene_chart(precision, i));
    if (charts.empty()) continue;
    report.heading(subject.sample.name);
    report.figure(
        charts, 2, 380,
        fmt::format(
            "{}, {} load: error over cost, a point a step from {:g} to {:g} ms. Errors below the "
            "reference, and orbits that are wrong by more than 200 %, are left out.",
            subject.sample.name, load, 1e3 * precision.steps.front(),
            1e3 * precision.steps.back()));
  }
}

const Entry* at_step(std::span<const Entry> curve, double step) {
  const auto found = std::ranges::find_if(
      curve, [&](const Entry& entry) { return std::abs(entry.step - step) < 1e-9 * step; });
  return found == curve.end() ? nullptr : &*found;
}

// The worst value over scenes, and the scene where it occurs.
struct Worst {
  double value = NAN;
  std::string where;
  int count = 0;

  void take(double candidate, bool worse, const Scene& scene) {
    ++count;
    if (count > 1 && !worse) return;
    value = candidate;
    where = fmt::format("{}, {}", scene.subject->sample.name, percent(scene.amplitude));
  }
};

void add_step_criteria(const Precision& precision, std::vector<Criterion>& criteria) {
  Worst error, horizon;
  std::map<std::string, Worst> factor;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    const Scene& scene = precision.scenes[i];
    if (scene.load != "square" || scene.amplitude > 0.15 || !precision.measured(i)) continue;
    const Entry* mine = at_step(precision.curve(i, "ep4"), 3e-3);
    if (mine == nullptr) return;
    const Reference& reference = precision.references[i];
    const double own = std::max(mine->error, kAbove * reference.gap);
    error.take(own, own > error.value, scene);
    horizon.take(reference.seconds, reference.seconds < horizon.value, scene);
    for (const char* peer : {"newmark", "imexv"}) {
      if (!ran(precision, peer)) continue;
      const double ratio = at_step(precision.curve(i, peer), 3e-3)->error / own;
      Worst& worst = factor[peer];
      worst.take(ratio, !(ratio >= worst.value), scene);
    }
  }
  if (error.count == 0) return;
  criteria.push_back({"ep4 at 3 ms, square load, up to 15 %: trajectory error", "<= 1 %",
                      fmt::format("{:.3g} % ({}); references agree until {:.3g} s or later",
                                  100.0 * error.value, error.where, horizon.value),
                      error.value <= 0.01});
  for (const auto& [peer, worst] : factor)
    criteria.push_back({fmt::format("the same, error of `{}` over ep4's, smallest", peer), ">= 10",
                        fmt::format("{:.3g} ({})", worst.value, worst.where), worst.value >= 10.0});
}

// Scenes in which the cost of a method is only known from above.
int coarse_scenes(const Precision& precision, const std::string& integrator, double target) {
  int count = 0;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    if (!precision.measured(i)) continue;
    const std::optional<Cost> cost =
        cost_of_error(precision.curve(i, integrator), target, precision.references[i].gap);
    count += cost && cost->at_most ? 1 : 0;
  }
  return count;
}

}  // namespace

std::vector<Criterion> precision_criteria(const Precision& precision) {
  std::vector<Criterion> criteria;
  if (!ran(precision, "ep4")) return criteria;
  add_step_criteria(precision, criteria);
  const int coarse = coarse_scenes(precision, "ep4", 1e-3);
  const std::string slack = coarse == 0 ? std::string()
                                        : fmt::format(
                                              "; in {} scenes ep4's longest step is good enough "
                                              "already, a longer one might cost less",
                                              coarse);
  for (const char* peer : {"newmark", "imexv", "verlet", "verlet4"}) {
    if (!ran(precision, peer)) continue;
    const std::vector<double> ratios = cost_ratios(precision, "ep4", peer, 1e-3);
    const double middle = median(ratios);
    const bool decides = std::string_view(peer).substr(0, 6) != "verlet" && !ratios.empty();
    criteria.push_back(
        {fmt::format("time to 0.1 %: `{}` over ep4, median of {} scenes", peer, ratios.size()),
         decides ? ">= 4" : "",
         (std::isinf(middle) ? "only ep4 reaches it" : cell(middle, 3)) + slack, middle >= 4.0,
         decides});
  }
  return criteria;
}

std::vector<std::string> recommendations(const Precision& precision) {
  std::vector<std::string> sentences;
  for (const double target : kTargets) {
    const std::vector<Standing> table = standings(precision, target);
    if (table.empty() || table.front().reached == 0) {
      sentences.push_back(
          fmt::format("For an error of {}: no method reaches it.", percent(target)));
      continue;
    }
    const Standing& surest = table.front();
    const Standing& most = *std::ranges::max_element(table, {}, &Standing::wins);
    std::string text = fmt::format(
        "For an error of {}: `{}`. It reaches it in {} of {} scenes, at {:.3g} times the cost of "
        "the fastest method of each scene (median).",
        percent(target), surest.integrator, surest.reached, surest.scenes, surest.slowdown);
    if (most.integrator != surest.integrator)
      text += fmt::format(" `{}` is the fastest most often, in {} scenes, and reaches it in {}.",
                          most.integrator, most.wins, most.reached);
    sentences.push_back(std::move(text));
  }
  return sentences;
}

void report_precision(const Precision& precision, Report& report) {
  report.file(bench_table(precision), "bench.csv");
  report.file(cost_table(precision), "cost.csv");
  const std::string load = precision.scenes.empty() ? "square" : precision.scenes.front().load;

  report.section("What to use");
  for (const std::string& sentence : recommendations(precision)) report.paragraph(sentence);
  for (const double target : kTargets)
    report.table(standing_table(precision, target),
                 fmt::format("Error of {}, all scenes: those that reach it most often first.",
                             percent(target)));
  report.section("Error over cost");
  report.figure({summary_chart(precision, load)}, 1, 520,
                "Geometric means over the models and the amplitudes up to 15 %, at each step at "
                "which every run reached the end.");
  draw_curves(precision, load, report);
  report.section("Cost of an error");
  report.paragraph(
      "Milliseconds of computing a simulated second, one thread, by log-log interpolation between "
      "steps. `<=`: the longest step is good enough already. Empty: not reached. All loads are in "
      "`cost.csv`.");
  for (const double target : kTargets)
    report.table(cost_matrix(precision, load, target),
                 fmt::format("To an error of {}, {} load.", percent(target), load));
  report.section("Ratios");
  report.paragraph(
      "How many times less a method costs than another for the same error: medians over all "
      "scenes. A scene that only the method reaches counts as infinite (`> all`), one that only "
      "the other reaches as zero.");
  report.table(ratio_table(precision));
  report.section("Scenes and references");
  const std::vector<ReferenceMethod> methods = reference_methods();
  report.paragraph(
      fmt::format("The amplitude is the largest displacement of the loaded vertex over the largest "
                  "extent of the solid; the load is scaled until that holds to 1 %. Every "
                  "reference is computed twice, with `{}` at {:.4g} ms and with `{}` at {:.4g} ms; "
                  "errors are measured up to the last sample until which the two agree to {:g} of "
                  "the orbit's size, and count while they are {:g} times above the remaining gap. "
                  "Large motion is chaotic: where the references part, no orbit is right.",
                  methods[0].integrator, 1e3 * methods[0].step, methods[1].integrator,
                  1e3 * methods[1].step, kAgree, kAbove));
  report.table(scene_table(precision), {}, "scenes.csv");
}

}  // namespace tremolo::bench
