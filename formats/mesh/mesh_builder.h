// Common part of the mesh readers: file ids become indices, tetrahedra are kept, other cells are
// counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "formats/mesh/mesh_cells.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {

// Call in this order: all vertices, seal_vertices(), cells and sets, finish(). A call that fails
// returns false and leaves a complaint, to which the reader adds the position in its file.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::string file) : file_(std::move(file)) {}

  void reserve_vertices(std::size_t count);
  void reserve_tetrahedra(std::size_t count) { mesh_.tetrahedra.reserve(count); }

  // id: the file's number for the vertex; x: metres. Refuses values that are not finite.
  bool add_vertex(std::int64_t id, const Eigen::Vector3d& x);
  // Refuses ids that two vertices share.
  bool seal_vertices();
  std::size_t vertex_count() const { return mesh_.vertices.size(); }

  // Indices of the nodes of a cell, which `cell` names for the complaint. Refuses unknown ids.
  bool resolve(std::int64_t cell, std::span<const std::int64_t> nodes,
               std::vector<VertexId>& vertices);
  // Adds a cell of any kind: a tetrahedron is kept, a hexahedron, wedge or pyramid is divided
  // (mesh().tetrahedra grows by up to six), another cell is counted, a tetrahedron of higher order
  // is refused. in_set: its vertices will be in a named set, so that it is not reported as unused.
  bool add_cell(std::int64_t cell, const CellKind& kind, std::span<const VertexId> vertices,
                bool in_set = false);

  void add_to_set(const std::string& name, std::span<const VertexId> vertices);
  // Sets the regions from a label of each tetrahedron kept so far, in order. name: of a label;
  // labels of one name are one region, an empty name is none.
  void set_regions(std::span<const std::int64_t> label_of_tet,
                   const std::function<std::string(std::int64_t)>& name);
  void add_material(FileMaterial material) { materials_.push_back(std::move(material)); }
  void add_note(std::string note) { notes_.push_back(std::move(note)); }

  const TetMesh& mesh() const { return mesh_; }
  TetMesh& mesh() { return mesh_; }
  const std::string& complaint() const { return complaint_; }

  // Sorts the sets and notes cells that were skipped or are only in sets. A file without tetrahedra
  // is an error (kContent) that lists its contents.
  Result<MeshFile> finish(std::string format);

 private:
  VertexId find(std::int64_t id) const;
  bool refuse(std::string complaint);
  bool cut(std::int64_t cell, const CellKind& kind, std::span<const VertexId> vertices);

  std::string file_;
  TetMesh mesh_;
  // Ids are almost always consecutive; the table of pairs is built only when they are not.
  std::int64_t first_id_ = 0;
  std::int64_t lowest_id_ = 0;
  std::int64_t highest_id_ = 0;
  bool consecutive_ = true;
  std::vector<std::int64_t> ids_;
  std::vector<std::pair<std::int64_t, VertexId>> index_of_id_;
  // These count cells that are no tetrahedra, by kind.
  struct Others {
    std::size_t skipped = 0;
    std::size_t in_sets = 0;
  };
  std::map<std::string_view, Others> others_;
  std::vector<VertexId> ranks_;  // ranks_by_place(), once a cell is cut
  std::map<std::string_view, std::array<std::size_t, 2>> cut_;  // by kind: cells, tetrahedra
  std::vector<std::string> notes_;
  std::vector<FileMaterial> materials_;
  std::string complaint_;
};

}  // namespace tremolo
