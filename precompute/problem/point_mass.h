// Point masses on vertices: --point-mass SELECTOR=KG.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/selector.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

struct PointMassRequest {
  std::string text;  // as the user wrote it, for messages
  Selector at;
  double kilograms = 0;  // in total
};

// kilograms: total mass, distributed equally over `vertices` (ascending). fixed: the number of
// those that are fixed, where the mass has no effect on the dynamics.
struct PointMass {
  std::string selector;
  double kilograms = 0;
  std::vector<VertexId> vertices;
  std::size_t fixed = 0;
};

// Errors: kUsage for malformed text and whatever parse_selector refuses, kContent for a mass that
// is not positive and finite.
Result<PointMassRequest> parse_point_mass(const std::string& text);

// Selects the vertices. fixed: ascending. Errors: whatever select_vertices refuses, kContent if
// there is no vertex.
Result<PointMass> place_point_mass(const PointMassRequest& request, const TetMesh& mesh,
                                   const std::vector<VertexId>& fixed);

// Returns the point mass of each vertex, kg; empty if there are no point masses.
std::vector<double> mass_of_vertices(const std::vector<PointMass>& masses, std::size_t vertices);

}  // namespace tremolo
