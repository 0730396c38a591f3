// X + U q of a model's surface for several bodies at once, in float.
#pragma once

#include <cstddef>
#include <vector>

#include "runtime/model.h"

namespace tremolo {

// Rows a tile; a surface's buffer is a whole number of tiles long.
inline constexpr std::size_t kSurfaceTile = 64;
// Bodies that are written together: a tile of U is then read once for all of them.
inline constexpr std::size_t kSurfaceBodies = 4;

struct alignas(64) SurfaceTile {
  float value[kSurfaceTile];
};

// X and the leading `modes` columns of U in tiles of 64 rows: [tile][X, U_0, U_1, ...][row]. Rows
// behind the last one are zero.
struct SurfaceRows {
  std::size_t modes = 0;
  std::size_t tiles = 0;
  std::vector<SurfaceTile> values;  // tiles x (modes + 1)
};

SurfaceRows make_surface_rows(const Model& model, std::size_t modes);

// out[b][tile] = X + U q for `count` <= kSurfaceBodies bodies. q[b]: modes long. The displacement
// is summed first and then added to X, so its rounding is relative to itself; the position's last
// rounding is 6e-8 |X|. A body's result does not depend on which others are written with it.
// Nothing is allocated.
void write_surfaces(const SurfaceRows& rows, std::size_t count, const float* const* q,
                    SurfaceTile* const* out);

}  // namespace tremolo
