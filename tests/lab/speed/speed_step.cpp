// Whole steps against the textbook's Newmark method and central differences.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "runtime/body.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/speed/textbook.h"

namespace tremolo::bench {
namespace {

using Eigen::VectorXd;

constexpr double kStep = 3e-3;       // s
constexpr double kTolerance = 1e-6;  // of the residual, all methods
constexpr int kWindow = 200;         // steps, from the same state each time

struct OurRunner {
  Body body;
  State start;
  std::int64_t iterations = 0;

  void window() {
    if (!body.set_state(start.q, start.p)) return;
    const std::int64_t before = body.iterations();
    for (int k = 0; k < kWindow; ++k) body.step();
    iterations = body.iterations() - before;
  }
};

struct TextbookRunner {
  Textbook textbook;
  State start;
  VectorXd acceleration;
  double step;
  int evaluations = 0;

  void newmark() {
    VectorXd q = start.q, v = start.p, a = acceleration;
    evaluations = 0;
    for (int k = 0; k < kWindow; ++k)
      evaluations += textbook_newmark_step(textbook, step, kTolerance, q, v, a);
  }
  void central_differences() {
    VectorXd q = start.q, v = start.p;
    for (int k = 0; k < kWindow; ++k) textbook_central_difference_step(textbook, step, q, v);
  }
};

// Pushed for 0.3 s so that the loaded vertex goes some 5 % of the size: the default load does.
Result<State> shaken_state(const Model::Pointer& model) {
  Result<Body> body = Body::create(model, "ep4", {.step = kStep});
  if (!body) return body.error();
  if (Status s = body->add_default_load(Signal{.kind = SignalKind::kSquare, .duration = 0.3}); !s)
    return s.error();
  while (body->time() < 0.35)
    if (!body->step().converged) return Error{ErrorKind::kSolver, "a step did not converge"};
  return body->state();
}

Result<OurRunner> make_runner(const Model::Pointer& model, const char* method, double step,
                              const State& start) {
  Result<Body> body = Body::create(model, method, {.step = step, .tolerance = kTolerance});
  if (!body) return body.error();
  return OurRunner{std::move(*body), start};
}

// Every step of the same 100 000 several times; the smallest of each is free of interruptions.
struct Tail {
  double median = 0.0;  // us
  double worst = 0.0;   // over the median
  int slow = 0;         // steps above three medians
};
Tail measure_tail(OurRunner& runner) {
  constexpr int kSteps = 100000, kRepeats = 5;
  using Clock = std::chrono::steady_clock;
  std::vector<double> best(kSteps, 1e30);
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    if (!runner.body.set_state(runner.start.q, runner.start.p)) break;
    for (double& least : best) {
      const Clock::time_point before = Clock::now();
      runner.body.step();
      least = std::min(least, std::chrono::duration<double>(Clock::now() - before).count());
    }
  }
  Tail tail;
  std::vector<double> sorted = best;
  std::nth_element(sorted.begin(), sorted.begin() + kSteps / 2, sorted.end());
  tail.median = 1e6 * sorted[kSteps / 2];
  for (const double seconds : best) {
    tail.worst = std::max(tail.worst, 1e6 * seconds / tail.median);
    if (1e6 * seconds > 3.0 * tail.median) ++tail.slow;
  }
  return tail;
}

void ours(void* runner) {
  static_cast<OurRunner*>(runner)->window();
}
void textbook_newmark(void* runner) {
  static_cast<TextbookRunner*>(runner)->newmark();
}
void textbook_central(void* runner) {
  static_cast<TextbookRunner*>(runner)->central_differences();
}

Criterion at_most(const std::string& what, double value, double bound, std::string_view text) {
  return {what, fmt::format("<= {}", text), fmt::format("{:.3g}", value), value <= bound};
}

Status add_model(const std::string& name, const Options& options, SpeedSection& section) {
  const Result<Model::Pointer> model = Model::load(options.models_dir + "/" + name + ".tremolo");
  if (!model) return model.error();
  const auto r = static_cast<int>((*model)->modes());
  const Result<State> start = shaken_state(*model);
  if (!start) return start.error();
  const double small = 0.5 * (*model)->explicit_step_limit();
  TextbookRunner newmark{Textbook((*model)->potential()), *start, {}, kStep};
  newmark.textbook.force(start->q);
  newmark.acceleration = -newmark.textbook.force_value();
  TextbookRunner central{Textbook((*model)->potential()), *start, {}, small};
  const std::vector<std::pair<const char*, double>> methods = {
      {"newmark", kStep},        {"ep4", kStep},    {"imexv", kStep},
      {"imexv-adaptive", kStep}, {"verlet", small}, {"verlet4", small}};
  std::vector<OurRunner> runners;
  for (const auto& [method, step] : methods) {
    Result<OurRunner> runner = make_runner(*model, method, step, *start);
    if (!runner) return runner.error();
    runners.push_back(std::move(*runner));
  }
  std::vector<void (*)(void*)> functions = {textbook_newmark, textbook_central};
  std::vector<void*> arguments = {&newmark, &central};
  for (OurRunner& runner : runners) {
    functions.push_back(ours);
    arguments.push_back(&runner);
  }
  std::vector<double> seconds = time_by_turns(functions, arguments, 1, 40);
  for (double& s : seconds) s /= kWindow;
  const auto add = [&](const std::string& what, double value, double baseline,
                       const std::string& note) {
    SpeedRow row;
    row.what = fmt::format("{} step, {}, r = {}", what, name, r);
    row.value = 1e6 * value;
    row.baseline = 1e6 * baseline;
    row.note = note;
    section.rows.push_back(row);
    return row;
  };
  add("textbook: newmark", seconds[0], SpeedRow::kNone,
      fmt::format("{:.2f} evaluations", static_cast<double>(newmark.evaluations) / kWindow));
  add("textbook: central difference", seconds[1], SpeedRow::kNone, "");
  std::vector<SpeedRow> rows;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const bool implicit = methods[m].second == kStep;
    rows.push_back(add(methods[m].first, seconds[m + 2], implicit ? seconds[0] : seconds[1],
                       implicit ? fmt::format("{:.2f} corrections",
                                              static_cast<double>(runners[m].iterations) / kWindow)
                                : ""));
  }
  for (const std::size_t m : {std::size_t{0}, std::size_t{1}}) {
    const Tail tail = measure_tail(runners[m]);
    rows[m].what = fmt::format("{}, slowest of 100 000 steps over the median, {}, r = {}",
                               methods[m].first, name, r);
    section.criteria.push_back(at_most(rows[m].what, tail.worst, 3.0, "3"));
    add(fmt::format("{}: median of 100 000", methods[m].first), 1e-6 * tail.median, SpeedRow::kNone,
        fmt::format("slowest {:.2f} medians, {} steps above 3", tail.worst, tail.slow));
  }
  const auto ratio = [&](std::size_t m) { return rows[m].value / rows[m].baseline; };
  const std::string at = fmt::format(", {}, r = {}", name, r);
  if (r == 15)
    section.criteria.push_back(
        at_most("newmark step over the textbook's" + at, ratio(0), 0.2, "1/5"));
  if (r == 30) {
    section.criteria.push_back(
        at_most("newmark step over the textbook's" + at, ratio(0), 0.125, "1/8"));
    section.criteria.push_back(
        at_most("verlet step over the textbook's central difference" + at, ratio(4), 0.25, "1/4"));
    section.criteria.push_back(at_most("ep4 step, us" + at, rows[1].value, 20.0, "20"));
  }
  section.criteria.push_back(
      at_most("ep4 step over our newmark step" + at, rows[1].value / rows[0].value, 1.3, "1.3"));
  return Success{};
}

}  // namespace

Result<SpeedSection> measure_step_speed(const Options& options, const MachineProbe&) {
  SpeedSection section;
  section.title = "The step";
  section.text = fmt::format(
      "One body, h = {} ms (explicit methods: half their limit), free motion after a push of the "
      "model's default load, tolerance {:g}; the mean of {} steps, the smallest of 40 windows. The "
      "textbook's Newmark method is full Newton on its tables with a Cholesky factor each time.",
      1e3 * kStep, kTolerance, kWindow);
  for (const char* name : {"horse", "basket", "heart"})
    if (Status status = add_model(name, options, section); !status) return status.error();
  return section;
}

}  // namespace tremolo::bench
