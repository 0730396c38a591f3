#include "formats/msh/msh_writer.h"

#include <cstdint>
#include <cstring>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

constexpr std::int32_t kTetrahedronType = 4;  // Gmsh's number for the linear tetrahedron

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

}  // namespace

Status write_msh(const std::string& path, const TetMesh& mesh) {
  std::string bytes = "$MeshFormat\n2.2 1 8\n";
  append(bytes, std::int32_t{1});  // tells the reader the byte order
  bytes += "\n$EndMeshFormat\n$Nodes\n" + std::to_string(mesh.vertices.size()) + "\n";
  std::int32_t number = 0;
  for (const Eigen::Vector3d& x : mesh.vertices) {
    append(bytes, ++number);
    for (double value : x) append(bytes, value);
  }
  bytes += "\n$EndNodes\n$Elements\n" + std::to_string(mesh.tetrahedra.size()) + "\n";
  append(bytes, kTetrahedronType);
  append(bytes, static_cast<std::int32_t>(mesh.tetrahedra.size()));
  append(bytes, std::int32_t{0});  // tags an element
  number = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    append(bytes, ++number);
    for (VertexId v : tet) append(bytes, v + 1);
  }
  bytes += "\n$EndElements\n";
  return write_file(path, bytes);
}

}  // namespace tremolo
