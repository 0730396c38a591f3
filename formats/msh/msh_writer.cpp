#include "formats/msh/msh_writer.h"

#include <cstdint>

#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"

namespace tremolo {
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
