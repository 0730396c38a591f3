// Which sections a basis file has, of which type and shape: the reader checks a file by this table,
// the writer writes by it, and docs/basis-format.md is the same in prose.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "formats/basis/basis_layout.h"

namespace tremolo::basis_layout {

// The numbers of one file that its shapes are made of.
struct SectionSizes {
  std::uint64_t modes = 0;              // r
  std::uint64_t surface_vertices = 0;   // s
  std::uint64_t interior_vertices = 0;  // n - s
  std::uint64_t triangles = 0;          // t
  std::uint64_t fixed = 0;
  std::uint64_t loaded = 0;            // l, vertices of the default load
  std::uint64_t render_vertices = 0;   // v
  std::uint64_t render_triangles = 0;  // w
  std::uint64_t edges = 0;             // of a quadratic mesh
  std::uint64_t tetrahedra = 0;        // m
  std::uint64_t response_places = 0;   // p
  bool compact = false;                // coefficients are f32, basis rows i16
  bool linear = false;                 // there are no cubic and no quartic terms
};

// All possible sections in the order of writing: those that a runtime reads come first, the
// interior and the provenance last. The sizes are at most kMaxModes and four times kMaxVertices.
std::vector<SectionShape> section_shapes(const SectionSizes& sizes);

}  // namespace tremolo::basis_layout
