#include "formats/surface/surface_writer.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/support/meshes/box_mesh.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::TemporaryFolder;

SurfaceMesh box_surface() {
  const TetMesh mesh = testing::box_mesh({3, 2, 2}, {0.3, 0.2, 0.25});
  const BoundarySurface boundary = boundary_surface(mesh);
  SurfaceMesh surface;
  surface.triangles = boundary.triangles;
  for (VertexId v : boundary.vertex_ids) surface.vertices.push_back(mesh.vertices[v]);
  return surface;
}

std::string read_all(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Floats and nine printed digits keep a coordinate of this size to better than this.
constexpr double kFloatError = 1e-7;

void expect_same(const SurfaceMesh& found, const SurfaceMesh& expected) {
  EXPECT_EQ(found.triangles, expected.triangles);
  ASSERT_EQ(found.vertices.size(), expected.vertices.size());
  for (std::size_t v = 0; v < found.vertices.size(); ++v)
    EXPECT_LE((found.vertices[v] - expected.vertices[v]).norm(), kFloatError) << v;
}

TEST(SurfaceWriter, AnObjHoldsEveryVertexAndTriangleCountedFromOne) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_surface(folder.file("box.obj"), box_surface()));
  std::ifstream stream(folder.file("box.obj"));
  SurfaceMesh found;
  std::string word;
  while (stream >> word) {
    if (word == "v") {
      Eigen::Vector3d x;
      stream >> x[0] >> x[1] >> x[2];
      found.vertices.push_back(x);
    } else {
      ASSERT_EQ(word, "f");
      Triangle t;
      stream >> t[0] >> t[1] >> t[2];
      for (VertexId& v : t) --v;
      found.triangles.push_back(t);
    }
  }
  expect_same(found, box_surface());
}

TEST(SurfaceWriter, APlyHoldsTwelveBytesAVertexAndThirteenATriangle) {
  const TemporaryFolder folder;
  const SurfaceMesh surface = box_surface();
  ASSERT_TRUE(write_surface(folder.file("box.ply"), surface));
  const std::string bytes = read_all(folder.file("box.ply"));
  const std::string last_line = "end_header\n";
  const std::size_t start = bytes.find(last_line) + last_line.size();
  ASSERT_EQ(bytes.size() - start, 12 * surface.vertices.size() + 13 * surface.triangles.size());
  SurfaceMesh found;
  const char* at = bytes.data() + start;
  for (std::size_t v = 0; v < surface.vertices.size(); ++v, at += 12) {
    float x[3];
    std::memcpy(x, at, 12);
    found.vertices.emplace_back(x[0], x[1], x[2]);
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t, at += 13) {
    EXPECT_EQ(*at, 3);
    Triangle corners;
    std::memcpy(corners.data(), at + 1, 12);
    found.triangles.push_back(corners);
  }
  expect_same(found, surface);
  EXPECT_NE(bytes.find("element vertex " + std::to_string(surface.vertices.size()) + "\n"),
            std::string::npos);
  EXPECT_NE(bytes.find("element face " + std::to_string(surface.triangles.size()) + "\n"),
            std::string::npos);
}

TEST(SurfaceWriter, APovMeshHasANormalForEachVertexAndBalancedBraces) {
  const TemporaryFolder folder;
  const SurfaceMesh surface = box_surface();
  ASSERT_TRUE(write_surface(folder.file("box.inc"), surface));
  const std::string text = read_all(folder.file("box.inc"));
  EXPECT_EQ(text.find("#declare Surface = mesh2 {"), 0u);
  const auto count = [&](char c) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), c));
  };
  EXPECT_EQ(count('{'), count('}'));
  EXPECT_EQ(count('<'), 2 * surface.vertices.size() + surface.triangles.size());
  const auto number_after = [&](const std::string& word) {
    std::size_t value = 0;
    const std::size_t at = text.find(word);
    if (at != std::string::npos) std::istringstream(text.substr(at + word.size())) >> value;
    return value;
  };
  EXPECT_EQ(number_after("vertex_vectors {"), surface.vertices.size());
  EXPECT_EQ(number_after("normal_vectors {"), surface.vertices.size());
  EXPECT_EQ(number_after("face_indices {"), surface.triangles.size());
}

TEST(SurfaceWriter, AnUnknownEndingIsAUsageErrorAndWritesNothing) {
  const TemporaryFolder folder;
  for (const char* name : {"box.stl", "box", ".obj.txt"}) {
    const Status written = write_surface(folder.file(name), box_surface());
    ASSERT_FALSE(written) << name;
    EXPECT_EQ(written.error().kind, ErrorKind::kUsage);
    EXPECT_FALSE(std::filesystem::exists(folder.file(name)));
  }
}

TEST(SurfaceWriter, AFolderThatIsNotThereIsASystemError) {
  const TemporaryFolder folder;
  for (const char* name : {"none/box.obj", "none/box.ply", "none/box.inc"}) {
    const Status written = write_surface(folder.file(name), box_surface());
    ASSERT_FALSE(written) << name;
    EXPECT_EQ(written.error().kind, ErrorKind::kSystem);
  }
}

TEST(VertexNormals, AreUnitVectorsThatPointOutOfABox) {
  const SurfaceMesh surface = box_surface();
  const Eigen::Vector3d centre(0.15, 0.1, 0.125);
  const auto normals = vertex_normals(surface);
  ASSERT_EQ(normals.size(), surface.vertices.size());
  for (std::size_t v = 0; v < normals.size(); ++v) {
    EXPECT_NEAR(normals[v].norm(), 1, 1e-15) << v;  // one division and one root round
    EXPECT_GT(normals[v].dot(surface.vertices[v] - centre), 0) << v;
  }
}

TEST(VertexNormals, AreWeightedByAreaAndZeroWhereThereIsNoTriangle) {
  SurfaceMesh surface;
  // Two faces at a right angle along the edge 0-1; the one in z = 0 has three times the area.
  surface.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 3, 0}, {0, 0, 1}, {5, 5, 5}};
  surface.triangles = {{0, 1, 2}, {0, 1, 3}};
  const auto normals = vertex_normals(surface);
  const Eigen::Vector3d expected = Eigen::Vector3d(0, -1, 3).normalized();
  EXPECT_LE((normals[0] - expected).norm(), 1e-15);  // rounding of one normalisation
  EXPECT_EQ(normals[2], Eigen::Vector3d::UnitZ());
  EXPECT_EQ(normals[4], Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace tremolo
