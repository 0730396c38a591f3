// Hexahedra, wedges and pyramids become tetrahedra that fit.
#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/small_mesh.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::TemporaryFolder;

// Cells of VTK: type and nodes.
struct Cells {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::pair<int, std::vector<int>>> cells;
};

Result<MeshFile> read(const Cells& cells) {
  std::string text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " +
                     std::to_string(cells.points.size()) + " double\n";
  for (const Eigen::Vector3d& x : cells.points) text += testing::join(x) + "\n";
  std::size_t length = 0;
  std::string lists, types, regions;
  for (const auto& [type, nodes] : cells.cells) {
    length += nodes.size() + 1;
    lists += std::to_string(nodes.size());
    for (const int node : nodes) lists += " " + std::to_string(node);
    lists += "\n";
    types += std::to_string(type) + "\n";
    regions += std::to_string(type) + "\n";
  }
  const std::string count = std::to_string(cells.cells.size());
  text += "CELLS " + count + " " + std::to_string(length) + "\n" + lists + "CELL_TYPES " + count +
          "\n" + types + "CELL_DATA " + count + "\nSCALARS region int 1\nLOOKUP_TABLE default\n" +
          regions;
  const TemporaryFolder folder;
  return read_tet_mesh(folder.write("a.vtk", text));
}

// A box of n^3 cells of all kinds: hexahedra, voxels, pairs of wedges, and six pyramids around a
// point. Vertices have random numbers and lie off the grid.
Cells mixed_box(int n, unsigned seed) {
  std::mt19937 random(seed);
  const auto vertex = [n](int i, int j, int k) { return i + (n + 1) * (j + (n + 1) * k); };
  Cells box;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) box.points.push_back(Eigen::Vector3d(i, j, k) / n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const std::array<int, 8> c = {vertex(i, j, k),
                                      vertex(i + 1, j, k),
                                      vertex(i + 1, j + 1, k),
                                      vertex(i, j + 1, k),
                                      vertex(i, j, k + 1),
                                      vertex(i + 1, j, k + 1),
                                      vertex(i + 1, j + 1, k + 1),
                                      vertex(i, j + 1, k + 1)};
        switch (random() % 4) {
          case 0:
            box.cells.push_back({12, {c.begin(), c.end()}});
            break;
          case 1:
            box.cells.push_back({11, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]}});
            break;
          case 2:
            // The two wedges cut the bottom and the top along a diagonal of their own, which the
            // cells above and below must have as well: only where there are none.
            if (n == 1) {
              box.cells.push_back({13, {c[0], c[1], c[2], c[4], c[5], c[6]}});
              box.cells.push_back({13, {c[0], c[2], c[3], c[4], c[6], c[7]}});
              break;
            }
            [[fallthrough]];
          default: {
            const int middle = static_cast<int>(box.points.size());
            box.points.push_back((Eigen::Vector3d(i, j, k) + Eigen::Vector3d::Constant(0.5)) / n);
            for (const std::array<int, 4>& f : {std::array{0, 1, 2, 3},
                                                {4, 7, 6, 5},
                                                {0, 4, 5, 1},
                                                {1, 5, 6, 2},
                                                {2, 6, 7, 3},
                                                {3, 7, 4, 0}})
              box.cells.push_back({14, {c[f[0]], c[f[1]], c[f[2]], c[f[3]], middle}});
          }
        }
      }
  // Other numbers.
  std::vector<int> order(box.points.size());
  for (std::size_t v = 0; v < order.size(); ++v) order[v] = static_cast<int>(v);
  std::shuffle(order.begin(), order.end(), random);
  std::vector<Eigen::Vector3d> points(order.size());
  for (std::size_t v = 0; v < order.size(); ++v) points[order[v]] = box.points[v];
  box.points = points;
  for (auto& [type, nodes] : box.cells)
    for (int& node : nodes) node = order[node];
  return box;
}

// Faces of one tetrahedron only.
std::size_t boundary_faces(const TetMesh& mesh) {
  std::map<std::array<VertexId, 3>, int> faces;
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (int skip = 0; skip < 4; ++skip) {
      std::array<VertexId, 3> face{};
      for (int n = 0, at = 0; n < 4; ++n)
        if (n != skip) face[at++] = tet[n];
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  std::size_t alone = 0;
  for (const auto& [face, count] : faces) {
    EXPECT_LE(count, 2);
    alone += count == 1 ? 1 : 0;
  }
  return alone;
}

TEST(CutCells, NeighboursCutTheirCommonFaceAlikeWhateverTheNumbers) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Result<MeshFile> file = read(mixed_box(3, seed));
    ASSERT_TRUE(file) << file.error().message;
    const Result<MeshReport> report = check_mesh(file->mesh);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->flipped, 0u);
    EXPECT_NEAR(report->volume, 1.0, 1e-12);  // rounding of some hundred terms
    // Two triangles on each of the 54 quadrilaterals around the box, and none inside.
    EXPECT_EQ(boundary_faces(file->mesh), 2u * 54u) << "seed " << seed;
  }
}

TEST(CutCells, EveryKindHasItsNumberOfTetrahedraAndItsRegion) {
  const std::vector<Eigen::Vector3d> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                                {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const std::vector<std::tuple<int, std::vector<int>, std::size_t, double>> kinds = {
      {12, {0, 1, 2, 3, 4, 5, 6, 7}, 6, 1.0},
      {11, {0, 1, 3, 2, 4, 5, 7, 6}, 6, 1.0},
      {13, {0, 1, 2, 4, 5, 6}, 3, 0.5},
      {13, {4, 5, 6, 0, 1, 2}, 3, 0.5},  // the other way round
      {14, {0, 1, 2, 3, 4}, 2, 1.0 / 3},
      {12, {0, 1, 2, 2, 4, 5, 6, 6}, 3, 0.5}};  // a wedge written as a hexahedron
  for (const auto& [type, nodes, count, volume] : kinds) {
    Result<MeshFile> file = read({corners, {{type, nodes}}});
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->mesh.tetrahedra.size(), count);
    EXPECT_EQ(file->mesh.region_of, std::vector<std::int32_t>(count, 0));
    const Result<MeshReport> report = check_mesh(file->mesh);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_NEAR(report->volume, volume, 1e-15);
    EXPECT_EQ(report->flipped, 0u);
  }
}

TEST(CutCells, DoubledCornersOfTwoBlocksAreCutAlikeSoThatTheyCanBeMerged) {
  // Two cubes whose common face stands twice, with numbers in other orders.
  Cells blocks{{{1, 0, 0},
                {1, 1, 0},
                {1, 0, 1},
                {1, 1, 1},
                {2, 0, 0},
                {2, 1, 0},
                {2, 0, 1},
                {2, 1, 1},
                {0, 0, 0},
                {0, 1, 0},
                {0, 0, 1},
                {0, 1, 1},
                {1, 1, 1},
                {1, 0, 1},
                {1, 0, 0},
                {1, 1, 0}},
               {{12, {0, 4, 5, 1, 2, 6, 7, 3}}, {12, {8, 14, 15, 9, 10, 13, 12, 11}}}};
  Result<MeshFile> file = read(blocks);
  ASSERT_TRUE(file) << file.error().message;
  for (Tetrahedron& tet : file->mesh.tetrahedra)
    for (VertexId& v : tet)
      for (VertexId first = 0; first < v; ++first)
        if (file->mesh.vertices[first] == file->mesh.vertices[v]) v = first;
  EXPECT_EQ(boundary_faces(file->mesh), 20u);
}

TEST(CutCells, ACellThatIsTurnedInsideOutIsRefusedByItsNumber) {
  const Result<MeshFile> file = read({{{0, 0, 0},
                                       {1, 0, 0},
                                       {1, 1, 0},
                                       {0, 1, 0},
                                       {0, 0, 1},
                                       {1, 0, 1},
                                       {0.1, 0.1, -0.5},
                                       {0, 1, 1}},
                                      {{12, {0, 1, 2, 3, 4, 5, 6, 7}}}});
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, ErrorKind::kContent);
  EXPECT_NE(file.error().message.find("element 0, one of hexahedra"), std::string::npos)
      << file.error().message;
}

}  // namespace
}  // namespace tremolo
