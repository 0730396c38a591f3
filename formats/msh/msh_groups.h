// Physical groups of an MSH file -> node sets and regions.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/mesh/mesh_builder.h"
#include "formats/msh/msh_input.h"

namespace tremolo {

// A group of dimension 0 to 3 with a tag; its set holds the vertices of all its elements. Its name
// is its physical name, or "point 7", "curve 7", "surface 7", "volume 7" without one, with "
// (unnamed)" appended if another group has that name.
class MshGroups {
 public:
  // The body of $PhysicalNames.
  bool read_names(MshInput& input);
  // Signs of tags are orientations and do not matter; tag 0 is no group.
  void add(int dimension, std::int64_t tag, std::span<const VertexId> vertices);
  // The name of a group.
  std::string name(int dimension, std::int64_t tag) const;
  // volume_of_tet: the tag of each tetrahedron's volume group, 0 for none: the regions. Keeps none
  // of the members: large sets shall not be in memory twice.
  void give_to(MeshBuilder& builder, std::span<const std::int64_t> volume_of_tet);

 private:
  using Key = std::pair<int, std::int64_t>;
  std::map<Key, std::string> names_;
  std::set<std::string> given_;
  std::map<Key, std::vector<VertexId>> members_;
};

// Dimension of the cells of an MSH element type.
int msh_dimension(std::int64_t type);

}  // namespace tremolo
