// Masses that sit on vertices: --point-mass SELECTOR=KG.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// kilograms: of all of them together, in equal parts on `vertices` (ascending). fixed: how many of
// those do not move, so that their part does nothing but weigh.
struct PointMass {
  std::string selector;
  double kilograms = 0;
  std::vector<VertexId> vertices;
  std::size_t fixed = 0;
};

// Of the text alone; no vertices yet. Errors: kUsage for a malformed text and what parse_selector
// refuses, kContent for a mass that is not positive and finite.
Result<PointMass> parse_point_mass(const std::string& text);

// fixed: ascending. Errors: kUsage for a malformed text and what parse_selector refuses, kContent
// for a mass that is not positive and finite and for what select_vertices refuses.
Result<PointMass> read_point_mass(const std::string& text, const TetMesh& mesh,
                                  const std::vector<VertexId>& fixed);

// kg of each vertex; empty without point masses.
std::vector<double> mass_of_vertices(const std::vector<PointMass>& masses, std::size_t vertices);

}  // namespace tremolo
