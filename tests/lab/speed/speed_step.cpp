// Complete steps compared with the textbook's Newmark method and central differences.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "runtime/body.h"
#include "tests/lab/speed/speed.h"
#include "tests/lab/speed/textbook.h"
#include "tests/lab/work/failure.h"

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
    const std::int64_t before = body.counts().iterations;
    for (int k = 0; k < kWindow; ++k) body.step();
    iterations = body.counts().iterations - before;
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

// A push of 0.3 s that moves the loaded vertex by some 5 % of the size, as the default load does.
State shaken_state(const Model::Pointer& model) {
  Body body = or_fail(Body::create(model, "ep4", {.step = kStep}));
  or_fail(body.add_default_load(Signal{.kind = SignalKind::kSquare, .duration = 0.3}));
  while (body.time() < 0.35)
    if (!body.step().converged) throw Failure({ErrorKind::kSolver, "a step did not converge"});
  return body.state();
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

// Half of the explicit methods' stability limit, s.
double explicit_step(const Model& model) {
  return 0.5 * model.explicit_step_limit();
}

// Our methods, and which of the textbook's each is compared with.
struct Method {
  const char* name;
  bool implicit;
};
constexpr Method kMethods[] = {{"newmark", true},        {"ep4", true},     {"imexv", true},
                               {"imexv-adaptive", true}, {"verlet", false}, {"verlet4", false}};
constexpr std::size_t kNewmark = 0, kEp4 = 1, kVerlet = 4;  // in kMethods

// One model and its measurements. rows: one per method, in their order.
struct StepTest {
  std::string suffix;  // ", heart, r = 30"
  Eigen::Index modes = 0;
  std::vector<SpeedRow> rows;
};

SpeedRow& add_row(SpeedSection& section, const std::string& what, const StepTest& test,
                  double seconds, double baseline, std::string note) {
  section.rows.push_back(
      microseconds(what + " step" + test.suffix, seconds, baseline, std::move(note)));
  return section.rows.back();
}

// Times all methods alternately and adds their rows. runners: one per method.
void time_steps(const Model::Pointer& model, const State& start, std::vector<OurRunner>& runners,
                StepTest& test, SpeedSection& section) {
  TextbookRunner newmark{Textbook(model->potential()), start, {}, kStep};
  newmark.textbook.force(start.q);
  newmark.acceleration = -newmark.textbook.force_value();
  TextbookRunner central{Textbook(model->potential()), start, {}, explicit_step(*model)};
  std::vector<Work> works = {[&] { newmark.newmark(); }, [&] { central.central_differences(); }};
  for (OurRunner& runner : runners) works.push_back([&] { runner.window(); });
  std::vector<double> seconds = by_turns(works, 1, 40);
  for (double& s : seconds) s /= kWindow;
  const auto a_step = [](std::int64_t count) { return static_cast<double>(count) / kWindow; };
  add_row(section, "textbook: newmark", test, seconds[0], SpeedRow::kNone,
          fmt::format("{:.2f} evaluations", a_step(newmark.evaluations)));
  add_row(section, "textbook: central difference", test, seconds[1], SpeedRow::kNone, "");
  for (std::size_t m = 0; m < runners.size(); ++m) {
    const bool implicit = kMethods[m].implicit;
    test.rows.push_back(
        add_row(section, kMethods[m].name, test, seconds[m + 2], seconds[implicit ? 0 : 1],
                implicit ? fmt::format("{:.2f} corrections", a_step(runners[m].iterations)) : ""));
  }
}

// The slowest of many steps of Newmark's method and of ep4.
void add_tails(std::vector<OurRunner>& runners, const StepTest& test, SpeedSection& section) {
  for (const std::size_t m : {kNewmark, kEp4}) {
    const Tail tail = measure_tail(runners[m]);
    section.criteria.push_back(at_most(fmt::format("{}, slowest of 100 000 steps over the median{}",
                                                   kMethods[m].name, test.suffix),
                                       tail.worst, 3.0));
    add_row(section, fmt::format("{}: median of 100 000", kMethods[m].name), test,
            1e-6 * tail.median, SpeedRow::kNone,
            fmt::format("slowest {:.2f} medians, {} steps above 3", tail.worst, tail.slow));
  }
}

void judge(const StepTest& test, SpeedSection& section) {
  const auto add = [&](const char* what, double measured, double bound, const char* text) {
    section.criteria.push_back(at_most(what + test.suffix, measured, bound, {}, text));
  };
  const SpeedRow &newmark = test.rows[kNewmark], &ep4 = test.rows[kEp4];
  if (test.modes == 15) add("newmark step over the textbook's", newmark.ratio(), 0.2, "1/5");
  if (test.modes == 30) {
    add("newmark step over the textbook's", newmark.ratio(), 0.125, "1/8");
    add("verlet step over the textbook's central difference", test.rows[kVerlet].ratio(), 0.25,
        "1/4");
    add("ep4 step, us", ep4.value, 20.0, "20");
  }
  add("ep4 step over our newmark step", ep4.value / newmark.value, 1.3, "1.3");
}

void add_model(const std::string& name, const Options& options, SpeedSection& section) {
  const Model::Pointer model =
      or_fail(Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name)));
  StepTest test{fmt::format(", {}, r = {}", name, model->modes()), model->modes(), {}};
  const State start = shaken_state(model);
  std::vector<OurRunner> runners;
  for (const Method& method : kMethods) {
    const double step = method.implicit ? kStep : explicit_step(*model);
    runners.push_back(
        {or_fail(Body::create(model, method.name, {.step = step, .tolerance = kTolerance})),
         start});
  }
  time_steps(model, start, runners, test, section);
  add_tails(runners, test, section);
  judge(test, section);
}

}  // namespace

SpeedSection measure_step_speed(const Options& options, const MachineProbe&) {
  SpeedSection section;
  section.title = "The step";
  section.text = fmt::format(
      "One body, h = {} ms (explicit methods: half their limit), free motion after a push of the "
      "model's default load, tolerance {:g}; the mean of {} steps, the smallest of 40 windows. The "
      "textbook's Newmark method is full Newton on its tables with a Cholesky factor each time.",
      1e3 * kStep, kTolerance, kWindow);
  for (const char* name : {"horse", "basket", "heart"}) add_model(name, options, section);
  return section;
}

}  // namespace tremolo::bench
