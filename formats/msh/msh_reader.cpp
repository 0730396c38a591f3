#include <cstdint>

#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/msh/msh_input.h"

namespace tremolo {
namespace {

struct MshFile {
  MeshBuilder builder;
  MshGroups groups;
  MshEntities entities;
  std::vector<std::int64_t> volume_of_tet;
  bool has_nodes = false;
  bool has_elements = false;
};

Status out_of_order(const MshInput& input, const std::string& found) {
  return input.problem("expected one section $Nodes and then one section $Elements, found " +
                       found);
}

Status read_nodes(MshInput& input, MshFile& file) {
  if (file.has_nodes) return out_of_order(input, "a second section $Nodes");
  file.has_nodes = true;
  return input.version() == "4.1" ? read_msh4_nodes(input, file.builder)
                                  : read_msh2_nodes(input, file.builder);
}

Status read_elements(MshInput& input, MshFile& file) {
  if (!file.has_nodes) return out_of_order(input, "$Elements before $Nodes");
  if (file.has_elements) return out_of_order(input, "a second section $Elements");
  file.has_elements = true;
  return input.version() == "4.1"
             ? read_msh4_elements(input, file.entities, file.builder, file.groups,
                                  file.volume_of_tet)
             : read_msh2_elements(input, file.builder, file.groups, file.volume_of_tet);
}

Status read_section(MshInput& input, std::string_view name, MshFile& file) {
  if (name == "Nodes") return read_nodes(input, file);
  if (name == "Elements") return read_elements(input, file);
  const bool partitioned = name == "PartitionedEntities";
  if ((name == "Entities" || partitioned) && input.version() == "4.1")
    return read_msh4_entities(input, partitioned, file.entities);
  if (name == "PhysicalNames") {
    if (!file.groups.read_names(input)) return input.error();
    return Success{};
  }
  if (!input.skip_section(name)) return input.error();
  return Success{};
}

}  // namespace

Result<MeshFile> read_msh(std::string_view text, const std::string& path) {
  Result<MshInput> opened = MshInput::open(text, path);
  if (!opened) return opened.error();
  MshInput& input = *opened;
  MshFile file{MeshBuilder(path), {}, {}, {}, false, false};
  for (;;) {
    std::string_view name;
    if (!input.next_section(name)) return input.error();
    if (name.empty()) break;
    const Status status = read_section(input, name, file);
    if (!status) return status.error();
  }
  if (!file.has_elements)
    return content_error(path +
                         ": expected sections $Nodes and $Elements, found the end of the "
                         "file without " +
                         (file.has_nodes ? "$Elements" : "$Nodes"));
  file.groups.give_to(file.builder, file.volume_of_tet);
  return file.builder.finish(input.format());
}

namespace {

constexpr std::int32_t kTetrahedronType = 4;  // Gmsh's number for the linear tetrahedron

}  // namespace

Status write_msh(const std::string& path, const TetMesh& mesh) {
  std::string bytes = "$MeshFormat\n2.2 1 8\n";
  append_bytes(bytes, std::int32_t{1});  // shows the reader the byte order
  bytes += "\n$EndMeshFormat\n$Nodes\n" + std::to_string(mesh.vertices.size()) + "\n";
  std::int32_t number = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    append_bytes(bytes, ++number);
    for (double value : x) append_bytes(bytes, value);
  }
  bytes += "\n$EndNodes\n$Elements\n" + std::to_string(mesh.tetrahedra.size()) + "\n";
  append_bytes(bytes, kTetrahedronType);
  append_bytes(bytes, static_cast<std::int32_t>(mesh.tetrahedra.size()));
  append_bytes(bytes, std::int32_t{0});  // tags an element
  number = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    append_bytes(bytes, ++number);
    for (VertexId v : tet) append_bytes(bytes, v + 1);
  }
  bytes += "\n$EndElements\n";
  return write_file(path, bytes);
}

}  // namespace tremolo
