#include "runtime/crowd.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "common/processor.h"
#include "runtime/bodies/lanes/crowd_contents.h"
#include "runtime/energy.h"
#include "runtime/load.h"

namespace tremolo {
namespace {

// The threshold of SleepOptions, J.
double quiet_energy(const Model& model, const SleepOptions& sleep) {
  if (sleep.energy > 0.0) return sleep.energy;
  const VertexBlock& surface = model.surface();
  if (surface.rest.empty()) return 0.0;
  Eigen::Vector3d least = surface.rest.front(), most = least;
  for (const Eigen::Vector3d& rest : surface.rest) {
    least = least.cwiseMin(rest);
    most = most.cwiseMax(rest);
  }
  double moved = 0.0;  // of the vertex that the first mode moves most, per unit of q
  for (Eigen::Index row = 0; row + 2 < surface.rows.rows(); row += 3)
    moved = std::max(moved, surface.rows.block(row, 0, 3, 1).norm());
  if (moved == 0.0) return 0.0;
  const double amplitude = sleep.displacement * (most - least).maxCoeff() / moved;
  return 0.5 * model.lambda()[0] * amplitude * amplitude;
}

Status check_sleep(const SleepOptions& sleep) {
  if (!(sleep.displacement >= 0.0) || !std::isfinite(sleep.displacement))
    return usage_error("the displacement below which bodies sleep must be finite and not negative");
  if (!(sleep.energy >= 0.0) || !std::isfinite(sleep.energy))
    return usage_error("the energy below which bodies sleep must be finite and not negative");
  if (!(sleep.time >= 0.0)) return usage_error("the time after which bodies sleep is negative");
  return Success{};
}

}  // namespace

Crowd::Crowd(std::unique_ptr<Contents> contents) : contents_(std::move(contents)) {}
Crowd::Crowd(Crowd&&) noexcept = default;
Crowd& Crowd::operator=(Crowd&&) noexcept = default;
Crowd::~Crowd() = default;

Result<Crowd> Crowd::create(unsigned threads) {
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  if (threads > kMostThreads)
    return content_error(std::to_string(threads) + " threads: at most " +
                         std::to_string(kMostThreads));
  auto contents = std::make_unique<Contents>();
  try {
    contents->pool = std::make_unique<ThreadPool>(threads);
  } catch (const std::system_error& error) {
    return system_error(std::string("threads cannot be had: ") + error.what());
  }
  contents->scratch.resize(threads);
  return Crowd(std::move(contents));
}

Result<GroupId> Crowd::add_group(Model::Pointer model, const GroupOptions& options) {
  // Checks the name and the options, for methods in lanes too.
  Result<std::unique_ptr<Integrator>> made =
      make_integrator(options.integrator, model, options.options);
  if (!made) return made.error();
  if (Status s = check_sleep(options.sleep); !s) return s.error();
  const Eigen::Index available = model->modes();
  if (options.modes < 0 || options.modes > available)
    return usage_error("asked for " + std::to_string(options.modes) + " modes; the model has " +
                       std::to_string(available));
  const Eigen::Index modes = options.modes == 0 ? available : options.modes;
  const auto moving = static_cast<std::size_t>(modes);
  if (Status s = check_ratios(options.options.ratios, moving); !s) return s.error();
  CrowdGroup group;
  // Lanes support only the damping at rest. On a linear model ep4 is a closed form.
  const bool linear = model->potential().linear();
  const bool strain_damped = options.options.beta > 0.0 && !linear;
  const bool preserving = preserves_energy_in_lanes(options.integrator);
  if (steps_in_lanes(options.integrator) && !strain_damped &&
      !(preserving && (linear || modes != available))) {
    Result<LaneGroup> lanes =
        LaneGroup::create(model, options.integrator, options.options, moving, options.precision);
    if (!lanes) return lanes.error();
    group.lanes.emplace(std::move(*lanes));
  } else if (modes != available) {
    return usage_error(
        std::string(strain_damped && steps_in_lanes(options.integrator) && !preserving
                        ? "with beta > 0 the bodies of a group step each by itself and leave no "
                          "coordinates out"
                        : "only verlet and imexv-linear leave coordinates out") +
        "; load the model with " + std::to_string(modes) + " modes");
  }
  const Result<Split> band =
      choose_split(model->lambda().head(modes), options.options.step, options.options.split);
  if (!band) return band.error();
  group.integrator = options.integrator;
  group.options = options.options;
  group.modes = moving;
  group.low = band->low;
  group.threshold = quiet_energy(*model, options.sleep);
  group.quiet_time = options.sleep.time;
  group.model = std::move(model);
  for (std::size_t thread = 0; thread < contents_->scratch.size(); ++thread) {
    CrowdScratch& scratch = contents_->scratch[thread];
    scratch.lanes.thread = thread;
    if (group.lanes) group.lanes->make_scratch(scratch.lanes);
    const std::size_t most = std::max(scratch.q.size(), group.modes);
    scratch.q.resize(most);
    scratch.p.resize(most);
    scratch.q_float.resize(kSurfaceBodies * most);
  }
  contents_->groups.push_back(std::move(group));
  contents_->task_ends.resize(contents_->groups.size());
  return static_cast<GroupId>(contents_->groups.size() - 1);
}

Result<BodyId> Crowd::add_body(GroupId group) {
  if (Status s = contents_->check_group(group); !s) return s.error();
  if (Status s = contents_->reserve_index(group); !s) return s.error();
  const auto id = static_cast<BodyId>(contents_->bodies.size());
  contents_->bodies.emplace_back();
  contents_->failed.reserve(contents_->bodies.capacity());
  contents_->failures.reserve(contents_->bodies.capacity());
  contents_->join(id, group);
  return id;
}

Status Crowd::move_body(BodyId id, GroupId to) {
  Contents& all = *contents_;
  if (Status s = all.check_body(id); !s) return s;
  if (Status s = all.check_group(to); !s) return s;
  const CrowdGroup& from = all.groups[all.bodies[id].group];
  if (from.model != all.groups[to].model)
    return usage_error("a body cannot go to a group of another model");
  if (all.bodies[id].group == to) return Success{};
  if (Status s = all.reserve_index(to); !s) return s;
  const std::size_t most = std::max(from.modes, all.groups[to].modes);
  std::vector<double> q(most, 0.0), p(most, 0.0);
  all.read_state(all.bodies[id], q.data(), p.data());
  const bool shown = all.bodies[id].shown, awake = all.bodies[id].slot != kAsleep;
  all.leave(id);
  all.join(id, to);
  all.write_state(id, q.data(), p.data());
  all.show(id, shown);
  if (awake) all.wake(id);
  return Success{};
}

Status Crowd::remove_body(BodyId id) {
  if (Status s = contents_->check_body(id); !s) return s;
  contents_->leave(id);
  contents_->bodies[id].alive = false;
  return Success{};
}

Status Crowd::apply_force(BodyId id, VertexId vertex, const Eigen::Vector3d& force, int steps) {
  if (Status s = contents_->check_body(id); !s) return s;
  if (steps < 1)
    return usage_error("a force acts for at least one step, got " + std::to_string(steps));
  CrowdBody& body = contents_->bodies[id];
  CrowdGroup& group = contents_->groups[body.group];
  if (group.lanes) {
    Result<Eigen::VectorXd> reduced = reduce_force(*group.model, vertex, force);
    if (!reduced) return reduced.error();
    group.forces.push_back({id, steps, reduced->head(static_cast<Eigen::Index>(group.modes))});
    ++body.forces;
  } else if (Status s = group.bodies[body.index]->apply_force(vertex, force, steps); !s) {
    return s;
  }
  contents_->wake(id);
  return Success{};
}

Status Crowd::clear_forces(BodyId id) {
  if (Status s = contents_->check_body(id); !s) return s;
  contents_->clear_forces(id);
  return Success{};
}

Status Crowd::set_state(BodyId id, const Eigen::VectorXd& q, const Eigen::VectorXd& p) {
  if (Status s = contents_->check_body(id); !s) return s;
  const auto modes =
      static_cast<Eigen::Index>(contents_->groups[contents_->bodies[id].group].modes);
  if (Status s = check_state(modes, q, p); !s) return s;
  contents_->write_state(id, q.data(), p.data());
  contents_->wake(id);
  return Success{};
}

Status Crowd::wake(BodyId id) {
  if (Status s = contents_->check_body(id); !s) return s;
  contents_->wake(id);
  return Success{};
}

Status Crowd::sleep(BodyId id) {
  if (Status s = contents_->check_body(id); !s) return s;
  contents_->sleep(id);
  return Success{};
}

const CrowdReport& Crowd::step() {
  contents_->step(0, static_cast<GroupId>(contents_->groups.size()));
  return contents_->report;
}

Result<CrowdReport> Crowd::step(GroupId group) {
  if (Status s = contents_->check_group(group); !s) return s.error();
  contents_->step(group, group + 1);
  return contents_->report;
}

std::size_t Crowd::awake() const {
  std::size_t count = 0;
  for (const CrowdGroup& group : contents_->groups) count += group.awake.size();
  return count;
}

Result<bool> Crowd::is_awake(BodyId id) const {
  if (Status s = contents_->check_body(id); !s) return s.error();
  return contents_->bodies[id].slot != kAsleep;
}

Result<State> Crowd::state(BodyId id) const {
  if (Status s = contents_->check_body(id); !s) return s.error();
  const CrowdBody& body = contents_->bodies[id];
  const auto modes = static_cast<Eigen::Index>(contents_->groups[body.group].modes);
  State state{Eigen::VectorXd(modes), Eigen::VectorXd(modes)};
  contents_->read_state(body, state.q.data(), state.p.data());
  return state;
}

Result<Energy> Crowd::energy(BodyId id) const {
  Result<State> state = this->state(id);
  if (!state) return state.error();
  const CrowdBody& body = contents_->bodies[id];
  const CrowdGroup& group = contents_->groups[body.group];
  if (!group.lanes) return group.bodies[body.index]->energy();
  const Potential& potential = group.model->potential();
  const auto modes = static_cast<Eigen::Index>(group.modes);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(potential.size());
  q.head(modes) = state->q;
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  potential.evaluate(q, kWantEnergy | kWantForce, workspace, evaluation);
  return Energy{kinetic_energy(state->p), evaluation.energy,
                band_energy(group.model->lambda().head(modes), evaluation.force.head(modes),
                            state->p, group.low)};
}

Status Crowd::set_shown(BodyId id, bool shown) {
  if (Status s = contents_->check_body(id); !s) return s;
  contents_->show(id, shown);
  return Success{};
}

Result<SurfaceView> Crowd::surface(BodyId id) const {
  if (Status s = contents_->check_body(id); !s) return s.error();
  const CrowdBody& body = contents_->bodies[id];
  if (!body.shown) return usage_error("body " + std::to_string(id) + " is not shown");
  const std::size_t count = 3 * contents_->groups[body.group].model->drawn().rest.size();
  return SurfaceView{{body.surface.data(), count}, body.version};
}

}  // namespace tremolo
