// The numbers of an MSH file, the same whether the file is text or binary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.h"
#include "formats/file/scanner.h"
#include "formats/mesh/mesh_builder.h"

namespace tremolo {

// The minimum of numbers of each kind in an item of a list.
struct MshItem {
  std::size_t integers = 0;  // int32 in a binary file
  std::size_t sizes = 0;     // u64
  std::size_t reals = 0;     // f64
};

// Walks over the sections of a file. Reads that fail return false and leave error().
class MshInput {
 public:
  // Reads the $MeshFormat section, with which the file begins, and refuses other versions.
  static Result<MshInput> open(std::string_view text, const std::string& path);

  // "4.1", "2" or "2.2" and its like; open() refuses others.
  const std::string& version() const { return version_; }
  bool binary() const { return binary_; }
  // "MSH 4.1 binary"
  std::string format() const;

  // The name of the next section without its $, empty at the end of the file.
  bool next_section(std::string_view& name);
  // Moves past the $End line of a section that is not read.
  bool skip_section(std::string_view name);
  // Expects the $End line of a section that was read.
  bool end_section(std::string_view name);

  // A part of a section that a binary file stores as bytes: from the next line on.
  bool begin_data();
  void end_data();
  bool integer(std::int64_t& value, std::string_view what);
  bool size(std::uint64_t& value, std::string_view what);
  bool real(double& value, std::string_view what);
  bool fits(std::uint64_t count, MshItem item, std::string_view what);

  // For the parts that are text in every file.
  TextScanner& text() { return text_; }
  // Adds the position of the last number read.
  Error problem(const std::string& complaint) const;
  const Error& error() const { return in_bytes_ ? bytes_.error() : text_.error(); }

 private:
  MshInput(std::string_view text, const std::string& path);
  Status read_format();

  std::string_view whole_;
  std::string path_;
  TextScanner text_;
  ByteScanner bytes_;
  std::string version_;
  bool binary_ = false;
  bool swap_ = false;
  bool in_bytes_ = false;
};

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

// The sections of an MSH file that differ between the versions. The input is positioned after the
// section's name; the Status gives the error with its position.

// Version 2: groups are tags of the elements. volume_of_tet: the tag of each tetrahedron kept, the
// first if it has several, 0 without one.
Status read_msh2_nodes(MshInput& input, MeshBuilder& builder);
Status read_msh2_elements(MshInput& input, MeshBuilder& builder, MshGroups& groups,
                          std::vector<std::int64_t>& volume_of_tet);

// Version 4.1: groups are tags of the entities, {dimension, tag} -> physical tags.
using MshEntities = std::map<std::pair<int, std::int64_t>, std::vector<std::int64_t>>;
// partitioned: the section is $PartitionedEntities, whose entities are parts of those in $Entities
// and have the groups of the whole.
Status read_msh4_entities(MshInput& input, bool partitioned, MshEntities& entities);
Status read_msh4_nodes(MshInput& input, MeshBuilder& builder);
Status read_msh4_elements(MshInput& input, const MshEntities& entities, MeshBuilder& builder,
                          MshGroups& groups, std::vector<std::int64_t>& volume_of_tet);

}  // namespace tremolo
