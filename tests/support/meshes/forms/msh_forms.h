// MSH files as Gmsh, meshio, pygmsh and fTetWild write them.
#pragma once

#include "tests/support/meshes/forms/form_mesh.h"

namespace tremolo::testing {

inline const std::string kFormNames =
    "$PhysicalNames\n3\n2 3 \"foot\"\n3 1 \"low\"\n3 2 \"high\"\n$EndPhysicalNames\n";

inline std::string msh2_nodes(const TetMesh& mesh) {
  std::string text = "$Nodes\n" + std::to_string(mesh.vertices.size()) + "\n";
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    text += std::to_string(v + 1) + " " + join(mesh.vertices[v]) + "\n";
  return text + "$EndNodes\n";
}

// partitions: tags of which a partitioned mesh has more.
inline std::string form_msh2_text(bool partitions) {
  const FormBar bar;
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + kFormNames + msh2_nodes(bar.mesh);
  text +=
      "$Elements\n" + std::to_string(bar.mesh.tetrahedra.size() + bar.foot_triangles.size()) + "\n";
  int id = 0;
  const auto tags = [&](int physical) {
    const std::string group = std::to_string(physical);
    return partitions ? " 4 " + group + " " + group + " 1 2" : " 2 " + group + " " + group;
  };
  for (const Triangle& triangle : bar.foot_triangles)
    text += std::to_string(++id) + " 2" + tags(3) + join(triangle, 1) + "\n";
  for (std::size_t t = 0; t < bar.mesh.tetrahedra.size(); ++t)
    text += std::to_string(++id) + " 4" + tags(1 + bar.half[t]) + join(bar.mesh.tetrahedra[t], 1) +
            "\n";
  return text + "$EndElements\n";
}

// one_block: as meshio and Gmsh write equal elements; else each element is a block, as fTetWild's
// writer does. data: an array of the elements behind them.
inline std::string form_msh2_binary(bool one_block, bool groups, bool data) {
  using Int = std::int32_t;
  const FormBar bar;
  const std::size_t count = bar.mesh.tetrahedra.size();
  ByteWriter bytes(false);
  bytes.text("$MeshFormat\n2.2 1 8\n").put(Int{1}).text("\n$EndMeshFormat\n");
  if (groups) bytes.text(kFormNames);
  bytes.text("$Nodes\n" + std::to_string(bar.mesh.vertices.size()) + "\n");
  for (std::size_t v = 0; v < bar.mesh.vertices.size(); ++v)
    bytes.put(static_cast<Int>(v + 1)).put(bar.mesh.vertices[v]);
  const std::size_t triangles = groups ? bar.foot_triangles.size() : 0;
  bytes.text("\n$EndNodes\n$Elements\n" + std::to_string(count + triangles) + "\n");
  Int id = 0;
  if (triangles > 0) bytes.put(Int{2}).put(static_cast<Int>(triangles)).put(Int{2});
  for (std::size_t t = 0; t < triangles; ++t) {
    bytes.put(++id).put(Int{3}).put(Int{3});
    for (const VertexId v : bar.foot_triangles[t]) bytes.put(v + 1);
  }
  const Int tags = groups ? 2 : 0;
  if (one_block) bytes.put(Int{4}).put(static_cast<Int>(count)).put(tags);
  for (std::size_t t = 0; t < count; ++t) {
    if (!one_block) bytes.put(Int{4}).put(Int{1}).put(tags);
    bytes.put(++id);
    for (Int tag = 0; tag < tags; ++tag) bytes.put(1 + bar.half[t]);
    for (const VertexId v : bar.mesh.tetrahedra[t]) bytes.put(v + 1);
  }
  bytes.text("\n$EndElements\n");
  if (!data) return bytes.str();
  bytes.text("$ElementData\n1\n\"color\"\n1\n0.0\n3\n0\n1\n" + std::to_string(count) + "\n");
  for (std::size_t t = 0; t < count; ++t) bytes.put(static_cast<Int>(t + 1)).put(0.5);
  return bytes.text("\n$EndElementData\n").str();
}

// MSH 4.1 of Gmsh, text or binary: two volumes and a surface, of the nodes all in the first volume.
class Msh4Form {
 public:
  explicit Msh4Form(bool binary) : binary_(binary), bytes_(false) {
    bytes_.text(binary ? "$MeshFormat\n4.1 1 8\n" : "$MeshFormat\n4.1 0 8\n");
    if (binary) bytes_.put(std::int32_t{1}).text("\n");
    bytes_.text("$EndMeshFormat\n");
  }
  Msh4Form& section(const std::string& text) {
    bytes_.text(text);
    return *this;
  }
  Msh4Form& ints(const std::vector<int>& values) { return put<std::int32_t>(values); }
  Msh4Form& sizes(const std::vector<int>& values) { return put<std::uint64_t>(values); }
  Msh4Form& reals(const std::vector<double>& values) {
    for (const double value : values)
      if (binary_)
        bytes_.put(value);
      else
        bytes_.text(number(value) + " ");
    return *this;
  }
  Msh4Form& line() {
    if (!binary_) bytes_.text("\n");
    return *this;
  }
  // Behind the data of a section.
  Msh4Form& end(const std::string& name) {
    bytes_.text((binary_ ? "\n$End" : "$End") + name + "\n");
    return *this;
  }
  std::string str() const { return bytes_.str(); }

 private:
  template <class Stored>
  Msh4Form& put(const std::vector<int>& values) {
    for (const int value : values)
      if (binary_)
        bytes_.put(static_cast<Stored>(value));
      else
        bytes_.text(std::to_string(value) + " ");
    return *this;
  }
  bool binary_;
  ByteWriter bytes_;
};

inline void msh4_nodes(const TetMesh& mesh, int dimension, int entity, Msh4Form& file) {
  const int count = static_cast<int>(mesh.vertices.size());
  file.section("$Nodes\n").sizes({1, count, 1, count}).line();
  file.ints({dimension, entity, 0}).sizes({count}).line();
  for (int v = 1; v <= count; ++v) file.sizes({v}).line();
  for (const Eigen::Vector3d& x : mesh.vertices) file.reals({x[0], x[1], x[2]}).line();
  file.end("Nodes");
}

template <class Cell>
inline void msh4_block(int dimension, int entity, int type, const std::vector<Cell>& cells, int& id,
                       Msh4Form& file) {
  file.ints({dimension, entity, type}).sizes({static_cast<int>(cells.size())}).line();
  for (const Cell& cell : cells) {
    file.sizes({++id});
    for (const VertexId v : cell) file.sizes({v + 1});
    file.line();
  }
}

inline std::vector<Tetrahedron> half_of(const FormBar& bar, int which) {
  std::vector<Tetrahedron> cells;
  for (const std::size_t t : bar.tets_of_half(which)) cells.push_back(bar.mesh.tetrahedra[t]);
  return cells;
}

// entities: without them, as meshio writes, there are no groups.
inline std::string form_msh4(bool binary, bool entities) {
  const FormBar bar;
  Msh4Form file(binary);
  if (entities) {
    file.section(kFormNames + "$Entities\n").sizes({0, 0, 1, 2}).line();
    for (const int tag : {5})
      file.ints({tag}).reals({0, 0, 0, 0, 1, 1}).sizes({1}).ints({3}).sizes({0}).line();
    for (const int tag : {7, 8})
      file.ints({tag})
          .reals({0, 0, 0, 1, 1, 1})
          .sizes({1})
          .ints({tag - 6})
          .sizes({1})
          .ints({5})
          .line();
    file.end("Entities");
  }
  msh4_nodes(bar.mesh, 3, 7, file);
  const int triangles = entities ? static_cast<int>(bar.foot_triangles.size()) : 0;
  const int count = static_cast<int>(bar.mesh.tetrahedra.size()) + triangles;
  file.section("$Elements\n").sizes({entities ? 3 : 2, count, 1, count}).line();
  int id = 0;
  if (entities) msh4_block(2, 5, 2, bar.foot_triangles, id, file);
  for (const int which : {0, 1}) msh4_block(3, 7 + which, 4, half_of(bar, which), id, file);
  return file.end("Elements").str();
}

// Each volume in two partitions, with the border between them, which is in no group.
inline std::string form_msh4_partitioned(bool binary) {
  const FormBar bar;
  Msh4Form file(binary);
  file.section(kFormNames + "$Entities\n").sizes({0, 0, 1, 2}).line();
  file.ints({5}).reals({0, 0, 0, 0, 1, 1}).sizes({1}).ints({3}).sizes({0}).line();
  for (const int tag : {7, 8})
    file.ints({tag})
        .reals({0, 0, 0, 1, 1, 1})
        .sizes({1})
        .ints({tag - 6})
        .sizes({1})
        .ints({5})
        .line();
  file.end("Entities").section("$PartitionedEntities\n").sizes({2}).sizes({0}).line();
  file.sizes({1, 0, 2, 4}).line();
  file.ints({30, 3, 7}).sizes({2}).ints({1, 2}).reals({0, 0, 0}).sizes({0}).line();
  file.ints({20, 2, 5}).sizes({1}).ints({1}).reals({0, 0, 0, 0, 1, 1}).sizes({0}).sizes({0}).line();
  file.ints({21, 3, 7})
      .sizes({2})
      .ints({1, 2})
      .reals({0, 0, 0, 0, 1, 1})
      .sizes({1})
      .ints({9})
      .sizes({0})
      .line();
  for (int part = 0; part < 4; ++part)
    file.ints({10 + part, 3, 7 + part / 2})
        .sizes({1})
        .ints({1 + part % 2})
        .reals({0, 0, 0, 1, 1, 1})
        .sizes({0})
        .sizes({1})
        .ints({-20})
        .line();
  file.end("PartitionedEntities");
  msh4_nodes(bar.mesh, 3, 10, file);
  const int count = static_cast<int>(bar.mesh.tetrahedra.size() + bar.foot_triangles.size()) + 1;
  file.section("$Elements\n").sizes({6, count, 1, count}).line();
  int id = 0;
  msh4_block(2, 20, 2, bar.foot_triangles, id, file);
  msh4_block(2, 21, 2, std::vector<Triangle>{{4, 9, 14}}, id, file);
  for (int part = 0; part < 4; ++part) {
    const std::vector<Tetrahedron> all = half_of(bar, part / 2);
    std::vector<Tetrahedron> cells;
    for (std::size_t t = 0; t < all.size(); ++t)
      if (static_cast<int>(t % 2) == part % 2) cells.push_back(all[t]);
    msh4_block(3, 10 + part, 4, cells, id, file);
  }
  return file.end("Elements").str();
}

inline std::string form_msh4_quadratic() {
  const QuadraticBar bar;
  std::vector<std::array<VertexId, 10>> cells = bar.cells;
  for (auto& cell : cells) std::swap(cell[8], cell[9]);
  Msh4Form file(false);
  msh4_nodes(bar.mesh, 3, 1, file);
  const int count = static_cast<int>(cells.size());
  file.section("$Elements\n").sizes({1, count, 1, count}).line();
  int id = 0;
  msh4_block(3, 1, 11, cells, id, file);
  return file.end("Elements").str();
}

inline std::vector<WriterForm> msh_forms() {
  const std::vector<std::string> halves = {"low", "high"};
  const auto msh = [](const std::string& bytes) {
    return std::vector<std::pair<std::string, std::string>>{{"a.msh", bytes}};
  };
  return {{"gmsh", "MSH 2.2 text", msh(form_msh2_text(false)), "foot", halves},
          {"gmsh", "MSH 2.2 text, partitioned", msh(form_msh2_text(true)), "foot", halves},
          {"gmsh", "MSH 2.2 binary", msh(form_msh2_binary(true, true, false)), "foot", halves},
          {"gmsh", "MSH 4.1 text", msh(form_msh4(false, true)), "foot", halves},
          {"gmsh", "MSH 4.1 binary", msh(form_msh4(true, true)), "foot", halves},
          {"gmsh", "MSH 4.1 text, partitioned", msh(form_msh4_partitioned(false)), "foot", halves},
          {"gmsh", "MSH 4.1 binary, partitioned", msh(form_msh4_partitioned(true)), "foot", halves},
          {"gmsh", "MSH 4.1 of order 2", msh(form_msh4_quadratic()), "", {}, true},
          {"meshio", "MSH 4.1 binary without entities", msh(form_msh4(true, false))},
          {"pygmsh", "MSH 4.1 text without entities", msh(form_msh4(false, false))},
          {"pygmsh", "MSH 2.2 binary", msh(form_msh2_binary(true, true, false)), "foot", halves},
          {"fTetWild", "MSH 2.2 binary with data", msh(form_msh2_binary(false, false, true))},
          {"fTetWild", "MSH 2.2 text", msh(form_msh2_text(false)), "foot", halves}};
}

}  // namespace tremolo::testing
