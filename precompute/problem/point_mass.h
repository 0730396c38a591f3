// Point masses on vertices: --point-mass SELECTOR=KG.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// kilograms: total mass, distributed equally over `vertices` (ascending). fixed: the number of
// those that are fixed, where the mass has no effect on the dynamics.
struct PointMass {
  std::string selector;
  double kilograms = 0;
  std::vector<VertexId> vertices;
  std::size_t fixed = 0;
};

// Parses the text alone; `vertices` stays empty. Errors: kUsage for malformed text and whatever
// parse_selector refuses, kContent for a mass that is not positive and finite.
Result<PointMass> parse_point_mass(const std::string& text);

// Parses the text and selects the vertices. fixed: ascending. Errors: kUsage for malformed text and
// whatever parse_selector refuses, kContent for a mass that is not positive and finite and whatever
// select_vertices refuses.
Result<PointMass> read_point_mass(const std::string& text, const TetMesh& mesh,
                                  const std::vector<VertexId>& fixed);

// Returns the point mass of each vertex, kg; empty if there are no point masses.
std::vector<double> mass_of_vertices(const std::vector<PointMass>& masses, std::size_t vertices);

}  // namespace tremolo
