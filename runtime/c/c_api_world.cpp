// tremolo_world_*: many bodies from C.
#include <algorithm>

#include "runtime/c/c_api.h"

namespace {

using tremolo::Error;
using tremolo::ErrorKind;
using tremolo::GroupOptions;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::World;
using tremolo::c_api::need;
using tremolo::c_api::with;

// `name` keeps the integrator's: the options only refer to it.
Result<GroupOptions> to_group_options(const tremolo_body_options* method,
                                      const tremolo_group_options* given, std::string& name) {
  const Result<tremolo_body_options> body = tremolo::c_api::complete_body_options(method);
  if (!body) return body.error();
  if (body->frame != TREMOLO_FIXED)
    return tremolo::usage_error("bodies of a world are fixed: their frame must be TREMOLO_FIXED");
  const Result<tremolo_group_options> group =
      tremolo::c_api::complete(given, tremolo_group_options_init, "tremolo_group_options_init");
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

// Stores a new number in `place`, which is not NULL.
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
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({{world, "the place for the world"}}); !s) return s;
    Result<World> made = World::create(threads);
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
  return with(world, {{model, "the model"}, {group, "the place for the group"}},
              [&](World& known) -> Status {
                std::string name;
                const Result<GroupOptions> full = to_group_options(method, options, name);
                if (!full) return full.error();
                return keep(known.add_group(model->pointer, *full), group);
              });
}

tremolo_status tremolo_world_add_body(tremolo_world* world, uint32_t group, uint32_t* body) {
  return with(world, {{body, "the place for the body"}},
              [&](World& known) -> Status { return keep(known.add_body(group), body); });
}

tremolo_status tremolo_world_remove_body(tremolo_world* world, uint32_t body) {
  return with(world, [&](World& known) { return known.remove_body(body); });
}

tremolo_status tremolo_world_move_body(tremolo_world* world, uint32_t body, uint32_t group) {
  return with(world, [&](World& known) { return known.move_body(body, group); });
}

tremolo_status tremolo_world_apply_force(tremolo_world* world, uint32_t body, uint32_t vertex,
                                         const double force[3], int32_t steps) {
  return with(world, {{force, "the force"}}, [&](World& known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return known.apply_force(body, *id, Eigen::Vector3d(force), steps);
  });
}

tremolo_status tremolo_world_clear_forces(tremolo_world* world, uint32_t body) {
  return with(world, [&](World& known) { return known.clear_forces(body); });
}

tremolo_status tremolo_world_step(tremolo_world* world, uint32_t* failed, size_t length,
                                  size_t* failed_count) {
  if (failed_count != nullptr) *failed_count = 0;
  return with(world, [&](World& known) -> Status {
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
  return with(world, [&](World& known) { return known.wake(body); });
}

tremolo_status tremolo_world_sleep(tremolo_world* world, uint32_t body) {
  return with(world, [&](World& known) { return known.sleep(body); });
}

tremolo_status tremolo_world_state(const tremolo_world* world, uint32_t body, double* q, double* p,
                                   size_t length) {
  return with(world, [&](const World& known) -> Status {
    const Result<tremolo::State> state = known.state(body);
    if (!state) return state.error();
    return tremolo::c_api::copy_state(*state, q, p, length);
  });
}

tremolo_status tremolo_world_energy(const tremolo_world* world, uint32_t body, double* kinetic,
                                    double* potential, double* high_band) {
  return with(world, [&](const World& known) -> Status {
    const Result<tremolo::Energy> energy = known.energy(body);
    if (!energy) return energy.error();
    tremolo::c_api::copy_energy(*energy, kinetic, potential, high_band);
    return Success{};
  });
}

tremolo_status tremolo_world_set_state(tremolo_world* world, uint32_t body, const double* q,
                                       const double* p, size_t length) {
  return with(world, {{q, "the coordinates"}, {p, "the momenta"}}, [&](World& known) -> Status {
    const Result<tremolo::State> now = known.state(body);
    if (!now) return now.error();
    if (Status s = tremolo::c_api::need_buffer(q, length, static_cast<size_t>(now->q.size())); !s)
      return s;
    return known.set_state(body, Eigen::Map<const Eigen::VectorXd>(q, now->q.size()),
                           Eigen::Map<const Eigen::VectorXd>(p, now->q.size()));
  });
}

tremolo_status tremolo_world_set_shown(tremolo_world* world, uint32_t body, int32_t shown) {
  return with(world, [&](World& known) { return known.set_shown(body, shown != 0); });
}

tremolo_status tremolo_world_update_surfaces(tremolo_world* world, size_t* updated) {
  return with(world, [&](World& known) -> Status {
    const size_t count = known.update_surfaces();
    if (updated != nullptr) *updated = count;
    return Success{};
  });
}

tremolo_status tremolo_world_surface(const tremolo_world* world, uint32_t body,
                                     const float** positions, size_t* length, uint64_t* version) {
  return with(world,
              {{positions, "the place for the positions"}, {length, "the place for the length"}},
              [&](const World& known) -> Status {
                const Result<tremolo::SurfaceView> view = known.surface(body);
                if (!view) return view.error();
                *positions = view->positions.data();
                *length = view->positions.size();
                if (version != nullptr) *version = view->version;
                return Success{};
              });
}
