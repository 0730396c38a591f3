// tremolo_crowd_*: many bodies from C.
#include <algorithm>

#include "runtime/c/c_api.h"

namespace {

using tremolo::Crowd;
using tremolo::Error;
using tremolo::ErrorKind;
using tremolo::GroupOptions;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::need;
using tremolo::c_api::with;

// `name` keeps the integrator's: the options only refer to it.
Result<GroupOptions> to_group_options(const tremolo_body_options* method,
                                      const tremolo_group_options* given, std::string& name) {
  const Result<tremolo_body_options> body = tremolo::c_api::complete_body_options(method);
  if (!body) return body.error();
  if (body->frame != TREMOLO_FIXED)
    return tremolo::usage_error("bodies of a crowd are fixed: their frame must be TREMOLO_FIXED");
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

tremolo_status tremolo_crowd_create(uint32_t threads, tremolo_crowd** crowd) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({{crowd, "the place for the crowd"}}); !s) return s;
    Result<Crowd> made = Crowd::create(threads);
    if (!made) return made.error();
    *crowd = new tremolo_crowd{std::move(*made)};
    return Success{};
  });
}

void tremolo_crowd_destroy(tremolo_crowd* crowd) {
  delete crowd;
}

tremolo_status tremolo_crowd_add_group(tremolo_crowd* crowd, const tremolo_model* model,
                                       const tremolo_body_options* method,
                                       const tremolo_group_options* options, uint32_t* group) {
  return with(crowd, {{model, "the model"}, {group, "the place for the group"}},
              [&](Crowd& known) -> Status {
                std::string name;
                const Result<GroupOptions> full = to_group_options(method, options, name);
                if (!full) return full.error();
                return keep(known.add_group(model->pointer, *full), group);
              });
}

tremolo_status tremolo_crowd_add_body(tremolo_crowd* crowd, uint32_t group, uint32_t* body) {
  return with(crowd, {{body, "the place for the body"}},
              [&](Crowd& known) -> Status { return keep(known.add_body(group), body); });
}

tremolo_status tremolo_crowd_remove_body(tremolo_crowd* crowd, uint32_t body) {
  return with(crowd, [&](Crowd& known) { return known.remove_body(body); });
}

tremolo_status tremolo_crowd_move_body(tremolo_crowd* crowd, uint32_t body, uint32_t group) {
  return with(crowd, [&](Crowd& known) { return known.move_body(body, group); });
}

tremolo_status tremolo_crowd_apply_force(tremolo_crowd* crowd, uint32_t body, uint32_t vertex,
                                         const double force[3], int32_t steps) {
  return with(crowd, {{force, "the force"}}, [&](Crowd& known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return known.apply_force(body, *id, Eigen::Vector3d(force), steps);
  });
}

tremolo_status tremolo_crowd_clear_forces(tremolo_crowd* crowd, uint32_t body) {
  return with(crowd, [&](Crowd& known) { return known.clear_forces(body); });
}

tremolo_status tremolo_crowd_step(tremolo_crowd* crowd, uint32_t* failed, size_t length,
                                  size_t* failed_count) {
  if (failed_count != nullptr) *failed_count = 0;
  return with(crowd, [&](Crowd& known) -> Status {
    const tremolo::CrowdReport& report = known.step();
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

size_t tremolo_crowd_awake(const tremolo_crowd* crowd) {
  return crowd == nullptr ? 0 : crowd->crowd.awake();
}

tremolo_status tremolo_crowd_wake(tremolo_crowd* crowd, uint32_t body) {
  return with(crowd, [&](Crowd& known) { return known.wake(body); });
}

tremolo_status tremolo_crowd_sleep(tremolo_crowd* crowd, uint32_t body) {
  return with(crowd, [&](Crowd& known) { return known.sleep(body); });
}

tremolo_status tremolo_crowd_state(const tremolo_crowd* crowd, uint32_t body, double* q, double* p,
                                   size_t length) {
  return with(crowd, [&](const Crowd& known) -> Status {
    const Result<tremolo::State> state = known.state(body);
    if (!state) return state.error();
    return tremolo::c_api::copy_state(*state, q, p, length);
  });
}

tremolo_status tremolo_crowd_energy(const tremolo_crowd* crowd, uint32_t body, double* kinetic,
                                    double* potential, double* high_band) {
  return with(crowd, [&](const Crowd& known) -> Status {
    const Result<tremolo::Energy> energy = known.energy(body);
    if (!energy) return energy.error();
    tremolo::c_api::copy_energy(*energy, kinetic, potential, high_band);
    return Success{};
  });
}

tremolo_status tremolo_crowd_set_state(tremolo_crowd* crowd, uint32_t body, const double* q,
                                       const double* p, size_t length) {
  return with(crowd, {{q, "the coordinates"}, {p, "the momenta"}}, [&](Crowd& known) -> Status {
    const Result<tremolo::State> now = known.state(body);
    if (!now) return now.error();
    if (Status s = tremolo::c_api::need_buffer(q, length, static_cast<size_t>(now->q.size())); !s)
      return s;
    return known.set_state(body, Eigen::Map<const Eigen::VectorXd>(q, now->q.size()),
                           Eigen::Map<const Eigen::VectorXd>(p, now->q.size()));
  });
}

tremolo_status tremolo_crowd_set_shown(tremolo_crowd* crowd, uint32_t body, int32_t shown) {
  return with(crowd, [&](Crowd& known) { return known.set_shown(body, shown != 0); });
}

tremolo_status tremolo_crowd_update_surfaces(tremolo_crowd* crowd, size_t* updated) {
  return with(crowd, [&](Crowd& known) -> Status {
    const size_t count = known.update_surfaces();
    if (updated != nullptr) *updated = count;
    return Success{};
  });
}

tremolo_status tremolo_crowd_surface(const tremolo_crowd* crowd, uint32_t body,
                                     const float** positions, size_t* length, uint64_t* version) {
  return with(crowd,
              {{positions, "the place for the positions"}, {length, "the place for the length"}},
              [&](const Crowd& known) -> Status {
                const Result<tremolo::SurfaceView> view = known.surface(body);
                if (!view) return view.error();
                *positions = view->positions.data();
                *length = view->positions.size();
                if (version != nullptr) *version = view->version;
                return Success{};
              });
}
