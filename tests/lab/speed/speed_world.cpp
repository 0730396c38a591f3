// Many bodies: a world's step, sleep, levels of detail, surfaces.
#include "tests/lab/speed/speed_world.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/world.h"

namespace tremolo::bench {
namespace {

constexpr std::size_t kSleeping = 10000;
constexpr std::size_t kRowsOfAModel = 6;  // of measure_lane_force and measure_steps

// Smallest wall-clock time of each, s, by turns: what several threads are for. Two seconds long, so
// that some moment has both cores free.
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
  options.options = {.step = 1e-3, .alpha = 0.5, .beta = 1e-6};
  options.modes = modes;
  options.precision = precision;
  options.sleep.time = std::numeric_limits<double>::infinity();
  return options;
}

// A world with `awake` bodies that move and `asleep` that do not.
Result<World> make_world(const Model::Pointer& model, const GroupOptions& options, unsigned threads,
                         std::size_t awake, std::size_t asleep = 0) {
  Result<World> world = World::create(threads);
  if (!world) return world;
  const Result<GroupId> group = world->add_group(model, options);
  if (!group) return group.error();
  const Eigen::Index modes = options.modes == 0 ? model->modes() : options.modes;
  const std::vector<Eigen::VectorXd> states = random_states(*model, awake);
  for (std::size_t b = 0; b < awake + asleep; ++b) {
    const Result<BodyId> body = world->add_body(*group);
    if (!body) return body.error();
    if (b >= awake) continue;
    const Eigen::VectorXd q = states[b].head(modes);
    if (Status s = world->set_state(*body, q, Eigen::VectorXd::Zero(modes)); !s) return s.error();
  }
  return world;
}

// The largest difference of q between f32 and f64 lanes after 1000 steps (1 s), relative to the
// body's largest q then; and the same of the energies, relative to the energy.
Result<std::string> float_orbit_error(const Model::Pointer& model) {
  constexpr std::size_t kWatched = 64;
  Result<World> f32 = make_world(model, lane_options(LanePrecision::kFloat), 1, kWatched);
  if (!f32) return f32.error();
  Result<World> f64 = make_world(model, lane_options(LanePrecision::kDouble), 1, kWatched);
  if (!f64) return f64.error();
  for (int step = 0; step < 1000; ++step) {
    f32->step();
    f64->step();
  }
  double q = 0.0, energy = 0.0;
  for (BodyId body = 0; body < kWatched; ++body) {
    const Eigen::VectorXd reference = f64->state(body)->q;
    q = std::max(q, (f32->state(body)->q - reference).norm() / reference.norm());
    const double total = f64->energy(body)->total();
    energy = std::max(energy, std::abs(f32->energy(body)->total() - total) / total);
  }
  return fmt::format("after 1 s q differs from f64 lanes by <= {:.1e}, the energy by <= {:.1e}", q,
                     energy);
}

SpeedRow row_of(std::string what, double microseconds, double baseline, std::string note) {
  SpeedRow row;
  row.what = std::move(what);
  row.value = microseconds;
  row.baseline = baseline;
  row.note = std::move(note);
  return row;
}

// us a body and step: f32, f64, and separate bodies; one thread and two.
Status measure_steps(const Model::Pointer& model, SpeedSection& section) {
  const GroupOptions f32 = lane_options(LanePrecision::kFloat);
  const GroupOptions f64 = lane_options(LanePrecision::kDouble);
  std::vector<World> worlds;
  for (const unsigned threads : {1u, 2u})
    for (const GroupOptions& options : {f32, f64}) {
      Result<World> world = make_world(model, options, threads, kBodies);
      if (!world) return world.error();
      worlds.push_back(std::move(*world));
    }
  std::vector<Body> bodies;
  for (const Eigen::VectorXd& q : random_states(*model, kBodies)) {
    Result<Body> body = Body::create(model, f64.integrator, f64.options);
    if (!body) return body.error();
    if (Status s = body->set_state(q, Eigen::VectorXd::Zero(q.size())); !s) return s;
    bodies.push_back(std::move(*body));
  }
  std::size_t failed = 0;
  const auto step = [&](std::size_t w) {
    return Work([&worlds, &failed, w] { failed += worlds[w].step().failed.size(); });
  };
  const Work each = [&] {
    for (Body& body : bodies)
      if (!body.step().converged) ++failed;
  };
  const std::vector<double> one = by_turns({step(0), step(1), each}, 1, 40);
  const std::vector<double> wall = wall_by_turns({step(0), step(1), step(2), step(3)});
  if (failed > 0) return Error{ErrorKind::kSolver, "a body of the speed test left the numbers"};
  const auto r = model->modes();
  const double body = 1e6 * one[2] / kBodies;
  const Result<std::string> error = float_orbit_error(model);
  if (!error) return error.error();
  const char* names[] = {"f32", "f64"};
  for (std::size_t w = 0; w < 2; ++w)
    section.rows.push_back(row_of(fmt::format("step of one of {} bodies, {}, r = {}, {} lanes",
                                              kBodies, f64.integrator, r, names[w]),
                                  1e6 * one[w] / kBodies, body,
                                  "against 1000 separate bodies" + (w == 0 ? "; " + *error : "")));
  for (std::size_t w = 0; w < 2; ++w)
    section.rows.push_back(row_of(
        fmt::format("the same on two threads, {}, r = {}, {} lanes", f64.integrator, r, names[w]),
        1e6 * wall[2 + w] / kBodies, 1e6 * wall[w] / kBodies, "wall clock, against one thread"));
  return Success{};
}

// A crowd of the default method, with nothing else than its defaults but sleep.
Status measure_default_step(const Model::Pointer& model, SpeedSection& section) {
  GroupOptions options;
  options.sleep.time = std::numeric_limits<double>::infinity();
  std::vector<World> worlds;
  for (const unsigned threads : {1u, 2u}) {
    Result<World> world = make_world(model, options, threads, kBodies);
    if (!world) return world.error();
    worlds.push_back(std::move(*world));
  }
  std::size_t failed = 0;
  const auto step = [&](std::size_t w) {
    return Work([&worlds, &failed, w] { failed += worlds[w].step().failed.size(); });
  };
  const std::vector<double> one = by_turns({step(0)}, 1, 40);
  const std::vector<double> wall = wall_by_turns({step(0), step(1)});
  if (failed > 0) return Error{ErrorKind::kSolver, "a body of the speed test failed"};
  section.rows.push_back(row_of(fmt::format("step of one of {} bodies, {}, r = {}", kBodies,
                                            options.integrator, model->modes()),
                                1e6 * one[0] / kBodies, SpeedRow::kNone,
                                "the default: each by itself, h = 3 ms"));
  section.rows.push_back(
      row_of(fmt::format("the same on two threads, {}, r = {}", options.integrator, model->modes()),
             1e6 * wall[1] / kBodies, 1e6 * wall[0] / kBodies, "wall clock, against one thread"));
  return Success{};
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

Status measure_sleep(const Model::Pointer& model, SpeedSection& section) {
  const GroupOptions f32 = lane_options(LanePrecision::kFloat);
  std::vector<World> worlds;
  for (const auto& [awake, asleep] :
       {std::pair{kBodies, std::size_t{0}}, {kBodies, kSleeping}, {std::size_t{0}, kSleeping}}) {
    Result<World> world = make_world(model, f32, 1, awake, asleep);
    if (!world) return world.error();
    worlds.push_back(std::move(*world));
  }
  const std::vector<double> busy =
      by_turns({[&] { worlds[0].step(); }, [&] { worlds[1].step(); }}, 1, 60);
  const std::vector<double> idle = by_turns({[&] { worlds[2].step(); }}, 1000, 20);
  section.rows.push_back(row_of(fmt::format("step of {} bodies beside {} that sleep, {}, r = {}",
                                            kBodies, kSleeping, f32.integrator, model->modes()),
                                1e6 * busy[1], 1e6 * busy[0],
                                "against the same world without the sleeping ones"));
  section.rows.push_back(row_of(fmt::format("step of {} bodies that sleep", kSleeping),
                                1e6 * idle[0], SpeedRow::kNone, "the whole world"));
  Criterion criterion;
  criterion.what = fmt::format("{} sleeping bodies beside {} that move", kSleeping, kBodies);
  criterion.bound = "<= 1.02 times the step without them, and <= 1 us alone";
  criterion.measured = fmt::format("{:.3f} times, {:.3g} us", busy[1] / busy[0], 1e6 * idle[0]);
  criterion.met = busy[1] <= 1.02 * busy[0] && idle[0] <= 1e-6;
  section.criteria.push_back(criterion);
  return Success{};
}

Status measure_detail(const Model::Pointer& model, SpeedSection& section) {
  std::vector<World> worlds;
  for (const int modes : {15, 0}) {
    Result<World> world = make_world(model, lane_options(LanePrecision::kFloat, modes), 1, kBodies);
    if (!world) return world.error();
    worlds.push_back(std::move(*world));
  }
  const std::vector<double> seconds =
      by_turns({[&] { worlds[0].step(); }, [&] { worlds[1].step(); }}, 1, 60);
  section.rows.push_back(row_of(
      fmt::format("step of one of {} bodies, the first 15 of {} modes", kBodies, model->modes()),
      1e6 * seconds[0] / kBodies, 1e6 * seconds[1] / kBodies,
      "imexv-linear, f32 lanes, against all modes"));
  return Success{};
}

Status measure_surfaces(const Model::Pointer& model, const MachineProbe& probe,
                        SpeedSection& section) {
  constexpr std::size_t kShown = 100;
  Result<World> made = make_world(model, lane_options(LanePrecision::kFloat), 1, kShown);
  if (!made) return made.error();
  World& world = *made;
  std::vector<Body> bodies;
  std::vector<float> positions(3 * model->drawn().rest.size());
  for (const Eigen::VectorXd& q : random_states(*model, kShown)) {
    Result<Body> body = Body::create(model, "imexv-linear", {});
    if (!body) return body.error();
    if (Status s = body->set_state(q, q); !s) return s;
    bodies.push_back(std::move(*body));
  }
  const auto show = [&](bool shown) {
    for (BodyId body = 0; body < kShown; ++body) (void)world.set_shown(body, shown);
  };
  show(true);
  const std::vector<double> step_and_build =
      by_turns({[&] {
                  world.step();
                  world.update_surfaces();
                },
                [&] { world.step(); },
                [&] {
                  for (const Body& body : bodies)
                    (void)body.surface_positions(std::span<float>(positions));
                }},
               1, 60);
  world.update_surfaces();
  const std::vector<double> still = by_turns({[&] { world.update_surfaces(); }}, 1000, 20);
  show(false);
  world.step();
  const std::vector<double> hidden = by_turns({[&] { world.update_surfaces(); }}, 1000, 20);
  const auto size = static_cast<double>(positions.size());
  const auto r = static_cast<double>(model->modes());
  SpeedRow moved = row_of(fmt::format("surface of {} vertices, shown and moved, r = {}",
                                      model->drawn().rest.size(), model->modes()),
                          1e6 * std::max(0.0, step_and_build[0] - step_and_build[1]) / kShown,
                          1e6 * step_and_build[2] / kShown,
                          "a body; step and rebuild less step; against Body's");
  moved.operations = 2.0 * r * size;
  moved.bytes = 4.0 * (r + 1.0) * size / 4.0 + 4.0 * size;
  moved.limit =
      1e-3 * std::max(moved.operations / probe.gflops_f32, moved.bytes / probe.l3_bandwidth);
  moved.limited_by = moved.operations / probe.gflops_f32 > moved.bytes / probe.l3_bandwidth
                         ? "FMA peak"
                         : "L3 bandwidth";
  section.rows.push_back(moved);
  section.rows.push_back(row_of("the same, shown but not moved", 1e6 * still[0] / kShown,
                                moved.value, "against moved"));
  section.rows.push_back(row_of("the same, moved but not shown", 1e6 * hidden[0] / kShown,
                                moved.value, "against moved"));
  return Success{};
}

}  // namespace

Result<SpeedSection> measure_world_speed(const Options& options, const MachineProbe& probe) {
  SpeedSection section;
  section.title = "Many bodies";
  section.text =
      "Bodies of verlet and imexv-linear step a body a lane: 16 in float or 8 in double share each "
      "load of a coefficient. Those of other methods, ep4 among them, step each by itself. "
      "grad(C + Q) alone is in the lanes' precision; the state, the linear force and all sums are "
      "in double. The column `textbook` holds here the same work done body by body, or what the "
      "note says.";
  Model::Pointer largest;
  for (const char* name : {"horse", "basket", "heart"}) {
    Result<Model::Pointer> model =
        Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name));
    if (!model) return model.error();
    measure_lane_force(**model, probe, section);
    if (Status s = measure_steps(*model, section); !s) return s.error();
    if (!largest || largest->modes() < (*model)->modes()) largest = *model;
    if ((*model)->modes() == 30)
      section.criteria.push_back(
          force_criterion(section.rows[section.rows.size() - kRowsOfAModel], probe));
    if (Status s = measure_default_step(*model, section); !s) return s.error();
  }
  measure_narrower_lanes(*largest, section);
  if (Status s = measure_sleep(largest, section); !s) return s.error();
  if (Status s = measure_detail(largest, section); !s) return s.error();
  if (Status s = measure_surfaces(largest, probe, section); !s) return s.error();
  return section;
}

}  // namespace tremolo::bench
