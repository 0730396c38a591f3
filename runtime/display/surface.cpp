#include "runtime/display/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "runtime/display/smooth_patches.h"
#include "runtime/kernels/clones.h"
#include "runtime/kernels/lanes.h"

#define TREMOLO_KERNEL "runtime/display/surface.inc"
#include "runtime/kernels/every_machine.inc"

namespace tremolo {
namespace {

constexpr std::size_t kLane = 16;              // rows a line
constexpr std::size_t kBlock = kSurfaceBlock;  // rows

// Name these types where they are used: `auto` forgets their alignment and aliasing.
typedef float Four __attribute__((vector_size(16), may_alias));
typedef float LooseFour __attribute__((vector_size(16), aligned(4), may_alias));

using Sum = SurfaceWorkspace::Sum;

// Positions of `count` bodies on the blocks [first, first + blocks): out[b] begins with the first
// of them. q[b]: scaled coordinates of the leading `modes`.
void multiply(const SurfaceBasis& rows, std::size_t first, std::size_t blocks, std::size_t modes,
              std::size_t count, const float* const* q, float* const* out) {
  const float* rest = rows.rest[0].value + kBlock * first;
  if (rows.pairs.empty())
    (*TREMOLO_BEST(multiply_floats))(rows.rows[0].value + kBlock * rows.modes * first, rest,
                                     rows.modes, modes, blocks, count, q, out);
  else
    (*TREMOLO_BEST(multiply_pairs))(rows.pairs[0].value + kBlock / 2 * rows.modes * first, rest,
                                    rows.modes, modes, blocks, count, q, out);
}

// normals: z, x, y of each triangle's (b - a) x (c - a); the fourth number means nothing.
// positions: readable for one number behind the last vertex.
TREMOLO_CLONES
void write_triangle_normals(const Triangle* triangles, std::size_t count,
                            const float* __restrict positions, Sum* __restrict normals) {
  const auto at = [positions](VertexId vertex) -> Four {
    return *reinterpret_cast<const LooseFour*>(positions + 3 * static_cast<std::size_t>(vertex));
  };
  for (std::size_t t = 0; t < count; ++t) {
    const Triangle& corner = triangles[t];
    const Four origin = at(corner[0]);
    const Four e = at(corner[1]) - origin;
    const Four f = at(corner[2]) - origin;
    reinterpret_cast<Four&>(normals[t]) = e * __builtin_shufflevector(f, f, 1, 2, 0, 3) -
                                          __builtin_shufflevector(e, e, 1, 2, 0, 3) * f;
  }
}

// Sums over the triangles at each of `count` vertices and their squared lengths: reading each
// normal three times is cheaper than adding it to three vertices in memory.
TREMOLO_CLONES
void gather_normals(const std::uint32_t* first, const std::uint32_t* incident,
                    const Sum* __restrict normals, std::size_t count, Sum* __restrict sums,
                    float* __restrict squared) {
  for (std::size_t v = 0; v < count; ++v) {
    Four sum = {};
    for (std::size_t i = first[v]; i < first[v + 1]; ++i)
      sum += reinterpret_cast<const Four&>(normals[incident[i]]);
    reinterpret_cast<Four&>(sums[v]) = __builtin_shufflevector(sum, sum, 1, 2, 0, 3);
    squared[v] = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
  }
}

// x, y, z of each sum times its factor. Four numbers a vertex are written: the fourth is the next
// one's place, and `count` must leave one vertex behind.
TREMOLO_CLONES
void write_scaled(const Sum* __restrict sums, const float* __restrict factors, std::size_t count,
                  float* __restrict out) {
  for (std::size_t v = 0; v < count; ++v)
    *reinterpret_cast<LooseFour*>(out + 3 * v) =
        reinterpret_cast<const Four&>(sums[v]) * factors[v];
}

// The unit normals of all groups from those of the triangles.
void write_unit_normals(const SurfaceBasis& basis, const Sum* triangle_normals, float* out) {
  Sum sums[kBlock];
  float factors[kBlock];
  const std::size_t groups = basis.first_incident.size() - 1;
  for (std::size_t first = 0; first < groups; first += kBlock) {
    const std::size_t count = std::min(kBlock, groups - first);
    gather_normals(basis.first_incident.data() + first, basis.incident.data(), triangle_normals,
                   count, sums, factors);
    Eigen::Map<Eigen::ArrayXf> inverse(factors, static_cast<Eigen::Index>(count));
    // A sum of zero stays zero.
    inverse = inverse.max(std::numeric_limits<float>::min()).rsqrt();
    const bool last = first + count == groups;
    write_scaled(sums, factors, last ? count - 1 : count, out + 3 * first);
    if (!last) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[3 * (groups - 1) + axis] = factors[count - 1] * sums[count - 1].value[axis];
  }
}

const float* coordinates_of(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                            SurfaceWorkspace& workspace) {
  workspace.coordinates.resize(rows.modes);
  scale_coordinates(rows, {q.data(), rows.modes}, workspace.coordinates);
  return workspace.coordinates.data();
}

void list_incident(const std::vector<Triangle>& triangles, std::size_t groups,
                   SurfaceBasis& basis) {
  const auto group = [&basis](VertexId corner) -> std::size_t {
    const auto vertex = static_cast<std::size_t>(corner);
    return basis.group_of.empty() ? vertex : basis.group_of[vertex];
  };
  basis.first_incident.assign(groups + 1, 0);
  for (const Triangle& triangle : triangles)
    for (const VertexId corner : triangle) ++basis.first_incident[group(corner) + 1];
  std::partial_sum(basis.first_incident.begin(), basis.first_incident.end(),
                   basis.first_incident.begin());
  std::vector<std::uint32_t> next = basis.first_incident;
  basis.incident.resize(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const VertexId corner : triangles[t])
      basis.incident[next[group(corner)]++] = static_cast<std::uint32_t>(t);
}

// The integers of the block in order of rows, or nothing if some entry is no such multiple.
std::vector<std::int32_t> integers_of(const BasisRows& rows, const Eigen::VectorXd& scales) {
  if (scales.size() != rows.cols() || rows.cols() == 0) return {};
  std::vector<std::int32_t> integers;
  integers.reserve(static_cast<std::size_t>(rows.size()));
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    for (Eigen::Index i = 0; i < rows.cols(); ++i) {
      const double exact = rows(row, i) / scales[i];
      if (!(std::abs(exact) <= 32768.0) || std::abs(exact - std::nearbyint(exact)) > 1e-9)
        return {};
      integers.push_back(static_cast<std::int32_t>(std::lround(exact)));
    }
  return integers;
}

// All but the triangles.
SurfaceBasis arrange(const std::vector<Eigen::Vector3d>& rest, const BasisRows& basis,
                     const Eigen::VectorXd& column_scales) {
  SurfaceBasis rows;
  rows.vertices = rest.size();
  rows.modes = static_cast<std::size_t>(basis.cols());
  const std::size_t count = 3 * rows.vertices;
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  rows.rest.resize(4 * blocks);
  for (std::size_t row = 0; row < count; ++row)
    rows.rest[row / kLane].value[row % kLane] =
        static_cast<float>(rest[row / 3][static_cast<Eigen::Index>(row % 3)]);
  const std::vector<std::int32_t> integers = integers_of(basis, column_scales);
  if (integers.empty()) {
    rows.scales.assign(rows.modes, 1.0);
    rows.rows.resize(4 * blocks * rows.modes);
  } else {
    for (const double scale : column_scales) rows.scales.push_back(scale / 65536.0);
    rows.pairs.resize(2 * blocks * rows.modes);
  }
  for (std::size_t row = 0; row < count; ++row)
    for (std::size_t i = 0; i < rows.modes; ++i) {
      const std::size_t column = row / kBlock * rows.modes + i;
      const std::size_t line = row % kBlock / kLane;
      if (integers.empty()) {
        rows.rows[4 * column + line].value[row % kLane] =
            static_cast<float>(basis(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(i)));
      } else {
        const auto half = static_cast<std::uint32_t>(integers[row * rows.modes + i]) & 0xffffu;
        rows.pairs[2 * column + line / 2].value[row % kLane] |= half << (16 * (line % 2));
      }
    }
  return rows;
}

}  // namespace

SurfaceBasis make_surface_basis(const VertexBlock& surface,
                                const std::vector<Triangle>& triangles) {
  SurfaceBasis rows = arrange(surface.rest, surface.rows, surface.column_scales);
  list_incident(triangles, rows.vertices, rows);
  return rows;
}

SurfaceBasis make_surface_basis(const RenderBlock& render) {
  SurfaceBasis rows = arrange(render.surface.vertices, render.rows, render.column_scales);
  SmoothPatches patches = find_smooth_patches(render.surface);
  if (patches.count < rows.vertices) rows.group_of = std::move(patches.group_of);
  list_incident(render.surface.triangles, patches.count, rows);
  return rows;
}

void scale_coordinates(const SurfaceBasis& rows, std::span<const double> q,
                       std::span<float> coordinates) {
  for (std::size_t i = 0; i < q.size(); ++i)
    coordinates[i] = static_cast<float>(rows.scales[i] * q[i]);
}

void write_surfaces(const SurfaceBasis& rows, std::size_t modes, std::size_t count,
                    const float* const* coordinates, float* const* out) {
  if (rows.blocks() > 0) multiply(rows, 0, rows.blocks(), modes, count, coordinates, out);
}

void surface_positions(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                       SurfaceWorkspace& workspace, std::span<float> positions) {
  if (rows.blocks() == 0) return;
  const float* coordinates = coordinates_of(rows, q, workspace);
  float* to = positions.data();
  const std::size_t whole = positions.size() / kBlock;
  multiply(rows, 0, whole, rows.modes, 1, &coordinates, &to);
  if (whole == rows.blocks()) return;
  float last[kBlock];
  float* rest = last;
  multiply(rows, whole, 1, rows.modes, 1, &coordinates, &rest);
  std::copy_n(last, positions.size() - kBlock * whole, to + kBlock * whole);
}

void surface_with_normals(const SurfaceBasis& rows, const std::vector<Triangle>& triangles,
                          const Eigen::VectorXd& q, SurfaceWorkspace& workspace,
                          std::span<float> positions, std::span<float> normals) {
  if (rows.blocks() == 0) return;
  const float* coordinates = coordinates_of(rows, q, workspace);
  workspace.positions.resize(kBlock * rows.blocks() + 1);
  float* to = workspace.positions.data();
  write_surfaces(rows, rows.modes, 1, &coordinates, &to);
  std::copy_n(workspace.positions.data(), positions.size(), positions.data());
  workspace.triangle_normals.resize(triangles.size());
  write_triangle_normals(triangles.data(), triangles.size(), workspace.positions.data(),
                         workspace.triangle_normals.data());
  if (rows.group_of.empty()) {
    write_unit_normals(rows, workspace.triangle_normals.data(), normals.data());
    return;
  }
  workspace.group_normals.resize(3 * (rows.first_incident.size() - 1));
  write_unit_normals(rows, workspace.triangle_normals.data(), workspace.group_normals.data());
  for (std::size_t v = 0; v < rows.vertices; ++v)
    std::copy_n(workspace.group_normals.data() + 3 * std::size_t{rows.group_of[v]}, 3,
                normals.data() + 3 * v);
}

}  // namespace tremolo
