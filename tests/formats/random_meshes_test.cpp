// Properties of every mesh, tested on random meshes: a written mesh is read back, and the checks
// find the changes made to it.
#include <map>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "common/mesh/surface_mesh.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/meshes/mesh_writers.h"
#include "tests/support/meshes/random_mesh.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::NamedFiles;
using testing::Random;
using testing::TemporaryFolder;

constexpr int kMeshes = 25;

TetMesh any_mesh(Random& random) {
  TetMesh mesh = testing::random_box(random);
  testing::shuffle_corners(mesh, false, random);
  testing::add_unused_vertices(mesh, random);
  return mesh;
}

TEST(RandomMeshes, EveryFormatGivesBackWhatWasWrittenToTheLastBit) {
  using Writer = NamedFiles (*)(const TetMesh&);
  const std::map<std::string, Writer> writers{
      {"MSH 2.2", testing::as_msh2}, {"MSH 4.1", testing::as_msh4}, {"VTK", testing::as_vtk},
      {"VTU", testing::as_vtu},      {"VegaFEM", testing::as_veg},  {"TetGen", testing::as_tetgen}};
  Random random(1);
  const TemporaryFolder folder;
  for (int n = 0; n < kMeshes; ++n) {
    const TetMesh mesh = any_mesh(random);
    for (const auto& [name, write] : writers) {
      const NamedFiles files = write(mesh);
      for (const auto& [file, bytes] : files) folder.write(file, bytes);
      const Result<MeshFile> read = read_tet_mesh(folder.file(files.front().first));
      ASSERT_TRUE(read) << name << ", mesh " << n << ": " << read.error().message;
      EXPECT_EQ(read->mesh.vertices, mesh.vertices) << name << ", mesh " << n;
      EXPECT_EQ(read->mesh.tetrahedra, mesh.tetrahedra) << name << ", mesh " << n;
      EXPECT_TRUE(read->notes.empty()) << name << ": " << read->notes.front();
    }
    ASSERT_TRUE(write_msh(folder.file("own.msh"), mesh));
    const Result<MeshFile> own = read_tet_mesh(folder.file("own.msh"));
    ASSERT_TRUE(own) << own.error().message;
    EXPECT_EQ(own->mesh.vertices, mesh.vertices);
    EXPECT_EQ(own->mesh.tetrahedra, mesh.tetrahedra);
  }
}

TEST(RandomMeshes, TheCheckFindsWhatWasDoneToThem) {
  Random random(2);
  for (int n = 0; n < kMeshes; ++n) {
    const TetMesh whole = testing::random_box(random);
    double volume = 0;
    for (const Tetrahedron& tet : whole.tetrahedra) {
      ASSERT_GT(signed_volume(whole, tet), 0);
      volume += signed_volume(whole, tet);
    }
    TetMesh mesh = whole;
    const std::size_t turned = testing::shuffle_corners(mesh, false, random);
    const std::size_t unused = testing::add_unused_vertices(mesh, random);
    const Result<MeshReport> report = check_mesh(mesh);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->flipped, turned);
    EXPECT_EQ(report->unreferenced_vertices, unused);
    EXPECT_EQ(report->parts, 1u);
    EXPECT_NEAR(report->volume, volume, 1e-13 * volume);  // other corners: other rounding
    for (const Tetrahedron& tet : mesh.tetrahedra) EXPECT_GT(signed_volume(mesh, tet), 0);
  }
}

TEST(RandomMeshes, TwoBoxesApartAreTwoParts) {
  Random random(3);
  for (int n = 0; n < kMeshes; ++n) {
    TetMesh mesh = testing::random_box(random);
    const TetMesh other = testing::random_box(random);
    testing::join(mesh, other, {10, 0, 0});
    mesh = testing::renumbered(mesh, testing::random_permutation(mesh.vertices.size(), random));
    const Result<MeshReport> report = check_mesh(mesh);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->parts, 2u);
  }
}

TEST(RandomMeshes, TheBoundaryIsClosedAndHoldsTheVolume) {
  Random random(4);
  for (int n = 0; n < kMeshes; ++n) {
    TetMesh mesh = any_mesh(random);
    const Result<MeshReport> report = check_mesh(mesh);
    ASSERT_TRUE(report) << report.error().message;
    const BoundarySurface surface = boundary_surface(mesh);
    std::map<std::pair<VertexId, VertexId>, int> edges;
    double volume = 0;
    for (const Triangle& t : surface.triangles) {
      for (int side = 0; side < 3; ++side) ++edges[{t[side], t[(side + 1) % 3]}];
      const auto x = [&](int corner) { return mesh.vertices[surface.vertex_ids[t[corner]]]; };
      volume += x(0).dot(x(1).cross(x(2))) / 6;
    }
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);  // each direction once: closed and oriented
      EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
    EXPECT_NEAR(volume, report->volume, 1e-12 * report->volume);  // a few hundred terms
  }
}

}  // namespace
}  // namespace tremolo
