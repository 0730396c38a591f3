// u = U q for display: positions and normals of a solid's surface, in float.
//
//     x = X + sum_i q_i U_i        the rows of U are read once: 4 * 3s * r bytes are the cost, or
//                                  half of them where the file's rows are 16-bit integers
//
// If a model keeps its response to forces at p points, the 3p columns of W follow those of U, and
// the forces follow q.
//
//     n_v = sum over the triangles at v of (b - a) x (c - a), normalised
//
// so each triangle is weighted by its area; the normal points outwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

inline constexpr std::size_t kSurfaceBlock = 64;  // rows
// Bodies that write_surfaces() takes together: a block of U is then read once for all of them.
inline constexpr std::size_t kSurfaceBodies = 4;

// Rows of the surface in blocks of 64 (x, y, z of a vertex are three rows; the last block is padded
// with zeros). Column by column within a block, so that 64 sums are kept in registers while the
// block streams by.
struct SurfaceBasis {
  struct alignas(64) FloatLine {
    float value[16];
  };
  // Lane j: row j in the low half, row 16 + j in the high one, two's complement.
  struct alignas(64) PairLine {
    std::uint32_t value[16];
  };

  std::size_t vertices = 0;
  std::size_t modes = 0;        // columns: r + 3p
  std::vector<FloatLine> rest;  // 4 lines a block, m
  std::vector<FloatLine> rows;  // 4 lines a block and column, kg^-1/2; empty if `pairs` is not
  std::vector<PairLine> pairs;  // 2 lines a block and column: 16-bit integers
  std::vector<double> scales;   // r + 3p: factors of the coordinates before the product

  // Vertices that share a normal, g groups: s indices, or none if each has its own and g is s.
  std::vector<std::uint32_t> group_of;
  // The triangles at group v: incident[first_incident[v] .. first_incident[v + 1]).
  std::vector<std::uint32_t> first_incident;  // g + 1
  std::vector<std::uint32_t> incident;        // 3t

  std::size_t blocks() const { return rest.size() / 4; }
  std::size_t bytes() const {
    return 64 * (rest.size() + rows.size() + pairs.size()) +
           4 * (group_of.size() + first_incident.size() + incident.size());
  }
};

// Rows become 16-bit integers if the block has column scales and all entries are such multiples of
// them, which is exact; else floats. triangles: indices below s. response: 3s x 3p, or without
// columns; if U's rows are integers its columns become 16-bit integers too, with an error of 2^-16
// of their largest entry.
SurfaceBasis make_surface_basis(const VertexBlock& surface, const std::vector<Triangle>& triangles,
                                const BasisRows& response = {});
// The same for a render surface. Vertices at one position in one smooth patch share a normal: no
// seam is visible where texture coordinates split them.
SurfaceBasis make_surface_basis(const RenderBlock& render, const BasisRows& response = {});

// Scratch of one caller; grows at the first call that needs it.
struct SurfaceWorkspace {
  struct alignas(16) Sum {
    float value[4];
  };
  std::vector<float> coordinates;     // r
  std::vector<float> positions;       // padded to whole blocks and one number more
  std::vector<Sum> triangle_normals;  // t
  std::vector<float> group_normals;   // 3g, if vertices share normals
};

// coordinates_i = scales_i q_i for the leading q.size(): the input of write_surfaces().
void scale_coordinates(const SurfaceBasis& rows, std::span<const double> q,
                       std::span<float> coordinates);

// X + U q of `count` <= kSurfaceBodies bodies with the leading `modes` coordinates, the others
// zero. out[b]: whole blocks, kSurfaceBlock * blocks() numbers. A body's result does not depend on
// which others are written with it. Nothing is allocated.
void write_surfaces(const SurfaceBasis& rows, std::size_t modes, std::size_t count,
                    const float* const* coordinates, float* const* out);

// positions: 3s, x y z x y z ..., m; q: r or r + 3p, others are zero. The error is that of float
// sums: below (r + 2) 2^-24 (|X| + sum_i |q_i U_i|) in a component, about 1e-6 of the size in
// practice.
void surface_positions(const SurfaceBasis& rows, const Eigen::VectorXd& q,
                       SurfaceWorkspace& workspace, std::span<float> positions);

// The same, with the unit normals of those positions, 3s. triangles: those of the basis. A vertex
// whose triangles have no area or cancel gets a zero normal (below 1e-19 m^2 a short one).
void surface_with_normals(const SurfaceBasis& rows, const std::vector<Triangle>& triangles,
                          const Eigen::VectorXd& q, SurfaceWorkspace& workspace,
                          std::span<float> positions, std::span<float> normals);

// group_of: s, below count. Every group has a vertex.
struct SmoothPatches {
  std::vector<std::uint32_t> group_of;
  std::size_t count = 0;
};

// Vertices are split where texture coordinates, materials or normals are. Vertices at exactly the
// same position whose rest normals agree to a thousandth belong to one patch: the author shades
// across them. Without rest normals, vertices at the same position whose first triangles are of one
// object do.
SmoothPatches find_smooth_patches(const RenderSurface& surface);

}  // namespace tremolo
