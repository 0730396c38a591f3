// Many bodies: force in lanes, a world's step, sleep, levels of detail, surfaces.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <fmt/format.h>

#include "common/packed_index.h"
#include "runtime/lane_force.h"
#include "runtime/program/bench/speed.h"
#include "runtime/world.h"

namespace tremolo::bench {
namespace {

constexpr std::size_t kBodies = 1000;
constexpr std::size_t kSleeping = 10000;

using Work = std::function<void()>;

// Smallest processor time of each, s.
std::vector<double> by_turns(std::vector<Work> works, int calls, int windows) {
  std::vector<void (*)(void*)> functions(works.size(),
                                         [](void* work) { (*static_cast<Work*>(work))(); });
  std::vector<void*> arguments;
  for (Work& work : works) arguments.push_back(&work);
  return time_by_turns(functions, arguments, calls, windows);
}

// Smallest wall-clock time of each, s, by turns: what several threads are for.
std::vector<double> wall_by_turns(const std::vector<Work>& works, int windows) {
  std::vector<double> best(works.size(), std::numeric_limits<double>::infinity());
  for (int window = 0; window < windows; ++window)
    for (std::size_t w = 0; w < works.size(); ++w) {
      const auto before = std::chrono::steady_clock::now();
      works[w]();
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
      best[w] = std::min(best[w], took.count());
    }
  return best;
}

// States like those of a scene: the first mode moves its vertex by up to a twentieth of the size,
// the others have at most its energy.
Eigen::VectorXd random_state(const Model& model, std::mt19937& random) {
  Eigen::Vector3d least = model.surface().rest[0], most = least;
  for (const Eigen::Vector3d& rest : model.surface().rest) {
    least = least.cwiseMin(rest);
    most = most.cwiseMax(rest);
  }
  double moved = 0.0;
  for (Eigen::Index row = 0; row + 2 < model.surface().rows.rows(); row += 3)
    moved = std::max(moved, model.surface().rows.block(row, 0, 3, 1).norm());
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  Eigen::VectorXd q(model.modes());
  for (Eigen::Index i = 0; i < q.size(); ++i)
    q[i] = uniform(random) * (most - least).maxCoeff() / moved *
           std::sqrt(model.lambda()[0] / model.lambda()[i]);
  return q;
}

std::vector<Eigen::VectorXd> random_states(const Model& model, std::size_t count) {
  std::mt19937 random(1);
  std::vector<Eigen::VectorXd> states;
  for (std::size_t b = 0; b < count; ++b) states.push_back(random_state(model, random));
  return states;
}

template <class Real>
struct alignas(64) Row {
  Real value[kLanes<Real>];
};

// Blocks of lanes that hold the states.
template <class Real>
struct LaneField {
  LaneCoefficients<Real> coefficients;
  std::vector<Row<Real>> x, gradient;

  LaneField(const Model& model, const std::vector<Eigen::VectorXd>& states)
      : coefficients(make_lane_coefficients<Real>(static_cast<std::size_t>(model.modes()),
                                                  model.cubic(), model.quartic())) {
    const std::size_t r = coefficients.modes;
    x.resize((states.size() + kLanes<Real> - 1) / kLanes<Real> * r);
    gradient.resize(x.size());
    for (std::size_t b = 0; b < states.size(); ++b)
      for (std::size_t i = 0; i < r; ++i)
        x[b / kLanes<Real> * r + i].value[b % kLanes<Real>] = static_cast<Real>(
            states[b][static_cast<Eigen::Index>(i)] / coefficients.coordinate_scale);
  }
  void evaluate(LaneVectors vectors = widest_lane_vectors()) {
    for (std::size_t at = 0; at < x.size(); at += coefficients.modes)
      evaluate_lanes(coefficients, x[at].value, gradient[at].value, nullptr, vectors);
  }
  // grad V of a body; lambda q added in double, as a World does.
  Eigen::VectorXd force(const Model& model, const Eigen::VectorXd& q, std::size_t body) const {
    Eigen::VectorXd force = model.lambda().cwiseProduct(q);
    for (Eigen::Index i = 0; i < force.size(); ++i)
      force[i] +=
          coefficients.energy_scale / coefficients.coordinate_scale *
          static_cast<double>(
              gradient[body / kLanes<Real> * coefficients.modes + static_cast<std::size_t>(i)]
                  .value[body % kLanes<Real>]);
    return force;
  }
};

// Two multiply-adds a quartic coefficient; a triple costs a product, three multiply-adds less the
// one that an addition is.
double operations_of_force(std::size_t r) {
  return 4.0 * static_cast<double>(quad_count(r)) + 6.0 * static_cast<double>(triple_count(r));
}

template <class Real>
SpeedRow force_row(const Model& model, double seconds, double baseline, double gflops,
                   double error) {
  const auto r = static_cast<std::size_t>(model.modes());
  SpeedRow row;
  row.what = fmt::format("force of one of {} bodies, r = {}, {} lanes", kBodies, r,
                         sizeof(Real) == 4 ? "f32" : "f64");
  row.value = 1e6 * seconds / kBodies;
  row.baseline = 1e6 * baseline / kBodies;
  row.operations = operations_of_force(r);
  row.bytes = static_cast<double>((quad_count(r) + triple_count(r)) * sizeof(Real)) /
                  static_cast<double>(kLanes<Real>) +
              2.0 * static_cast<double>(r * sizeof(Real));
  row.limit = 1e-3 * row.operations / gflops;
  row.limited_by = "FMA peak";
  row.note = fmt::format(
      "against Potential::evaluate a body; force differs by <= {:.1e} of |force|", error);
  return row;
}

// us a body and force in f32 and f64, one thread.
void measure_force(const Model& model, const MachineProbe& probe, SpeedSection& section) {
  const std::vector<Eigen::VectorXd> states = random_states(model, kBodies);
  LaneField<float> floats(model, states);
  LaneField<double> doubles(model, states);
  PotentialWorkspace workspace = model.potential().make_workspace();
  Evaluation evaluation = model.potential().make_evaluation();
  const std::vector<double> seconds =
      by_turns({[&] { floats.evaluate(); }, [&] { doubles.evaluate(); },
                [&] {
                  for (const Eigen::VectorXd& q : states)
                    model.potential().evaluate(q, kWantForce, workspace, evaluation);
                }},
               1, 40);
  double error_f32 = 0.0, error_f64 = 0.0;
  for (std::size_t b = 0; b < states.size(); ++b) {
    model.potential().evaluate(states[b], kWantForce, workspace, evaluation);
    const double size = evaluation.force.norm();
    error_f32 =
        std::max(error_f32, (floats.force(model, states[b], b) - evaluation.force).norm() / size);
    error_f64 =
        std::max(error_f64, (doubles.force(model, states[b], b) - evaluation.force).norm() / size);
  }
  section.rows.push_back(
      force_row<float>(model, seconds[0], seconds[2], probe.gflops_f32, error_f32));
  section.rows.push_back(force_row<double>(model, seconds[1], seconds[2], probe.gflops, error_f64));
}

// The same on a machine without AVX-512.
void measure_avx2(const Model& model, SpeedSection& section) {
  if (widest_lane_vectors() != LaneVectors::kAvx512) return;
  const std::vector<Eigen::VectorXd> states = random_states(model, kBodies);
  LaneField<float> floats(model, states);
  LaneField<double> doubles(model, states);
  const std::vector<double> seconds = by_turns(
      {[&] { floats.evaluate(LaneVectors::kAvx2); }, [&] { doubles.evaluate(LaneVectors::kAvx2); },
       [&] { floats.evaluate(); }, [&] { doubles.evaluate(); }},
      1, 20);
  const char* names[] = {"f32", "f64"};
  for (std::size_t w = 0; w < 2; ++w) {
    SpeedRow row;
    row.what = fmt::format("force of one of {} bodies, r = {}, {} lanes, AVX2", kBodies,
                           model.modes(), names[w]);
    row.value = 1e6 * seconds[w] / kBodies;
    row.baseline = 1e6 * seconds[2 + w] / kBodies;
    row.operations = operations_of_force(static_cast<std::size_t>(model.modes()));
    row.note = "AVX2 code on this machine, against AVX-512";
    section.rows.push_back(row);
  }
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
  const std::vector<double> wall = wall_by_turns({step(0), step(1), step(2), step(3)}, 200);
  if (failed > 0) return Error{ErrorKind::kSolver, "a body of the speed test left the numbers"};
  const auto r = model->modes();
  const double body = 1e6 * one[2] / kBodies;
  const Result<std::string> error = float_orbit_error(model);
  if (!error) return error.error();
  const char* names[] = {"f32", "f64"};
  for (std::size_t w = 0; w < 2; ++w)
    section.rows.push_back(
        row_of(fmt::format("step of one of {} bodies, r = {}, {} lanes", kBodies, r, names[w]),
               1e6 * one[w] / kBodies, body,
               "against 1000 separate bodies, imexv-linear" + (w == 0 ? "; " + *error : "")));
  for (std::size_t w = 0; w < 2; ++w)
    section.rows.push_back(row_of(
        fmt::format("the same on two threads, r = {}, {} lanes", r, names[w]),
        1e6 * wall[2 + w] / kBodies, 1e6 * wall[w] / kBodies, "wall clock, against one thread"));
  return Success{};
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
  section.rows.push_back(row_of(fmt::format("step of {} bodies beside {} that sleep, r = {}",
                                            kBodies, kSleeping, model->modes()),
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
      1e6 * seconds[0] / kBodies, 1e6 * seconds[1] / kBodies, "f32 lanes, against all modes"));
  return Success{};
}

Status measure_surfaces(const Model::Pointer& model, const MachineProbe& probe,
                        SpeedSection& section) {
  constexpr std::size_t kShown = 100;
  Result<World> made = make_world(model, lane_options(LanePrecision::kFloat), 1, kShown);
  if (!made) return made.error();
  World& world = *made;
  std::vector<Body> bodies;
  std::vector<float> positions(3 * model->surface().vertex_ids.size());
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
                                      model->surface().vertex_ids.size(), model->modes()),
                          1e6 * std::max(0.0, step_and_build[0] - step_and_build[1]) / kShown,
                          1e6 * step_and_build[2] / kShown,
                          "a body; step and rebuild less step; against Body's");
  moved.operations = 2.0 * r * size;
  moved.bytes = 4.0 * (r + 1.0) * size / 4.0 + 4.0 * size;
  moved.limit =
      1e-3 * std::max(moved.operations / probe.gflops_f32, moved.bytes / probe.memory_bandwidth);
  moved.limited_by = moved.operations / probe.gflops_f32 > moved.bytes / probe.memory_bandwidth
                         ? "FMA peak"
                         : "memory bandwidth";
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
      "A body a lane: 16 bodies in float or 8 in double share each load of a coefficient. "
      "grad(C + Q) alone is in the lanes' precision; the state, the linear force and all sums are "
      "in double. The column `textbook` holds here the same work done body by body, or what the "
      "note says.";
  Model::Pointer largest;
  for (const char* name : {"horse", "basket", "heart"}) {
    Result<Model::Pointer> model =
        Model::load(fmt::format("{}/{}.tremolo", options.models_dir, name));
    if (!model) return model.error();
    measure_force(**model, probe, section);
    if (Status s = measure_steps(*model, section); !s) return s.error();
    if (!largest || largest->modes() < (*model)->modes()) largest = *model;
    if ((*model)->modes() != 30) continue;
    const SpeedRow& force = section.rows[section.rows.size() - 6];
    Criterion criterion;
    criterion.what = "1000 bodies at r = 30 sharing a model: a body and force evaluation";
    criterion.bound = "<= 3 us with AVX-512";
    criterion.measured = fmt::format("{:.2f} us, {}; {}", force.value, probe.vectors, force.note);
    criterion.met = force.value <= 3.0;
    criterion.decides = probe.vectors == "AVX-512";
    section.criteria.push_back(criterion);
  }
  measure_avx2(*largest, section);
  if (Status s = measure_sleep(largest, section); !s) return s.error();
  if (Status s = measure_detail(largest, section); !s) return s.error();
  if (Status s = measure_surfaces(largest, probe, section); !s) return s.error();
  return section;
}

}  // namespace tremolo::bench
