// World: bodies in their groups, awake and asleep.
#include "runtime/crowd/world_contents.h"

#include <algorithm>
#include <utility>

namespace tremolo {
namespace {

Error usage_error(std::string message) {
  return {ErrorKind::kUsage, std::move(message)};
}

}  // namespace

Status World::Contents::check_body(BodyId id) const {
  if (id < bodies.size() && bodies[id].alive) return Success{};
  return usage_error("the world has no body " + std::to_string(id));
}

Status World::Contents::check_group(GroupId group) const {
  if (group < groups.size()) return Success{};
  return usage_error("the world has no group " + std::to_string(group));
}

void World::Contents::read_state(const WorldBody& body, double* q, double* p) const {
  const WorldGroup& group = groups[body.group];
  if (!group.lanes) {
    const State& state = group.bodies[body.place]->state();
    std::copy(state.q.begin(), state.q.end(), q);
    std::copy(state.p.begin(), state.p.end(), p);
  } else if (body.slot != kAsleep) {
    group.lanes->read(body.slot, q, p);
  } else {
    const double* home = group.homes.data() + 4 * group.modes * body.place;
    std::copy_n(home, group.modes, q);
    std::copy_n(home + group.modes, group.modes, p);
  }
}

void World::Contents::write_state(BodyId id, const double* q, const double* p) {
  const WorldBody& body = bodies[id];
  WorldGroup& group = groups[body.group];
  if (!group.lanes) {
    const auto modes = static_cast<Eigen::Index>(group.modes);
    // Of the right length and finite: set_state() has nothing to refuse.
    (void)group.bodies[body.place]->set_state(Eigen::Map<const Eigen::VectorXd>(q, modes),
                                              Eigen::Map<const Eigen::VectorXd>(p, modes));
    group.quiet[body.place] = 0.0;
  } else if (body.slot != kAsleep) {
    group.lanes->write(body.slot, q, p);
  } else {
    double* home = group.home(body);
    for (const double* part : {q, p, q, p}) home = std::copy_n(part, group.modes, home);
    group.home_bounds[body.place].restart();
  }
  touch(id);
}

void World::Contents::wake(BodyId id) {
  WorldBody& body = bodies[id];
  if (body.slot != kAsleep) return;
  WorldGroup& group = groups[body.group];
  body.slot = group.awake.size();
  group.awake.push_back(id);
  if (group.lanes)
    group.lanes->insert(group.home(body), group.home_bounds[body.place]);
  else
    group.quiet[body.place] = 0.0;
}

void World::Contents::sleep(BodyId id) {
  WorldBody& body = bodies[id];
  if (body.slot == kAsleep) return;
  WorldGroup& group = groups[body.group];
  if (body.built_at < group.steps) touch(id);
  if (group.lanes) {
    group.lanes->save(body.slot, group.home(body), group.home_bounds[body.place]);
    group.lanes->remove(body.slot);
  }
  clear_forces(id);
  bodies[group.awake.back()].slot = body.slot;
  group.awake[body.slot] = group.awake.back();
  group.awake.pop_back();
  body.slot = kAsleep;
}

void World::Contents::clear_forces(BodyId id) {
  WorldBody& body = bodies[id];
  WorldGroup& group = groups[body.group];
  if (!group.lanes) {
    group.bodies[body.place]->clear_forces();
  } else if (body.forces > 0) {
    std::erase_if(group.forces, [id](const WorldForce& force) { return force.body == id; });
    body.forces = 0;
  }
}

// Room for one more, with all that a step may need for it.
Status World::Contents::make_place(GroupId g) {
  WorldGroup& group = groups[g];
  if (group.lanes) {
    if (group.free_places.empty()) {
      group.free_places.push_back(group.places++);
      group.homes.resize(4 * group.modes * group.places);
      group.home_bounds.resize(group.places);
      group.lanes->reserve(group.places);
      group.outcomes.resize(group.places / group.lanes->lanes() + 1);
    }
  } else {
    Result<Body> body = Body::create(group.model, group.integrator, group.options);
    if (!body) return body.error();
    if (group.free_places.empty()) {
      group.free_places.push_back(group.places++);
      group.bodies.resize(group.places);
      group.quiet.resize(group.places);
      group.failed.resize(group.places);
    }
    group.bodies[group.free_places.back()] = std::make_unique<Body>(std::move(*body));
  }
  if (group.awake.capacity() < group.places) group.awake.reserve(2 * group.places);
  return Success{};
}

void World::Contents::place(BodyId id, GroupId g) {
  WorldGroup& group = groups[g];
  WorldBody& body = bodies[id];
  body.group = g;
  body.place = group.free_places.back();
  group.free_places.pop_back();
  body.slot = kAsleep;
  if (!group.lanes) return;
  std::fill_n(group.home(body), 4 * group.modes, 0.0);
  group.home_bounds[body.place] = {};
}

void World::Contents::leave(BodyId id) {
  sleep(id);
  show(id, false);
  WorldGroup& group = groups[bodies[id].group];
  if (!group.lanes) group.bodies[bodies[id].place].reset();
  group.free_places.push_back(bodies[id].place);
}

}  // namespace tremolo
