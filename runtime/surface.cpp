#include "runtime/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/clones.h"

namespace tremolo {
namespace {

constexpr std::size_t kLane = 16;   // rows a line
constexpr std::size_t kBlock = 64;  // rows a block

// Name these types where they are used: `auto` forgets their alignment and aliasing.
typedef float Floats __attribute__((vector_size(64), may_alias));
typedef float LooseFloats __attribute__((vector_size(64), aligned(4), may_alias));
typedef std::int32_t Integers __attribute__((vector_size(64), may_alias));
typedef float Four __attribute__((vector_size(16), may_alias));
typedef float LooseFour __attribute__((vector_size(16), aligned(4), may_alias));

using FloatLine = SurfaceBasis::FloatLine;
using PairLine = SurfaceBasis::PairLine;
using Sum = SurfaceWorkspace::Sum;

// out: whole blocks.
TREMOLO_CLONES
void multiply_floats(const FloatLine* __restrict rows, const FloatLine* __restrict rest,
                     const float* __restrict q, std::size_t blocks, std::size_t modes,
                     float* __restrict out) {
  const Floats* u = reinterpret_cast<const Floats*>(rows);
  const Floats* x = reinterpret_cast<const Floats*>(rest);
  for (std::size_t block = 0; block < blocks; ++block, x += 4) {
    Floats x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
    for (std::size_t i = 0; i < modes; ++i, u += 4) {
      const float qi = q[i];
      x0 += u[0] * qi;
      x1 += u[1] * qi;
      x2 += u[2] * qi;
      x3 += u[3] * qi;
    }
    LooseFloats* to = reinterpret_cast<LooseFloats*>(out + kBlock * block);
    to[0] = x0;
    to[1] = x1;
    to[2] = x2;
    to[3] = x3;
  }
}

// The two halves of a lane become floats as integers times 2^16: exact, and cheaper than widening.
TREMOLO_CLONES
void multiply_pairs(const PairLine* __restrict pairs, const FloatLine* __restrict rest,
                    const float* __restrict q, std::size_t blocks, std::size_t modes,
                    float* __restrict out) {
  constexpr auto kHigh = static_cast<std::int32_t>(0xffff0000u);
  const Integers* u = reinterpret_cast<const Integers*>(pairs);
  const Floats* x = reinterpret_cast<const Floats*>(rest);
  for (std::size_t block = 0; block < blocks; ++block, x += 4) {
    Floats x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3];
    for (std::size_t i = 0; i < modes; ++i, u += 2) {
      const float qi = q[i];
      x0 += __builtin_convertvector(u[0] << 16, Floats) * qi;
      x1 += __builtin_convertvector(u[0] & kHigh, Floats) * qi;
      x2 += __builtin_convertvector(u[1] << 16, Floats) * qi;
      x3 += __builtin_convertvector(u[1] & kHigh, Floats) * qi;
    }
    LooseFloats* to = reinterpret_cast<LooseFloats*>(out + kBlock * block);
    to[0] = x0;
    to[1] = x1;
    to[2] = x2;
    to[3] = x3;
  }
}

void multiply(const SurfaceBasis& rows, std::size_t first, std::size_t blocks, const float* q,
              float* out) {
  const FloatLine* rest = rows.rest.data() + 4 * first;
  if (rows.pairs.empty())
    multiply_floats(rows.rows.data() + 4 * rows.modes * first, rest, q, blocks, rows.modes, out);
  else
    multiply_pairs(rows.pairs.data() + 2 * rows.modes * first, rest, q, blocks, rows.modes, out);
}

// sums: z, x, y of each vertex's normal; the fourth number means nothing. positions: readable for
// one number behind the last vertex.
TREMOLO_CLONES
void add_triangle_normals(const Triangle* triangles, std::size_t count,
                          const float* __restrict positions, Sum* __restrict sums) {
  const auto at = [positions](VertexId vertex) -> Four {
    return *reinterpret_cast<const LooseFour*>(positions + 3 * static_cast<std::size_t>(vertex));
  };
  for (std::size_t t = 0; t < count; ++t) {
    const auto [a, b, c] = triangles[t];
    const Four origin = at(a);
    const Four e = at(b) - origin;
    const Four f = at(c) - origin;
    const Four normal = e * __builtin_shufflevector(f, f, 1, 2, 0, 3) -
                        __builtin_shufflevector(e, e, 1, 2, 0, 3) * f;
    reinterpret_cast<Four&>(sums[a]) += normal;
    reinterpret_cast<Four&>(sums[b]) += normal;
    reinterpret_cast<Four&>(sums[c]) += normal;
  }
}

// At most kBlock vertices.
void write_unit_normals(const Sum* sums, std::size_t count, float* out) {
  float factor[kBlock];
  for (std::size_t v = 0; v < count; ++v) {
    const auto& [z, x, y, unused] = sums[v].value;
    factor[v] = x * x + y * y + z * z;
  }
  Eigen::Map<Eigen::ArrayXf> inverse(factor, static_cast<Eigen::Index>(count));
  inverse = (inverse > std::numeric_limits<float>::min()).select(inverse.rsqrt(), 0.0f);
  for (std::size_t v = 0; v < count; ++v) {
    const auto& [z, x, y, unused] = sums[v].value;
    out[3 * v] = factor[v] * x;
    out[3 * v + 1] = factor[v] * y;
    out[3 * v + 2] = factor[v] * z;
  }
}

const float* scaled_coordinates(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                                SurfaceWorkspace& workspace) {
  workspace.coordinates.resize(rows.modes);
  for (std::size_t i = 0; i < rows.modes; ++i)
    workspace.coordinates[i] = static_cast<float>(rows.scales[i] * q[static_cast<Eigen::Index>(i)]);
  return workspace.coordinates.data();
}

// The integers of the block in order of rows, or nothing if some entry is no such multiple.
std::vector<std::int32_t> integers_of(const VertexBlock& surface) {
  if (surface.column_scales.size() != surface.rows.cols() || surface.rows.cols() == 0) return {};
  std::vector<std::int32_t> integers;
  integers.reserve(static_cast<std::size_t>(surface.rows.size()));
  for (Eigen::Index row = 0; row < surface.rows.rows(); ++row)
    for (Eigen::Index i = 0; i < surface.rows.cols(); ++i) {
      const double exact = surface.rows(row, i) / surface.column_scales[i];
      if (!(std::abs(exact) <= 32768.0) || std::abs(exact - std::nearbyint(exact)) > 1e-9)
        return {};
      integers.push_back(static_cast<std::int32_t>(std::lround(exact)));
    }
  return integers;
}

}  // namespace

SurfaceBasis make_surface_basis(const VertexBlock& surface) {
  SurfaceBasis rows;
  rows.vertices = surface.vertex_ids.size();
  rows.modes = static_cast<std::size_t>(surface.rows.cols());
  const std::size_t count = 3 * rows.vertices;
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  rows.rest.resize(4 * blocks);
  for (std::size_t row = 0; row < count; ++row)
    rows.rest[row / kLane].value[row % kLane] =
        static_cast<float>(surface.rest[row / 3][static_cast<Eigen::Index>(row % 3)]);
  const std::vector<std::int32_t> integers = integers_of(surface);
  if (integers.empty()) {
    rows.scales.assign(rows.modes, 1.0);
    rows.rows.resize(4 * blocks * rows.modes);
  } else {
    for (const double scale : surface.column_scales) rows.scales.push_back(scale / 65536.0);
    rows.pairs.resize(2 * blocks * rows.modes);
  }
  for (std::size_t row = 0; row < count; ++row)
    for (std::size_t i = 0; i < rows.modes; ++i) {
      const std::size_t column = row / kBlock * rows.modes + i;
      const std::size_t line = row % kBlock / kLane;
      if (integers.empty()) {
        rows.rows[4 * column + line].value[row % kLane] = static_cast<float>(
            surface.rows(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(i)));
      } else {
        const auto half = static_cast<std::uint32_t>(integers[row * rows.modes + i]) & 0xffffu;
        rows.pairs[2 * column + line / 2].value[row % kLane] |= half << (16 * (line % 2));
      }
    }
  return rows;
}

void surface_positions(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                       SurfaceWorkspace& workspace, std::span<float> positions) {
  const float* coordinates = scaled_coordinates(rows, q, workspace);
  const std::size_t whole = positions.size() / kBlock;
  multiply(rows, 0, whole, coordinates, positions.data());
  if (whole == rows.blocks()) return;
  float last[kBlock];
  multiply(rows, whole, 1, coordinates, last);
  std::copy_n(last, positions.size() - kBlock * whole, positions.data() + kBlock * whole);
}

void surface_with_normals(const SurfaceBasis& rows, const std::vector<Triangle>& triangles,
                          const Eigen::VectorXd& q, SurfaceWorkspace& workspace,
                          std::span<float> positions, std::span<float> normals) {
  const float* coordinates = scaled_coordinates(rows, q, workspace);
  workspace.positions.resize(kBlock * rows.blocks() + 1);
  multiply(rows, 0, rows.blocks(), coordinates, workspace.positions.data());
  std::copy_n(workspace.positions.data(), positions.size(), positions.data());
  workspace.sums.assign(rows.vertices, Sum{});
  add_triangle_normals(triangles.data(), triangles.size(), workspace.positions.data(),
                       workspace.sums.data());
  for (std::size_t first = 0; first < rows.vertices; first += kBlock)
    write_unit_normals(workspace.sums.data() + first, std::min(kBlock, rows.vertices - first),
                       normals.data() + 3 * first);
}

}  // namespace tremolo
