// Selectors (common/mesh/selector.h) on the boundary, the part of the mesh in a basis file.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "runtime/model.h"

namespace tremolo {

// The boundary of a mesh. render: nullptr if there is none. vertex_count: n of the whole mesh.
struct Boundary {
  const VertexBlock& surface;
  const RenderBlock* render;
  const DefaultLoad& load;
  std::uint64_t vertex_count;
};

// Ids in the source mesh, ascending, of vertices on the boundary, and where they are at rest, m.
// The sets are `fixed` (vertices that do not move), `loaded` (of the default load) and, for each
// object and material of the render surface, the anchors of its vertices; they take its colours.
// Errors as select_vertices.
struct Selection {
  std::vector<VertexId> ids;
  std::vector<Eigen::Vector3d> places;
  std::vector<std::string> notes;  // for the user: the vertex chosen by a `near:`
};
Result<Selection> select_on_boundary(const std::string& text, const Boundary& boundary);

// text: a vertex's id, which may be inside, or a selector on the model's boundary. Errors: kContent
// for a negative id, else as for select_on_boundary.
Result<std::vector<VertexId>> vertices_of(const std::string& text, const Model& model);

// A force (N) on these vertices, on a face shared by its area (common/mesh/surface_mesh.h).
DefaultLoad shared_by_area(const std::vector<VertexId>& vertices, const Eigen::Vector3d& force,
                           const Model& model);

// For each `near:` of the text, a note with the chosen vertex; empty if vertices_of gives an error.
std::vector<std::string> nearest_of(const std::string& text, const Model& model);

}  // namespace tremolo
