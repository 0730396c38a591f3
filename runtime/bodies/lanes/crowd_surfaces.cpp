// Crowd: the surfaces of the bodies that are shown.
#include <algorithm>

#include "runtime/bodies/lanes/crowd_contents.h"

namespace tremolo {

void Crowd::Contents::mark_dirty(BodyId id) {
  CrowdBody& body = bodies[id];
  if (!body.shown || body.dirty) return;
  body.dirty = true;
  groups[body.group].dirty.push_back(id);
}

void Crowd::Contents::show(BodyId id, bool shown) {
  CrowdBody& body = bodies[id];
  if (body.shown == shown) return;
  CrowdGroup& group = groups[body.group];
  if (!shown) {
    std::erase(group.dirty, id);
    body.dirty = body.shown = false;
    body.surface = {};
    --group.shown;
    return;
  }
  body.surface.resize(kSurfaceBlock * group.model->surface_basis().blocks());
  body.shown = true;
  ++group.shown;
  // Memory for the lists of update_surfaces(), so that it allocates nothing.
  std::size_t all = 0;
  for (const CrowdGroup& each : groups) all += each.shown;
  dirty_bodies.reserve(all);
  batches.reserve(all / kSurfaceBodies + groups.size());
  group.dirty.reserve(group.shown);
  mark_dirty(id);
}

// Lists the bodies whose surfaces must be built again, by groups, divided into batches.
void Crowd::Contents::list_dirty() {
  dirty_bodies.clear();
  batches.clear();
  for (GroupId g = 0; g < groups.size(); ++g) {
    CrowdGroup& group = groups[g];
    if (group.shown == 0) continue;
    const std::size_t begin = dirty_bodies.size();
    dirty_bodies.insert(dirty_bodies.end(), group.dirty.begin(), group.dirty.end());
    group.dirty.clear();
    for (const BodyId id : group.awake) {
      const CrowdBody& body = bodies[id];
      if (body.shown && !body.dirty && body.built_at < group.steps) dirty_bodies.push_back(id);
    }
    for (std::size_t at = begin; at < dirty_bodies.size(); at += kSurfaceBodies)
      batches.push_back({g, at, std::min(kSurfaceBodies, dirty_bodies.size() - at)});
  }
}

void Crowd::Contents::build(const SurfaceBatch& batch, CrowdScratch& mine) {
  const CrowdGroup& group = groups[batch.group];
  const float* q[kSurfaceBodies] = {};
  const SurfaceBasis& rows = group.model->surface_basis();
  float* out[kSurfaceBodies] = {};
  for (std::size_t b = 0; b < batch.count; ++b) {
    CrowdBody& body = bodies[dirty_bodies[batch.first + b]];
    read_state(body, mine.q.data(), mine.p.data());
    float* mine_q = mine.q_float.data() + b * group.modes;
    scale_coordinates(rows, std::span(mine.q).first(group.modes), {mine_q, group.modes});
    q[b] = mine_q;
    out[b] = body.surface.data();
    body.dirty = false;
    body.built_at = group.steps;
    ++body.version;
  }
  write_surfaces(rows, group.modes, batch.count, q, out);
}

std::size_t Crowd::update_surfaces() {
  contents_->list_dirty();
  contents_->pool->run(contents_->batches.size(), [&](std::size_t batch, unsigned thread) {
    contents_->build(contents_->batches[batch], contents_->scratch[thread]);
  });
  return contents_->dirty_bodies.size();
}

}  // namespace tremolo
