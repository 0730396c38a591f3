#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "common/mesh/mesh_quality.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {
namespace {

// Parts that are connected through shared faces.
std::size_t parts_joined_by_faces(const TetMesh& mesh) {
  std::vector<std::size_t> parent(mesh.tetrahedra.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&parent](std::size_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  std::map<Triangle, std::size_t> first;
  std::size_t parts = parent.size();
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      Triangle face{};
      for (std::size_t i = 0; i < 3; ++i) face[i] = mesh.tetrahedra[t][(left_out + 1 + i) % 4];
      std::sort(face.begin(), face.end());
      const auto [entry, fresh] = first.try_emplace(face, t);
      if (fresh || root(entry->second) == root(t)) continue;
      parent[root(t)] = root(entry->second);
      --parts;
    }
  return parts;
}

class SampleMesh : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string path =
        std::string(TREMOLO_SOURCE_DIR) + "/assets/meshes/" + GetParam() + ".msh";
    Result<MeshFile> file = read_tet_mesh(path);
    ASSERT_TRUE(file) << file.error().message;
    mesh_ = std::move(file->mesh);
  }
  TetMesh mesh_;
};

TEST_P(SampleMesh, IsOnePieceAndNeedsNoRepair) {
  const Result<MeshReport> report = check_mesh(mesh_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->flipped, 0u);
  EXPECT_EQ(report->unreferenced_vertices, 0u);
  EXPECT_EQ(report->parts, 1u);
}

TEST_P(SampleMesh, HasNoSlivers) {
  const MeshQuality quality = mesh_quality(mesh_);
  // The project's promise for its samples; below 8 degrees elements lock and steps shrink.
  EXPECT_GE(quality.min_dihedral_deg, 10.0);
  EXPECT_GT(quality.min_volume, 0.0);
}

TEST_P(SampleMesh, HasASizeThatPrecomputesInSeconds) {
  EXPECT_GE(mesh_.tetrahedra.size(), 5000u);
  EXPECT_LE(mesh_.tetrahedra.size(), 40000u);
}

TEST_P(SampleMesh, IsNowherePinchedToAVertexOrAnEdge) {
  EXPECT_EQ(parts_joined_by_faces(mesh_), 1u);
}

INSTANTIATE_TEST_SUITE_P(All, SampleMesh,
                         ::testing::Values("beam", "basket", "bridge", "horse", "tower", "heart"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace tremolo
