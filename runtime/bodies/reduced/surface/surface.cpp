#include "runtime/bodies/reduced/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// Blocks of a SurfaceBasis, each array from the first of them on. One of `rows` and `pairs` is
// null. stride: columns that are stored, of which the leading `modes` are multiplied.
struct SurfaceRows {
  const float* rest;
  const float* rows;
  const std::uint32_t* pairs;
  std::size_t stride;
  std::size_t modes;
  std::size_t blocks;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/bodies/reduced/surface/surface.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {
namespace {

constexpr std::size_t kLineRows = 16;

using Sum = SurfaceWorkspace::Sum;

SurfaceRows blocks_of(const SurfaceBasis& basis, std::size_t first, std::size_t count) {
  const std::size_t column = basis.modes * first;
  return {
      .rest = basis.rest[0].value + kSurfaceBlock * first,
      .rows = basis.rows.empty() ? nullptr : basis.rows[0].value + kSurfaceBlock * column,
      .pairs = basis.pairs.empty() ? nullptr : basis.pairs[0].value + kSurfaceBlock / 2 * column,
      .stride = basis.modes,
      .modes = basis.modes,
      .blocks = count};
}

// The unit normals of all groups from those of the triangles.
void write_unit_normals(const SurfaceBasis& basis, const Sum* triangle_normals, float* out) {
  Sum sums[kSurfaceBlock];
  float factors[kSurfaceBlock];
  const std::size_t groups = basis.first_incident.size() - 1;
  for (std::size_t first = 0; first < groups; first += kSurfaceBlock) {
    const std::size_t count = std::min(kSurfaceBlock, groups - first);
    TREMOLO_CALL(gather_normals, basis.first_incident.data() + first, basis.incident.data(),
                 triangle_normals, count, sums, factors);
    Eigen::Map<Eigen::ArrayXf> inverse(factors, static_cast<Eigen::Index>(count));
    // A sum of zero stays zero.
    inverse = inverse.max(std::numeric_limits<float>::min()).rsqrt();
    const bool last = first + count == groups;
    TREMOLO_CALL(write_scaled, sums, factors, last ? count - 1 : count, out + 3 * first);
    if (!last) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[3 * (groups - 1) + axis] = factors[count - 1] * sums[count - 1].value[axis];
  }
}

const float* coordinates_of(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                            SurfaceWorkspace& workspace) {
  workspace.coordinates.assign(rows.modes, 0.0f);
  scale_coordinates(rows, {q.data(), static_cast<std::size_t>(q.size())}, workspace.coordinates);
  return workspace.coordinates.data();
}

void list_incident(const std::vector<Triangle>& triangles, std::size_t groups,
                   SurfaceBasis& basis) {
  const auto group = [&basis](VertexId corner) -> std::size_t {
    const std::size_t vertex = corner;
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

// The integers of the block in order of rows; nothing if some entry is not such a multiple.
std::vector<std::int32_t> integers_of(const BasisRows& rows, const Eigen::VectorXd& scales) {
  if (scales.size() != rows.cols() || rows.cols() == 0) return {};
  std::vector<std::int32_t> integers;
  integers.reserve(rows.size());
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    for (Eigen::Index i = 0; i < rows.cols(); ++i) {
      const double exact = rows(row, i) / scales[i];
      if (!(std::abs(exact) <= 32768.0) || std::abs(exact - std::nearbyint(exact)) > 1e-9)
        return {};
      integers.push_back(static_cast<std::int32_t>(std::lround(exact)));
    }
  return integers;
}

// Columns of U followed by those of the response, with the scales of both: the response's integers
// use all 16 bits. Nothing is scaled if U is not.
struct ShownColumns {
  BasisRows rows;
  Eigen::VectorXd scales;
};

ShownColumns with_response(const BasisRows& basis, const Eigen::VectorXd& scales,
                           const BasisRows& response) {
  const Eigen::Index r = basis.cols();
  ShownColumns shown{BasisRows(basis.rows(), r + response.cols()), {}};
  shown.rows << basis, response;
  if (scales.size() != r) return shown;
  shown.scales.resize(shown.rows.cols());
  shown.scales.head(r) = scales;
  for (Eigen::Index i = r; i < shown.rows.cols(); ++i) {
    auto column = shown.rows.col(i);
    const double largest = column.cwiseAbs().maxCoeff();
    shown.scales[i] = largest > 0.0 ? largest / 32767.0 : 1.0;
    column = (column / shown.scales[i]).array().round() * shown.scales[i];
  }
  return shown;
}

// All but the triangles.
SurfaceBasis arrange(const std::vector<Eigen::Vector3d>& rest, const BasisRows& basis,
                     const Eigen::VectorXd& column_scales) {
  SurfaceBasis rows;
  rows.vertices = rest.size();
  rows.modes = static_cast<std::size_t>(basis.cols());
  const std::size_t count = 3 * rows.vertices;
  const std::size_t blocks = (count + kSurfaceBlock - 1) / kSurfaceBlock;
  rows.rest.resize(4 * blocks);
  for (std::size_t row = 0; row < count; ++row)
    rows.rest[row / kLineRows].value[row % kLineRows] = static_cast<float>(rest[row / 3][row % 3]);
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
      const std::size_t column = row / kSurfaceBlock * rows.modes + i;
      const std::size_t line = row % kSurfaceBlock / kLineRows;
      if (integers.empty()) {
        rows.rows[4 * column + line].value[row % kLineRows] =
            static_cast<float>(basis(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(i)));
      } else {
        const auto half = static_cast<std::uint32_t>(integers[row * rows.modes + i]) & 0xffffu;
        rows.pairs[2 * column + line / 2].value[row % kLineRows] |= half << (16 * (line % 2));
      }
    }
  return rows;
}

SurfaceBasis arrange_shown(const std::vector<Eigen::Vector3d>& rest, const BasisRows& basis,
                           const Eigen::VectorXd& scales, const BasisRows& response) {
  if (response.cols() == 0) return arrange(rest, basis, scales);
  const ShownColumns shown = with_response(basis, scales, response);
  return arrange(rest, shown.rows, shown.scales);
}

}  // namespace

SurfaceBasis make_surface_basis(const VertexBlock& surface, const std::vector<Triangle>& triangles,
                                const BasisRows& response) {
  SurfaceBasis rows = arrange_shown(surface.rest, surface.rows, surface.column_scales, response);
  list_incident(triangles, rows.vertices, rows);
  return rows;
}

SurfaceBasis make_surface_basis(const RenderBlock& render, const BasisRows& response) {
  SurfaceBasis rows =
      arrange_shown(render.surface.vertices, render.rows, render.column_scales, response);
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
  if (rows.blocks() == 0) return;
  SurfaceRows all = blocks_of(rows, 0, rows.blocks());
  all.modes = modes;
  TREMOLO_CALL(write_positions, all, count, coordinates, out);
}

void surface_positions(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                       SurfaceWorkspace& workspace, std::span<float> positions) {
  if (rows.blocks() == 0) return;
  const float* coordinates = coordinates_of(rows, q, workspace);
  float* to = positions.data();
  const std::size_t whole = positions.size() / kSurfaceBlock;
  TREMOLO_CALL(write_positions, blocks_of(rows, 0, whole), 1, &coordinates, &to);
  if (whole == rows.blocks()) return;
  float last[kSurfaceBlock];
  float* rest = last;
  TREMOLO_CALL(write_positions, blocks_of(rows, whole, 1), 1, &coordinates, &rest);
  std::copy_n(last, positions.size() - kSurfaceBlock * whole, to + kSurfaceBlock * whole);
}

void surface_with_normals(const SurfaceBasis& rows, const std::vector<Triangle>& triangles,
                          const Eigen::VectorXd& q, SurfaceWorkspace& workspace,
                          std::span<float> positions, std::span<float> normals) {
  if (rows.blocks() == 0) return;
  const float* coordinates = coordinates_of(rows, q, workspace);
  workspace.positions.resize(kSurfaceBlock * rows.blocks() + 1);
  float* to = workspace.positions.data();
  write_surfaces(rows, rows.modes, 1, &coordinates, &to);
  std::copy_n(workspace.positions.data(), positions.size(), positions.data());
  workspace.triangle_normals.resize(triangles.size());
  TREMOLO_CALL(write_triangle_normals, triangles.data(), triangles.size(),
               workspace.positions.data(), workspace.triangle_normals.data());
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
