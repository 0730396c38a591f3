// World: where the surfaces of the bodies that are shown are.
#include <algorithm>

#include "runtime/crowd/world_contents.h"

namespace tremolo {

void World::Contents::touch(BodyId id) {
  WorldBody& body = bodies[id];
  if (!body.shown || body.touched) return;
  body.touched = true;
  groups[body.group].touched.push_back(id);
}

void World::Contents::show(BodyId id, bool shown) {
  WorldBody& body = bodies[id];
  if (body.shown == shown) return;
  WorldGroup& group = groups[body.group];
  if (!shown) {
    std::erase(group.touched, id);
    body.touched = body.shown = false;
    body.surface = {};
    --group.shown;
    return;
  }
  body.surface.resize(kSurfaceBlock * group.model->surface_basis().blocks());
  body.shown = true;
  ++group.shown;
  // Room for what update_surfaces() lists, so that it allocates nothing.
  std::size_t all = 0;
  for (const WorldGroup& each : groups) all += each.shown;
  stale.reserve(all);
  batches.reserve(all / kSurfaceBodies + groups.size());
  group.touched.reserve(group.shown);
  touch(id);
}

// The bodies to rebuild, by groups, cut into batches.
void World::Contents::list_stale() {
  stale.clear();
  batches.clear();
  for (GroupId g = 0; g < groups.size(); ++g) {
    WorldGroup& group = groups[g];
    if (group.shown == 0) continue;
    const std::size_t begin = stale.size();
    stale.insert(stale.end(), group.touched.begin(), group.touched.end());
    group.touched.clear();
    for (const BodyId id : group.awake) {
      const WorldBody& body = bodies[id];
      if (body.shown && !body.touched && body.built_at < group.steps) stale.push_back(id);
    }
    for (std::size_t at = begin; at < stale.size(); at += kSurfaceBodies)
      batches.push_back({g, at, std::min(kSurfaceBodies, stale.size() - at)});
  }
}

void World::Contents::build(const SurfaceBatch& batch, WorldScratch& mine) {
  const WorldGroup& group = groups[batch.group];
  const float* q[kSurfaceBodies] = {};
  const SurfaceBasis& rows = group.model->surface_basis();
  float* out[kSurfaceBodies] = {};
  for (std::size_t b = 0; b < batch.count; ++b) {
    WorldBody& body = bodies[stale[batch.first + b]];
    read_state(body, mine.q.data(), mine.p.data());
    float* mine_q = mine.q_float.data() + b * group.modes;
    scale_coordinates(rows, std::span(mine.q).first(group.modes), {mine_q, group.modes});
    q[b] = mine_q;
    out[b] = body.surface.data();
    body.touched = false;
    body.built_at = group.steps;
    ++body.version;
  }
  write_surfaces(rows, group.modes, batch.count, q, out);
}

std::size_t World::update_surfaces() {
  contents_->list_stale();
  contents_->pool->run(contents_->batches.size(), [&](std::size_t batch, unsigned thread) {
    contents_->build(contents_->batches[batch], contents_->scratch[thread]);
  });
  return contents_->stale.size();
}

}  // namespace tremolo
