// Crowd: bodies in their groups, awake and asleep.
#include "runtime/bodies/lanes/crowd_contents.h"

#include <algorithm>
#include <utility>

namespace tremolo {
Status Crowd::Contents::check_body(BodyId id) const {
  if (id < bodies.size() && bodies[id].alive) return Success{};
  return usage_error("the crowd has no body " + std::to_string(id));
}

Status Crowd::Contents::check_group(GroupId group) const {
  if (group < groups.size()) return Success{};
  return usage_error("the crowd has no group " + std::to_string(group));
}

void Crowd::Contents::read_state(const CrowdBody& body, double* q, double* p) const {
  const CrowdGroup& group = groups[body.group];
  if (!group.lanes) {
    const State& state = group.bodies[body.index]->state();
    std::copy(state.q.begin(), state.q.end(), q);
    std::copy(state.p.begin(), state.p.end(), p);
  } else if (body.slot != kAsleep) {
    group.lanes->read(body.slot, q, p);
  } else {
    const double* saved = group.saved_states.data() + 4 * group.modes * body.index;
    std::copy_n(saved, group.modes, q);
    std::copy_n(saved + group.modes, group.modes, p);
  }
}

void Crowd::Contents::write_state(BodyId id, const double* q, const double* p) {
  const CrowdBody& body = bodies[id];
  CrowdGroup& group = groups[body.group];
  if (!group.lanes) {
    const auto modes = static_cast<Eigen::Index>(group.modes);
    // Both have the right length and are finite, so that set_state() does not fail.
    (void)group.bodies[body.index]->set_state(Eigen::Map<const Eigen::VectorXd>(q, modes),
                                              Eigen::Map<const Eigen::VectorXd>(p, modes));
    group.quiet[body.index] = 0.0;
  } else if (body.slot != kAsleep) {
    group.lanes->write(body.slot, q, p);
  } else {
    double* saved = group.saved_state(body);
    for (const double* part : {q, p, q, p}) saved = std::copy_n(part, group.modes, saved);
    group.saved_bounds[body.index].restart();
  }
  mark_dirty(id);
}

void Crowd::Contents::wake(BodyId id) {
  CrowdBody& body = bodies[id];
  if (body.slot != kAsleep) return;
  CrowdGroup& group = groups[body.group];
  body.slot = group.awake.size();
  group.awake.push_back(id);
  if (group.lanes)
    group.lanes->insert(group.saved_state(body), group.saved_bounds[body.index]);
  else
    group.quiet[body.index] = 0.0;
}

void Crowd::Contents::sleep(BodyId id) {
  CrowdBody& body = bodies[id];
  if (body.slot == kAsleep) return;
  CrowdGroup& group = groups[body.group];
  if (body.built_at < group.steps) mark_dirty(id);
  if (group.lanes) {
    group.lanes->save(body.slot, group.saved_state(body), group.saved_bounds[body.index]);
    group.lanes->remove(body.slot);
  }
  clear_forces(id);
  bodies[group.awake.back()].slot = body.slot;
  group.awake[body.slot] = group.awake.back();
  group.awake.pop_back();
  body.slot = kAsleep;
}

void Crowd::Contents::clear_forces(BodyId id) {
  CrowdBody& body = bodies[id];
  CrowdGroup& group = groups[body.group];
  if (!group.lanes) {
    group.bodies[body.index]->clear_forces();
  } else if (body.forces > 0) {
    std::erase_if(group.forces, [id](const WorldForce& force) { return force.body == id; });
    body.forces = 0;
  }
}

// Reserves memory for one more body, with all that a step may need for it.
Status Crowd::Contents::reserve_index(GroupId g) {
  CrowdGroup& group = groups[g];
  if (group.lanes) {
    if (group.free_indices.empty()) {
      group.free_indices.push_back(group.indices++);
      group.saved_states.resize(4 * group.modes * group.indices);
      group.saved_bounds.resize(group.indices);
      group.lanes->reserve(group.indices);
      group.outcomes.resize(group.indices / group.lanes->lanes() + 1);
    }
  } else {
    Result<Body> body = Body::create(group.model, group.integrator, group.options);
    if (!body) return body.error();
    if (group.free_indices.empty()) {
      group.free_indices.push_back(group.indices++);
      group.bodies.resize(group.indices);
      group.quiet.resize(group.indices);
      group.failed.resize(group.indices);
    }
    group.bodies[group.free_indices.back()] = std::make_unique<Body>(std::move(*body));
  }
  if (group.awake.capacity() < group.indices) group.awake.reserve(2 * group.indices);
  return Success{};
}

void Crowd::Contents::join(BodyId id, GroupId g) {
  CrowdGroup& group = groups[g];
  CrowdBody& body = bodies[id];
  body.group = g;
  body.index = group.free_indices.back();
  group.free_indices.pop_back();
  body.slot = kAsleep;
  if (!group.lanes) return;
  std::fill_n(group.saved_state(body), 4 * group.modes, 0.0);
  group.saved_bounds[body.index] = {};
}

void Crowd::Contents::leave(BodyId id) {
  sleep(id);
  show(id, false);
  CrowdGroup& group = groups[bodies[id].group];
  if (!group.lanes) group.bodies[bodies[id].index].reset();
  group.free_indices.push_back(bodies[id].index);
}

}  // namespace tremolo
