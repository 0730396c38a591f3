// tremolo_world_*: many bodies from C.
#include <algorithm>
#include <cstring>

#include "runtime/c_api/c_api.h"

namespace {

using tremolo::Error;
using tremolo::ErrorKind;
using tremolo::GroupOptions;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::guarded;
using tremolo::c_api::need;
using tremolo::c_api::need_buffer;
using tremolo::c_api::usage_error;

Result<tremolo_group_options> complete_options(const tremolo_group_options* given) {
  tremolo_group_options options;
  tremolo_group_options_init(&options);
  if (given == nullptr) return options;
  std::uint32_t size = 0;
  std::memcpy(&size, given, sizeof(size));
  if (size < sizeof(size))
    return usage_error("the options' size is " + std::to_string(size) +
                       "; call tremolo_group_options_init first");
  std::memcpy(&options, given, std::min<std::size_t>(size, sizeof(options)));
  return options;
}

// `name` keeps the integrator's: the options only refer to it.
Result<GroupOptions> to_group_options(const tremolo_body_options* method,
                                      const tremolo_group_options* given, std::string& name) {
  const Result<tremolo_body_options> body = tremolo::c_api::complete_options(method);
  if (!body) return body.error();
  const Result<tremolo_group_options> group = complete_options(given);
  if (!group) return group.error();
  const Result<tremolo::IntegratorOptions> integrator =
      tremolo::c_api::to_integrator_options(*body);
  if (!integrator) return integrator.error();
  GroupOptions options;
  name = body->integrator == nullptr ? options.integrator : body->integrator;
  options.integrator = name;
  options.options = *integrator;
  options.modes = group->modes;
  options.precision = group->single_precision != 0 ? tremolo::LanePrecision::kFloat
                                                   : tremolo::LanePrecision::kDouble;
  options.sleep = {.displacement = group->sleep_displacement,
                   .energy = group->sleep_energy,
                   .time = group->sleep_time};
  return options;
}

// Runs action(world) -> Status.
template <class Handle, class Action>
tremolo_status with_world(Handle* handle, Action&& action) noexcept {
  return guarded([&]() -> Status {
    if (Status s = need(handle, "the world"); !s) return s;
    return action(handle->world);
  });
}

const char* reason(tremolo::StepFailure failure) {
  switch (failure) {
    case tremolo::StepFailure::kLoad:
      return "its numbers overflow under the forces on it";
    case tremolo::StepFailure::kNumbers:
      return "its numbers overflow";
    case tremolo::StepFailure::kEnergy:
      return "its energy is far above what was put in, the method has exploded";
    default:
      return "its solve gave up";
  }
}

// Keeps what was made, unless there is no place for it.
Status keep(const Result<std::uint32_t>& made, std::uint32_t* place) {
  if (!made) return made.error();
  *place = *made;
  return Success{};
}

}  // namespace

void tremolo_group_options_init(tremolo_group_options* options) {
  if (options == nullptr) return;
  const GroupOptions defaults;
  *options = {.size = sizeof(tremolo_group_options),
              .modes = 0,
              .single_precision = 0,
              .reserved = 0,
              .sleep_energy = defaults.sleep.energy,
              .sleep_displacement = defaults.sleep.displacement,
              .sleep_time = defaults.sleep.time};
}

tremolo_status tremolo_world_create(uint32_t threads, tremolo_world** world) {
  return guarded([&]() -> Status {
    if (Status s = need(world, "the place for the world"); !s) return s;
    Result<tremolo::World> made = tremolo::World::create(threads);
    if (!made) return made.error();
    *world = new tremolo_world{std::move(*made)};
    return Success{};
  });
}

void tremolo_world_destroy(tremolo_world* world) {
  delete world;
}

tremolo_status tremolo_world_add_group(tremolo_world* world, const tremolo_model* model,
                                       const tremolo_body_options* method,
                                       const tremolo_group_options* options, uint32_t* group) {
  return with_world(world, [&](tremolo::World& known) -> Status {
    if (Status s = need(model, "the model"); !s) return s;
    if (Status s = need(group, "the place for the group"); !s) return s;
    std::string name;
    const Result<GroupOptions> full = to_group_options(method, options, name);
    if (!full) return full.error();
    return keep(known.add_group(model->pointer, *full), group);
  });
}

tremolo_status tremolo_world_add_body(tremolo_world* world, uint32_t group, uint32_t* body) {
  return with_world(world, [&](tremolo::World& known) -> Status {
    if (Status s = need(body, "the place for the body"); !s) return s;
    return keep(known.add_body(group), body);
  });
}

tremolo_status tremolo_world_remove_body(tremolo_world* world, uint32_t body) {
  return with_world(world, [&](tremolo::World& known) { return known.remove_body(body); });
}

tremolo_status tremolo_world_move_body(tremolo_world* world, uint32_t body, uint32_t group) {
  return with_world(world, [&](tremolo::World& known) { return known.move_body(body, group); });
}

tremolo_status tremolo_world_apply_force(tremolo_world* world, uint32_t body, uint32_t vertex,
                                         const double force[3], int32_t steps) {
  return with_world(world, [&](tremolo::World& known) -> Status {
    if (Status s = need(force, "the force"); !s) return s;
    if (!std::in_range<tremolo::VertexId>(vertex))
      return usage_error("the model has no vertex " + std::to_string(vertex));
    return known.apply_force(body, static_cast<tremolo::VertexId>(vertex),
                             Eigen::Vector3d(force[0], force[1], force[2]), steps);
  });
}

tremolo_status tremolo_world_clear_forces(tremolo_world* world, uint32_t body) {
  return with_world(world, [&](tremolo::World& known) { return known.clear_forces(body); });
}

tremolo_status tremolo_world_step(tremolo_world* world, uint32_t* failed, size_t length,
                                  size_t* failed_count) {
  if (failed_count != nullptr) *failed_count = 0;
  return with_world(world, [&](tremolo::World& known) -> Status {
    const tremolo::WorldReport& report = known.step();
    if (report.failed.empty()) return Success{};
    if (failed != nullptr)
      std::copy_n(report.failed.begin(), std::min(length, report.failed.size()), failed);
    if (failed_count != nullptr) *failed_count = report.failed.size();
    return Error{ErrorKind::kSolver, std::to_string(report.failed.size()) +
                                         " bodies could not make their step, the first is body " +
                                         std::to_string(report.failed[0]) + ": " +
                                         reason(report.why[0])};
  });
}

size_t tremolo_world_awake(const tremolo_world* world) {
  return world == nullptr ? 0 : world->world.awake();
}

tremolo_status tremolo_world_wake(tremolo_world* world, uint32_t body) {
  return with_world(world, [&](tremolo::World& known) { return known.wake(body); });
}

tremolo_status tremolo_world_sleep(tremolo_world* world, uint32_t body) {
  return with_world(world, [&](tremolo::World& known) { return known.sleep(body); });
}

tremolo_status tremolo_world_state(const tremolo_world* world, uint32_t body, double* q, double* p,
                                   size_t length) {
  return with_world(world, [&](const tremolo::World& known) -> Status {
    const Result<tremolo::State> state = known.state(body);
    if (!state) return state.error();
    if (Status s = need_buffer(q, length, static_cast<size_t>(state->q.size())); !s) return s;
    std::copy(state->q.begin(), state->q.end(), q);
    if (p != nullptr) std::copy(state->p.begin(), state->p.end(), p);
    return Success{};
  });
}

tremolo_status tremolo_world_energy(const tremolo_world* world, uint32_t body, double* kinetic,
                                    double* potential, double* high_band) {
  return with_world(world, [&](const tremolo::World& known) -> Status {
    const Result<tremolo::Energy> energy = known.energy(body);
    if (!energy) return energy.error();
    if (kinetic != nullptr) *kinetic = energy->kinetic;
    if (potential != nullptr) *potential = energy->potential;
    if (high_band != nullptr) *high_band = energy->high_band;
    return Success{};
  });
}

tremolo_status tremolo_world_set_state(tremolo_world* world, uint32_t body, const double* q,
                                       const double* p, size_t length) {
  return with_world(world, [&](tremolo::World& known) -> Status {
    if (Status s = need(q, "the coordinates"); !s) return s;
    if (Status s = need(p, "the momenta"); !s) return s;
    const Result<tremolo::State> now = known.state(body);
    if (!now) return now.error();
    if (Status s = need_buffer(q, length, static_cast<size_t>(now->q.size())); !s) return s;
    return known.set_state(body, Eigen::Map<const Eigen::VectorXd>(q, now->q.size()),
                           Eigen::Map<const Eigen::VectorXd>(p, now->q.size()));
  });
}

tremolo_status tremolo_world_set_shown(tremolo_world* world, uint32_t body, int32_t shown) {
  return with_world(world,
                    [&](tremolo::World& known) { return known.set_shown(body, shown != 0); });
}

tremolo_status tremolo_world_update_surfaces(tremolo_world* world, size_t* updated) {
  return with_world(world, [&](tremolo::World& known) -> Status {
    const size_t count = known.update_surfaces();
    if (updated != nullptr) *updated = count;
    return Success{};
  });
}

tremolo_status tremolo_world_surface(const tremolo_world* world, uint32_t body,
                                     const float** positions, size_t* length, uint64_t* version) {
  return with_world(world, [&](const tremolo::World& known) -> Status {
    if (Status s = need(positions, "the place for the positions"); !s) return s;
    if (Status s = need(length, "the place for the length"); !s) return s;
    const Result<tremolo::SurfaceView> view = known.surface(body);
    if (!view) return view.error();
    *positions = view->positions.data();
    *length = view->positions.size();
    if (version != nullptr) *version = view->version;
    return Success{};
  });
}
