// small_mesh() as MSH files, with the triangle in the group "the foot".
#pragma once

#include <cstdint>
#include <string>

#include "tests/support/meshes/small_mesh.h"

namespace tremolo::testing {

inline constexpr const char* kPhysicalNames =
    "$PhysicalNames\n2\n2 8 \"the foot\"\n3 4 \"body\"\n$EndPhysicalNames\n";

inline std::string msh2_text() {
  const TetMesh mesh = small_mesh();
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  text += kPhysicalNames;
  text += "$Nodes\n5\n";
  for (std::size_t v = 0; v < 5; ++v)
    text += std::to_string(kNodeIds[v]) + " " + join(mesh.vertices[v]) + "\n";
  text += "$EndNodes\n$Elements\n3\n1 2 2 8 1" + join_ids(kTriangle) + "\n";
  for (std::size_t t = 0; t < 2; ++t)
    text += std::to_string(t + 2) + " 4 2 4 1" + join_ids(mesh.tetrahedra[t]) + "\n";
  return text + "$EndElements\n$NodeData\nignored\n$EndNodeData\n";
}

inline std::string msh2_binary(bool big_endian) {
  const TetMesh mesh = small_mesh();
  ByteWriter bytes(big_endian);
  bytes.text("$MeshFormat\n2.2 1 8\n").put(std::int32_t{1}).text("\n$EndMeshFormat\n");
  bytes.text(kPhysicalNames).text("$Nodes\n5\n");
  for (std::size_t v = 0; v < 5; ++v)
    bytes.put(static_cast<std::int32_t>(kNodeIds[v])).put(mesh.vertices[v]);
  bytes.text("\n$EndNodes\n$Elements\n3\n");
  const auto element = [&bytes](std::int32_t id, std::int32_t physical, const auto& cell) {
    bytes.put(id).put(physical).put(std::int32_t{1});
    for (VertexId v : cell) bytes.put(static_cast<std::int32_t>(kNodeIds[v]));
  };
  bytes.put(std::int32_t{2}).put(std::int32_t{1}).put(std::int32_t{2});
  element(1, 8, kTriangle);
  bytes.put(std::int32_t{4}).put(std::int32_t{2}).put(std::int32_t{2});
  element(2, 4, mesh.tetrahedra[0]);
  element(3, 4, mesh.tetrahedra[1]);
  return bytes.text("\n$EndElements\n").str();
}

inline std::string msh4_text() {
  const TetMesh mesh = small_mesh();
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  text += kPhysicalNames;
  // A point, no curve, a surface in group 8 around nothing, a volume in group 4 inside it.
  text += "$Entities\n1 0 1 1\n1 0 0 0 0\n6 0 0 0 1 1 0 1 8 0\n1 0 0 0 1 1 1 1 4 1 6\n";
  text += "$EndEntities\n$Nodes\n2 5 2 9\n2 6 1 3\n";
  for (std::size_t v = 0; v < 3; ++v) text += std::to_string(kNodeIds[v]) + "\n";
  // Nodes of a surface may have two parameters.
  for (std::size_t v = 0; v < 3; ++v) text += join(mesh.vertices[v]) + " 0.5 0.5\n";
  text += "3 1 0 2\n";
  for (std::size_t v = 3; v < 5; ++v) text += std::to_string(kNodeIds[v]) + "\n";
  for (std::size_t v = 3; v < 5; ++v) text += join(mesh.vertices[v]) + "\n";
  text += "$EndNodes\n$Elements\n2 3 1 3\n2 6 2 1\n1" + join_ids(kTriangle) + "\n3 1 4 2\n";
  for (std::size_t t = 0; t < 2; ++t)
    text += std::to_string(t + 2) + join_ids(mesh.tetrahedra[t]) + "\n";
  return text + "$EndElements\n";
}

inline std::string msh4_binary(bool big_endian) {
  using Int = std::int32_t;
  using Size = std::uint64_t;
  const TetMesh mesh = small_mesh();
  ByteWriter bytes(big_endian);
  const auto block = [&bytes](Int dimension, Int entity, Int kind, Size count) {
    bytes.put(dimension).put(entity).put(kind).put(count);
  };
  bytes.text("$MeshFormat\n4.1 1 8\n").put(Int{1}).text("\n$EndMeshFormat\n");
  bytes.text(kPhysicalNames).text("$Entities\n");
  const Eigen::Vector3d corner = Eigen::Vector3d::Zero();
  bytes.put(Size{1}).put(Size{0}).put(Size{1}).put(Size{1});
  bytes.put(Int{1}).put(corner).put(Size{0});
  bytes.put(Int{6}).put(corner).put(corner).put(Size{1}).put(Int{8}).put(Size{0});
  bytes.put(Int{1}).put(corner).put(corner).put(Size{1}).put(Int{4}).put(Size{1}).put(Int{6});
  bytes.text("\n$EndEntities\n$Nodes\n");
  bytes.put(Size{1}).put(Size{5}).put(Size{2}).put(Size{9});
  block(3, 1, 0, 5);
  for (int id : kNodeIds) bytes.put(static_cast<Size>(id));
  for (const Eigen::Vector3d& x : mesh.vertices) bytes.put(x);
  bytes.text("\n$EndNodes\n$Elements\n");
  bytes.put(Size{2}).put(Size{3}).put(Size{1}).put(Size{3});
  const auto element = [&bytes](Size tag, const auto& cell) {
    bytes.put(tag);
    for (VertexId v : cell) bytes.put(static_cast<Size>(kNodeIds[v]));
  };
  block(2, 6, 2, 1);
  element(1, kTriangle);
  block(3, 1, 4, 2);
  element(2, mesh.tetrahedra[0]);
  element(3, mesh.tetrahedra[1]);
  return bytes.text("\n$EndElements\n").str();
}

}  // namespace tremolo::testing
