// Many bodies: a crowd's step, sleep, levels of detail, surfaces.
#include "tests/lab/speed/speed_world.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/crowd.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

constexpr std::size_t kSleeping = 10000;

// Smallest wall-clock time of each, s, alternately: the purpose of several threads. Two seconds
// long, so that both cores are free at some time.
std::vector<double> wall_by_turns(const std::vector<Work>& works) {
  std::vector<double> best(works.size(), std::numeric_limits<double>::infinity());
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  while (std::chrono::steady_clock::now() < end)
    for (std::size_t w = 0; w < works.size(); ++w) {
      const auto before = std::chrono::steady_clock::now();
      works[w]();
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
      best[w] = std::min(best[w], took.count());
    }
  return best;
}

GroupOptions lane_options(LanePrecision precision, int modes = 0) {
  GroupOptions options;
  options.integrator = "imexv-linear";
  options.options = {.step = 1e-3, .alpha = 0.5};
  options.modes = modes;
  options.precision = precision;
  options.sleep.time = std::numeric_limits<double>::infinity();
  return options;
}

// A crowd with `awake` bodies that move and `asleep` that do not.
Crowd make_world(const Model::Pointer& model, const GroupOptions& options, unsigned threads,
                 std::size_t awake, std::size_t asleep = 0) {
  Crowd crowd = or_fail(Crowd::create(threads));
  const GroupId group = or_fail(crowd.add_group(model, options));
  const Eigen::Index modes = options.modes == 0 ? model->modes() : options.modes;
  const std::vector<Eigen::VectorXd> states = random_states(*model, awake);
  for (std::size_t b = 0; b < awake + asleep; ++b) {
    const BodyId body = or_fail(crowd.add_body(group));
    if (b < awake)
      or_fail(crowd.set_state(body, states[b].head(modes), Eigen::VectorXd::Zero(modes)));
  }
  return crowd;
}

// The largest difference of q between f32 and f64 lanes after 1000 steps (1 s), relative to the
// body's largest q then; and the same of the energies, relative to the energy.
std::string float_orbit_error(const Model::Pointer& model) {
  constexpr std::size_t kWatched = 64;
  Crowd f32 = make_world(model, lane_options(LanePrecision::kFloat), 1, kWatched);
  Crowd f64 = make_world(model, lane_options(LanePrecision::kDouble), 1, kWatched);
  for (int step = 0; step < 1000; ++step) {
    f32.step();
    f64.step();
  }
  double q = 0.0, energy = 0.0;
  for (BodyId body = 0; body < kWatched; ++body) {
    const Eigen::VectorXd reference = f64.state(body)->q;
    q = std::max(q, (f32.state(body)->q - reference).norm() / reference.norm());
    const double total = f64.energy(body)->total();
    energy = std::max(energy, std::abs(f32.energy(body)->total() - total) / total);
  }
  return fmt::format("after 1 s q differs from f64 lanes by <= {:.1e}, the energy by <= {:.1e}", q,
                     energy);
}

// Separate bodies in the given states.
std::vector<Body> make_bodies(const Model::Pointer& model, std::size_t count,
                              const IntegratorOptions& options) {
  std::vector<Body> bodies;
  for (const Eigen::VectorXd& q : random_states(*model, count)) {
    bodies.push_back(or_fail(Body::create(model, "imexv-linear", options)));
    or_fail(bodies.back().set_state(q, Eigen::VectorXd::Zero(q.size())));
  }
  return bodies;
}

// A step of crowds[w]; counts the bodies that failed.
Work step_of(std::vector<Crowd>& crowds, std::size_t w, std::size_t& failed) {
  return [&crowds, &failed, w] { failed += crowds[w].step().failed.size(); };
}

void expect_no_failure(std::size_t failed) {
  if (failed > 0) throw Failure({ErrorKind::kSolver, "a step of the speed test failed"});
}

// us a body and step: f32, f64, and separate bodies; one thread and two.
void measure_steps(const Model::Pointer& model, SpeedSection& section) {
  const GroupOptions f32 = lane_options(LanePrecision::kFloat);
  const GroupOptions f64 = lane_options(LanePrecision::kDouble);
  std::vector<Crowd> crowds;
  for (const unsigned threads : {1u, 2u})
    for (const GroupOptions& options : {f32, f64})
      crowds.push_back(make_world(model, options, threads, kBodies));
  std::vector<Body> bodies = make_bodies(model, kBodies, f64.options);
  std::size_t failed = 0;
  const Work each = [&] {
    for (Body& body : bodies)
      if (!body.step().converged) ++failed;
  };
  const auto step = [&](std::size_t w) { return step_of(crowds, w, failed); };
  const std::vector<double> one = by_turns({step(0), step(1), each}, 1, 40);
  const std::vector<double> wall = wall_by_turns({step(0), step(1), step(2), step(3)});
  expect_no_failure(failed);
  const auto r = model->modes();
  const std::string error = "; " + float_orbit_error(model);
  const char* names[] = {"f32", "f64"};
  for (std::size_t w = 0; w < 2; ++w)
    section.rows.push_back(
        microseconds(fmt::format("step of one of {} bodies, {}, r = {}, {} lanes", kBodies,
                                 f64.integrator, r, names[w]),
                     one[w] / kBodies, one[2] / kBodies,
                     "against 1000 separate bodies" + (w == 0 ? error : "")));
  for (std::size_t w = 0; w < 2; ++w)
    section.rows.push_back(microseconds(
        fmt::format("the same on two threads, {}, r = {}, {} lanes", f64.integrator, r, names[w]),
        wall[2 + w] / kBodies, wall[w] / kBodies, "wall clock, against one thread"));
}

// A crowd of the default method, with nothing else than its defaults but sleep.
void measure_default_step(const Model::Pointer& model, SpeedSection& section) {
  GroupOptions options;
  options.sleep.time = std::numeric_limits<double>::infinity();
  std::vector<Crowd> crowds;
  for (const unsigned threads : {1u, 2u})
    crowds.push_back(make_world(model, options, threads, kBodies));
  std::size_t failed = 0;
  const std::vector<double> one = by_turns({step_of(crowds, 0, failed)}, 1, 40);
  const std::vector<double> wall =
      wall_by_turns({step_of(crowds, 0, failed), step_of(crowds, 1, failed)});
  expect_no_failure(failed);
  section.rows.push_back(microseconds(fmt::format("step of one of {} bodies, {}, r = {}", kBodies,
                                                  options.integrator, model->modes()),
                                      one[0] / kBodies, SpeedRow::kNone,
                                      "the default, double lanes, h = 3 ms"));
  section.rows.push_back(microseconds(
      fmt::format("the same on two threads, {}, r = {}", options.integrator, model->modes()),
      wall[1] / kBodies, wall[0] / kBodies, "wall clock, against one thread"));
}

Criterion force_criterion(const SpeedRow& force, const MachineProbe& probe) {
  Criterion criterion;
  criterion.what = "1000 bodies at r = 30 sharing a model: a body and force evaluation in lanes";
  criterion.bound = "<= 3 us with AVX-512";
  criterion.measured = fmt::format("{:.2f} us, {}; {}", force.value, probe.vectors, force.note);
  criterion.met = force.value <= 3.0;
  criterion.decides = probe.vectors == "AVX-512";
  return criterion;
}

void measure_sleep(const Model::Pointer& model, SpeedSection& section) {
  const GroupOptions f32 = lane_options(LanePrecision::kFloat);
  Crowd alone = make_world(model, f32, 1, kBodies);
  Crowd beside = make_world(model, f32, 1, kBodies, kSleeping);
  Crowd asleep = make_world(model, f32, 1, 0, kSleeping);
  const std::vector<double> busy = by_turns({[&] { alone.step(); }, [&] { beside.step(); }}, 1, 60);
  const std::vector<double> idle = by_turns({[&] { asleep.step(); }}, 1000, 20);
  section.rows.push_back(
      microseconds(fmt::format("step of {} bodies beside {} that sleep, {}, r = {}", kBodies,
                               kSleeping, f32.integrator, model->modes()),
                   busy[1], busy[0], "against the same crowd without the sleeping ones"));
  section.rows.push_back(microseconds(fmt::format("step of {} bodies that sleep", kSleeping),
                                      idle[0], SpeedRow::kNone, "the whole crowd"));
  section.criteria.push_back(
      {fmt::format("{} sleeping bodies beside {} that move", kSleeping, kBodies),
       "<= 1.02 times the step without them, and <= 1 us alone",
       fmt::format("{:.3f} times, {:.3g} us", busy[1] / busy[0], 1e6 * idle[0]),
       busy[1] <= 1.02 * busy[0] && idle[0] <= 1e-6});
}

void measure_detail(const Model::Pointer& model, SpeedSection& section) {
  Crowd first = make_world(model, lane_options(LanePrecision::kFloat, 15), 1, kBodies);
  Crowd all = make_world(model, lane_options(LanePrecision::kFloat), 1, kBodies);
  const std::vector<double> seconds = by_turns({[&] { first.step(); }, [&] { all.step(); }}, 1, 60);
  section.rows.push_back(microseconds(
      fmt::format("step of one of {} bodies, the first 15 of {} modes", kBodies, model->modes()),
      seconds[0] / kBodies, seconds[1] / kBodies, "imexv-linear, f32 lanes, against all modes"));
}

// The row of a moving surface, with the limits of memory and arithmetic.
SpeedRow moved_surface(const Model& model, double seconds, double baseline,
                       const MachineProbe& probe) {
  const auto size = static_cast<double>(3 * model.drawn().rest.size());
  const auto r = static_cast<double>(model.modes());
  SpeedRow row =
      microseconds(fmt::format("surface of {} vertices, shown and moved, r = {}",
                               model.drawn().rest.size(), model.modes()),
                   seconds, baseline, "a body; step and rebuild less step; against Body's");
  row.operations = 2.0 * r * size;
  row.bytes = 4.0 * (r + 1.0) * size / 4.0 + 4.0 * size;
  const double arithmetic = row.operations / probe.gflops_f32;
  const double memory = row.bytes / probe.l3_bandwidth;
  row.limit = 1e-3 * std::max(arithmetic, memory);
  row.limited_by = arithmetic > memory ? "FMA peak" : "L3 bandwidth";
  return row;
}

void measure_surfaces(const Model::Pointer& model, const MachineProbe& probe,
                      SpeedSection& section) {
  constexpr std::size_t kShown = 100;
  Crowd crowd = make_world(model, lane_options(LanePrecision::kFloat), 1, kShown);
  const std::vector<Body> bodies = make_bodies(model, kShown, {});
  std::vector<float> positions(3 * model->drawn().rest.size());
  const auto show = [&](bool shown) {
    for (BodyId body = 0; body < kShown; ++body) or_fail(crowd.set_shown(body, shown));
  };
  show(true);
  const std::vector<double> step_and_build =
      by_turns({[&] {
                  crowd.step();
                  crowd.update_surfaces();
                },
                [&] { crowd.step(); },
                [&] {
                  for (const Body& body : bodies) (void)body.surface(std::span<float>(positions));
                }},
               1, 60);
  crowd.update_surfaces();
  const Work update = [&] { crowd.update_surfaces(); };
  const std::vector<double> still = by_turns({update}, 1000, 20);
  show(false);
  crowd.step();
  const std::vector<double> hidden = by_turns({update}, 1000, 20);
  const double moved = std::max(0.0, step_and_build[0] - step_and_build[1]) / kShown;
  section.rows.push_back(moved_surface(*model, moved, step_and_build[2] / kShown, probe));
  section.rows.push_back(
      microseconds("the same, shown but not moved", still[0] / kShown, moved, "against moved"));
  section.rows.push_back(
      microseconds("the same, moved but not shown", hidden[0] / kShown, moved, "against moved"));
}

}  // namespace

SpeedSection measure_world_speed(const Options& options, const MachineProbe& probe) {
  SpeedSection section;
  section.title = "Many bodies";
  section.text =
      "Bodies of ep4, ep2, avf, verlet and imexv-linear step a body a lane: 16 in float or 8 in "
      "double share each load of a coefficient. Those of other methods step each by itself. grad(C "
      "+ Q) alone is in the lanes' precision; the state, the linear force and all sums are in "
      "double. The column `textbook` holds here the same work done body by body, or what the note "
      "says.";
  Model::Pointer largest;
  for (const char* name : {"horse", "basket", "heart"}) {
    const Model::Pointer model =
        or_fail(Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name)));
    const std::size_t force = section.rows.size();
    measure_lane_force(*model, probe, section);
    measure_steps(model, section);
    if (!largest || largest->modes() < model->modes()) largest = model;
    if (model->modes() == 30)
      section.criteria.push_back(force_criterion(section.rows[force], probe));
    measure_default_step(model, section);
  }
  measure_narrower_lanes(*largest, section);
  measure_sleep(largest, section);
  measure_detail(largest, section);
  measure_surfaces(largest, probe, section);
  return section;
}

}  // namespace tremolo::bench
