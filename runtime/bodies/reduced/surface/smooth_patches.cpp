#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "runtime/bodies/reduced/surface/surface.h"

namespace tremolo {
namespace {

// The common properties of vertices of one group.
struct Key {
  std::array<double, 3> place{};
  std::array<std::int32_t, 3> kind{};  // of the normal, or {object, 0, 0}

  friend bool operator<(const Key& a, const Key& b) {
    return std::tie(a.place, a.kind) < std::tie(b.place, b.kind);
  }
};

std::vector<Key> make_keys(const RenderSurface& surface) {
  std::vector<Key> keys(surface.vertices.size());
  for (std::size_t v = 0; v < keys.size(); ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      keys[v].place[axis] = surface.vertices[v][axis];
      if (!surface.normals.empty())
        keys[v].kind[axis] = static_cast<std::int32_t>(
            std::lround(1000.0f * std::clamp(surface.normals[v][axis], -1.0f, 1.0f)));
    }
  if (!surface.normals.empty()) return keys;
  for (std::size_t t = surface.triangles.size(); t-- > 0;)
    for (const VertexId corner : surface.triangles[t])
      keys[corner].kind[0] = static_cast<std::int32_t>(surface.object_of[t]);
  return keys;
}

}  // namespace

SmoothPatches find_smooth_patches(const RenderSurface& surface) {
  const std::vector<Key> keys = make_keys(surface);
  std::vector<std::uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&keys](std::uint32_t a, std::uint32_t b) {
    if (keys[a] < keys[b]) return true;
    return !(keys[b] < keys[a]) && a < b;
  });
  // Groups are numbered by their first vertex, so that neighbours in memory stay neighbours.
  std::vector<std::uint32_t> first(keys.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && !(keys[order[i - 1]] < keys[order[i]]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  SmoothPatches patches;
  patches.group_of.resize(keys.size());
  for (std::size_t v = 0; v < keys.size(); ++v)
    patches.group_of[v] =
        first[v] == v ? static_cast<std::uint32_t>(patches.count++) : patches.group_of[first[v]];
  return patches;
}

}  // namespace tremolo
