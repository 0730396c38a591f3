// The sections of a file of corotated tetrahedra, version 1.0. docs/tets-format.md is the same in
// prose; change both or neither.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "formats/sections/section_layout.h"
#include "formats/tets/tets_file.h"

namespace tremolo::tets_layout {

using namespace section_layout;

inline constexpr std::uint16_t kMajor = 1;
inline constexpr std::uint16_t kMinor = 0;
inline constexpr FileKind kKind = {
    {'T', 'R', 'E', 'M', 'T', 'E', 'T', 'S'}, kMajor, "a file of tetrahedra"};

inline constexpr std::string_view kCounts = "counts";                   // u64, kCountsSize x 1
inline constexpr std::string_view kVertices = "vertices";               // f64, n x 3, m
inline constexpr std::string_view kTetrahedra = "tetrahedra";           // u32, m x 4
inline constexpr std::string_view kMaterials = "materials";             // f64, k x kMaterialSize
inline constexpr std::string_view kMaterialOf = "material_of";          // u32, m x 1
inline constexpr std::string_view kHeld = "held";                       // u32, h x 1, ascending
inline constexpr std::string_view kDrawnVertices = "drawn_vertices";    // f64, s x 3, m
inline constexpr std::string_view kDrawnTriangles = "drawn_triangles";  // u32, t x 3
inline constexpr std::string_view kDrawnTetrahedra = "drawn_tets";      // u32, s x 1
inline constexpr std::string_view kDrawnWeights = "drawn_weights";      // f64, s x 4
inline constexpr std::string_view kDrawnUvs = "drawn_uvs";              // f32, s x 2
// Optional: u32, s x 1, the vertex of the author's file that each is or is a copy of.
inline constexpr std::string_view kDrawnSources = "drawn_sources";
inline constexpr std::string_view kGridFrame = "grid_frame";   // f64, 4 x 1
inline constexpr std::string_view kDistances = "distances";    // f32, one a node, m
inline constexpr std::string_view kProvenance = "provenance";  // u8, JSON

// n, m, k, h, s, t, and the nodes of the grid along x, y, z (0: none).
inline constexpr std::size_t kCountsSize = 9;
// young, poisson, density; 1 if orthotropic, else 0; E1..E3, nu12, nu23, nu31, G12, G23, G31, the
// axes column by column.
inline constexpr std::size_t kMaterialSize = 22;
inline constexpr std::size_t kGridFrameSize = 4;

}  // namespace tremolo::tets_layout

namespace tremolo {

// An error in the file, and the section that has it.
struct TetsFault {
  std::string_view section;
  std::string problem;
};

// Everything but the grid, which DistanceGrid::create() checks. Nothing: all is well.
std::optional<TetsFault> find_tets_fault(const TetMesh& mesh, const MaterialTable& materials,
                                         std::span<const VertexId> held,
                                         const TetsSurface& surface);

}  // namespace tremolo
