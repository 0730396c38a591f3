// Quadratic meshes: edges in MSH and VTK files, refused ones, and edges in a basis file.
#include <gtest/gtest.h>

#include "common/mesh/edge_points.h"
#include "common/mesh/mesh_check.h"
#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vtk/vtu_writer.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

// The points of the unit tetrahedron's edges 01, 12, 02, 03, 13, 23, VTK's order.
const char* const kMiddles[] = {"0.5 0 0", "0.5 0.5 0", "0 0.5 0",
                                "0 0 0.5", "0.5 0 0.5", "0 0.5 0.5"};

std::string msh_text(const std::string& nodes = "1 2 3 4 5 6 7 8 10 9",
                     const std::string& first_middle = "0.5 0 0") {
  std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  for (int e = 0; e < 6; ++e)
    text += std::to_string(5 + e) + " " + (e == 0 ? first_middle : kMiddles[e]) + "\n";
  return text + "$EndNodes\n$Elements\n1\n1 11 2 1 1 " + nodes + "\n$EndElements\n";
}

std::string vtk_text() {
  std::string text =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 double\n"
      "0 0 0 1 0 0 0 1 0 0 0 1\n";
  for (const char* middle : kMiddles) text += std::string(middle) + "\n";
  return text + "CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n";
}

Result<MeshFile> read_text(const std::string& name, const std::string& text) {
  const testing::TemporaryFolder folder;
  return read_tet_mesh(folder.write(name, text));
}

void expect_middles(const TetMesh& given) {
  TetMesh mesh = given;
  ASSERT_EQ(mesh.edges.size(), 6u);
  ASSERT_TRUE(check_mesh(mesh));
  const Result<std::size_t> curved = straighten_edges(mesh, 1e-6);
  ASSERT_TRUE(curved) << curved.error().message;
  EXPECT_EQ(*curved, 0u);
  ASSERT_TRUE(add_edge_points(mesh));
  EXPECT_EQ(mesh.vertices.size(), 10u);
  for (std::size_t e = 0; e < 6; ++e) {
    const Eigen::Vector3d middle = 0.5 * (mesh.vertices[mesh.tetrahedra[0][kTetEdges[e][0]]] +
                                          mesh.vertices[mesh.tetrahedra[0][kTetEdges[e][1]]]);
    EXPECT_EQ(mesh.vertices[mesh.edge_points[0][e]], middle) << e;
  }
}

TEST(QuadraticMesh, OfGmshAndOfVtkHaveTheirOrdersOfEdges) {
  const Result<MeshFile> msh = read_text("a.msh", msh_text());
  ASSERT_TRUE(msh) << msh.error().message;
  expect_middles(msh->mesh);
  const Result<MeshFile> vtk = read_text("a.vtk", vtk_text());
  ASSERT_TRUE(vtk) << vtk.error().message;
  expect_middles(vtk->mesh);
}

TEST(QuadraticMesh, WrittenAsVtuIsReadAgain) {
  const testing::TemporaryFolder folder;
  TetMesh mesh = testing::box_mesh({2, 1, 1}, {2, 1, 1});
  ASSERT_TRUE(add_edge_points(mesh));
  const std::vector<QuadraticCell> cells = quadratic_cells(mesh);
  const std::string path = folder.file("a.vtu");
  ASSERT_TRUE(write_modes_vtu(path, mesh.vertices, std::span<const QuadraticCell>(cells),
                              BasisRows::Zero(3 * mesh.vertices.size(), 1),
                              Eigen::VectorXd::Ones(1)));
  Result<MeshFile> read = read_tet_mesh(path);
  ASSERT_TRUE(read) << read.error().message;
  TetMesh again = read->mesh;
  EXPECT_EQ(again.vertices, mesh.vertices);
  EXPECT_EQ(again.tetrahedra, mesh.tetrahedra);
  const Result<std::size_t> curved = straighten_edges(again, 1e-6);
  ASSERT_TRUE(curved);
  EXPECT_EQ(*curved, 0u);
  ASSERT_TRUE(add_edge_points(again));
  EXPECT_EQ(again.edge_points, mesh.edge_points);
}

TEST(QuadraticMesh, CurvedEdgesAreCountedAndStraightened) {
  Result<MeshFile> file = read_text("a.msh", msh_text("1 2 3 4 5 6 7 8 10 9", "0.5 -0.1 0"));
  ASSERT_TRUE(file);
  const Result<std::size_t> curved = straighten_edges(file->mesh, 1e-6);
  ASSERT_TRUE(curved);
  EXPECT_EQ(*curved, 1u);
  EXPECT_EQ(file->mesh.vertices[4], Eigen::Vector3d(0.5, 0, 0));
}

// Two corners change places, and the points of the edges move with their ends.
TEST(QuadraticMesh, InvertedElementsAreTurnedByTheirCorners) {
  const Result<MeshFile> file = read_text("a.msh", msh_text("2 1 3 4 5 7 6 9 10 8"));
  ASSERT_TRUE(file) << file.error().message;
  TetMesh mesh = file->mesh;
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->flipped, 1u);
  expect_middles(file->mesh);
}

void expect_refusal(TetMesh mesh, const std::vector<std::string>& words) {
  const Result<std::size_t> straight = straighten_edges(mesh, 1e-6);
  std::string message;
  if (!straight) {
    message = straight.error().message;
  } else if (const Status added = add_edge_points(mesh); !added) {
    message = added.error().message;
  }
  for (const std::string& word : words)
    EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
}

TEST(QuadraticMesh, MissingDoubledAndWronglySharedPointsAreNamed) {
  const auto mesh_of = [](const std::string& nodes) {
    const Result<MeshFile> file = read_text("a.msh", msh_text(nodes));
    EXPECT_TRUE(file);
    return file ? file->mesh : TetMesh{};
  };
  expect_refusal(mesh_of("1 2 3 4 5 6 7 8 10 5"), {"vertex 4", "two edges"});
  expect_refusal(mesh_of("1 2 3 4 2 6 7 8 10 9"), {"vertex 1", "corner"});
  TetMesh doubled = mesh_of("1 2 3 4 5 6 7 8 10 9");
  doubled.vertices.push_back({0.5, 0, 0});
  doubled.edges.push_back({10, 0, 1});
  expect_refusal(doubled, {"between vertices 0 and 1", "two points", "4", "10"});
  TetMesh missing = mesh_of("1 2 3 4 5 6 7 8 10 9");
  missing.edges.erase(missing.edges.begin() + 2);
  expect_refusal(missing, {"between vertices 0 and 2", "tetrahedron 0", "no point"});
}

TEST(QuadraticMesh, MadeLinearItKeepsTheOrderOfItsCorners) {
  Result<MeshFile> file = read_text("a.msh", msh_text());
  ASSERT_TRUE(file);
  file->mesh.node_sets["side"] = {0, 1, 4};
  EXPECT_EQ(remove_edge_points(file->mesh), 6u);
  EXPECT_EQ(file->mesh.vertices.size(), 4u);
  EXPECT_EQ(file->mesh.node_sets["side"], (std::vector<VertexId>{0, 1}));
  EXPECT_TRUE(check_mesh(file->mesh));
}

BasisData quadratic_basis() {
  BasisData data = testing::tiny_basis();
  data.edges = {{2, 0, 1}, {4, 1, 3}};
  return data;
}

TEST(QuadraticBasis, KeepsItsEdgesInASectionThatOlderReadersRefuse) {
  const auto bytes = encode_basis(quadratic_basis(), BasisEncoding::kFull);
  ASSERT_TRUE(bytes) << bytes.error().message;
  Result<BasisReader> reader = BasisReader::from_memory(*bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->minor_version(), 3);
  EXPECT_EQ(reader->order(), 2);
  const Result<BasisData> data = read_basis(*reader);
  ASSERT_TRUE(data) << data.error().message;
  ASSERT_EQ(data->edges.size(), 2u);
  EXPECT_EQ(data->edges[1].point, 4);
  EXPECT_EQ(data->edges[1].a, 1);
  EXPECT_EQ(data->edges[1].b, 3);
  // A reader of 1.2 refuses every critical section that its table does not know.
  bool critical = false;
  for (const BasisSection& section : reader->sections())
    critical = critical || (section.name == "edge_points" && section.critical);
  EXPECT_TRUE(critical);
}

TEST(QuadraticBasis, EdgesOutOfOrderAreRefused) {
  for (const std::vector<MeshEdge>& edges :
       {std::vector<MeshEdge>{{2, 1, 0}}, {{4, 0, 1}, {2, 0, 1}}, {{2, 0, 9}}}) {
    BasisData data = testing::tiny_basis();
    data.edges = edges;
    const auto bytes = encode_basis(data, BasisEncoding::kFull);
    ASSERT_TRUE(bytes);
    Result<BasisReader> reader = BasisReader::from_memory(*bytes);
    ASSERT_TRUE(reader);
    const Result<BasisData> read = read_basis(*reader);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find("edge_points"), std::string::npos) << read.error().message;
  }
}

}  // namespace
}  // namespace tremolo
