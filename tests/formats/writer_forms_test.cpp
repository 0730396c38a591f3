// Tetrahedra as other programs write them: the same body, sets and regions from every form.
#include "tests/support/meshes/writer_forms.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "common/mesh/edge_points.h"
#include "common/mesh/mesh_check.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::TemporaryFolder;
using testing::WriterForm;

// Coordinates of Gmsh's Nastran have six decimals, those of instances a rounding of their sum.
constexpr double kRounding = 1e-6;

class EveryForm : public ::testing::TestWithParam<WriterForm> {
 protected:
  void SetUp() override {
    for (const auto& [name, bytes] : GetParam().files) folder_.write(name, bytes);
    Result<MeshFile> file = read_tet_mesh(folder_.file(GetParam().files[0].first));
    ASSERT_TRUE(file) << file.error().message;
    mesh_ = std::move(file->mesh);
    if (!GetParam().quadratic) return;
    ASSERT_TRUE(straighten_edges(mesh_, 1e-9));
    ASSERT_EQ(mesh_.edges.size(), mesh_edges(mesh_).size());
    remove_edge_points(mesh_);
  }
  double volume_of(const std::string& region) const {
    double volume = 0;
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t)
      if (mesh_.region_of[t] >= 0 && mesh_.region_names[mesh_.region_of[t]] == region)
        volume += signed_volume(mesh_, mesh_.tetrahedra[t]);
    return volume;
  }
  TemporaryFolder folder_;
  TetMesh mesh_;
};

TEST_P(EveryForm, IsTheBarInOnePieceWithoutInvertedTetrahedra) {
  const testing::FormBar bar;
  ASSERT_EQ(mesh_.tetrahedra.size(), bar.mesh.tetrahedra.size());
  const Result<MeshReport> report = check_mesh(mesh_);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->parts, 1u);
  EXPECT_EQ(report->flipped, 0u);
  EXPECT_EQ(report->unreferenced_vertices, 0u);
  EXPECT_NEAR(report->volume, 0.125, kRounding);
  EXPECT_EQ(mesh_.vertices.size(), bar.mesh.vertices.size());
  const BoundingBox box = bounding_box(mesh_.vertices);
  EXPECT_TRUE(box.low.isZero(kRounding));
  EXPECT_TRUE(box.high.isApprox(Eigen::Vector3d(1, 0.5, 0.25), kRounding));
}

TEST_P(EveryForm, HasTheVerticesOfTheFootAsASet) {
  if (GetParam().foot.empty()) return;
  const auto found = mesh_.node_sets.find(GetParam().foot);
  ASSERT_NE(found, mesh_.node_sets.end());
  EXPECT_EQ(found->second, testing::FormBar().foot);
}

TEST_P(EveryForm, HasTheHalvesAsRegions) {
  const std::vector<std::string>& names = GetParam().regions;
  if (names.empty()) return;
  EXPECT_TRUE(std::is_permutation(mesh_.region_names.begin(), mesh_.region_names.end(),
                                  names.begin(), names.end()));
  for (const std::string& name : names)
    EXPECT_NEAR(volume_of(name), 0.125 / static_cast<double>(names.size()), kRounding) << name;
}

std::string name_of(const ::testing::TestParamInfo<WriterForm>& info) {
  std::string name;
  for (const char c : info.param.writer + " " + info.param.form)
    name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Writers, EveryForm, ::testing::ValuesIn(testing::all_writer_forms()),
                         name_of);

TEST(WriterForms, AreFortyFilesOfTenWriters) {
  std::set<std::string> writers;
  for (const WriterForm& form : testing::all_writer_forms()) writers.insert(form.writer);
  EXPECT_GE(writers.size(), 10u);
  EXPECT_GE(testing::all_writer_forms().size(), 40u);
}

}  // namespace
}  // namespace tremolo
