#include "runtime/surface_rows.h"

#include "runtime/clones.h"

namespace tremolo {
namespace {

typedef float Vector __attribute__((vector_size(64), may_alias));
constexpr std::size_t kVectors = kSurfaceTile / 16;

template <std::size_t kBodies>
[[gnu::always_inline]] inline void write_tiles(const SurfaceRows& rows, const float* const* q,
                                               SurfaceTile* const* out) {
  const SurfaceTile* at = rows.values.data();
  for (std::size_t tile = 0; tile < rows.tiles; ++tile) {
    const Vector* rest = reinterpret_cast<const Vector*>(at++);
    Vector sums[kBodies][kVectors] = {};
    for (std::size_t i = 0; i < rows.modes; ++i, ++at) {
      const Vector* column = reinterpret_cast<const Vector*>(at);
      for (std::size_t b = 0; b < kBodies; ++b)
        for (std::size_t v = 0; v < kVectors; ++v) sums[b][v] += column[v] * q[b][i];
    }
    for (std::size_t b = 0; b < kBodies; ++b)
      for (std::size_t v = 0; v < kVectors; ++v)
        reinterpret_cast<Vector*>(out[b] + tile)[v] = rest[v] + sums[b][v];
  }
}

TREMOLO_CLONES void write_one(const SurfaceRows& rows, const float* const* q,
                              SurfaceTile* const* out) {
  write_tiles<1>(rows, q, out);
}
TREMOLO_CLONES void write_four(const SurfaceRows& rows, const float* const* q,
                               SurfaceTile* const* out) {
  write_tiles<kSurfaceBodies>(rows, q, out);
}

}  // namespace

SurfaceRows make_surface_rows(const Model& model, std::size_t modes) {
  const VertexBlock& surface = model.surface();
  const std::size_t count = 3 * surface.vertex_ids.size();
  SurfaceRows rows;
  rows.modes = modes;
  rows.tiles = (count + kSurfaceTile - 1) / kSurfaceTile;
  rows.values.resize(rows.tiles * (modes + 1));
  for (std::size_t at = 0; at < count; ++at) {
    SurfaceTile* tile = &rows.values[at / kSurfaceTile * (modes + 1)];
    const std::size_t place = at % kSurfaceTile;
    const auto axis = static_cast<Eigen::Index>(at % 3);
    tile[0].value[place] = static_cast<float>(surface.rest[at / 3][axis]);
    for (std::size_t i = 0; i < modes; ++i)
      tile[i + 1].value[place] = static_cast<float>(
          surface.rows(static_cast<Eigen::Index>(at), static_cast<Eigen::Index>(i)));
  }
  return rows;
}

void write_surfaces(const SurfaceRows& rows, std::size_t count, const float* const* q,
                    SurfaceTile* const* out) {
  if (count == kSurfaceBodies) {
    write_four(rows, q, out);
    return;
  }
  for (std::size_t b = 0; b < count; ++b) write_one(rows, q + b, out + b);
}

}  // namespace tremolo
