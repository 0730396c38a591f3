// Tetrahedra as other programs write them: the same body, sets and regions from every form.

#include "tests/support/meshes/writer_forms.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "common/mesh/edge_points.h"
#include "common/mesh/mesh_check.h"
#include "formats/file/base64.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vtk/vtu_writer.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/small_mesh.h"
#include "tests/support/run_program.h"
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

namespace {

TetMesh bent_box() {
  TetMesh mesh = testing::box_mesh({4, 3, 2}, {0.4, 0.3, 0.2});
  // Irrational coordinates use every bit of a double.
  for (Eigen::Vector3d& x : mesh.vertices) x.z() += std::sin(7 * x.x() + 3 * x.y()) / 30;
  return mesh;
}

TEST(MshWriter, WhatIsWrittenIsReadBackToTheLastBit) {
  const TemporaryFolder folder;
  const TetMesh mesh = bent_box();
  ASSERT_TRUE(write_msh(folder.file("box.msh"), mesh));
  const auto read = read_tet_mesh(folder.file("box.msh"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->format, "MSH 2.2 binary");
  EXPECT_EQ(read->mesh.vertices, mesh.vertices);
  EXPECT_EQ(read->mesh.tetrahedra, mesh.tetrahedra);
  EXPECT_TRUE(read->mesh.node_sets.empty());
  EXPECT_TRUE(read->notes.empty());
}

TEST(MshWriter, AFileTakes28BytesAVertexAnd20ATetrahedron) {
  const TemporaryFolder folder;
  const TetMesh one = testing::small_mesh(), box = bent_box();
  ASSERT_TRUE(write_msh(folder.file("one.msh"), one));
  ASSERT_TRUE(write_msh(folder.file("box.msh"), box));
  const auto size = [&](const char* name) {
    return static_cast<std::int64_t>(std::filesystem::file_size(folder.file(name)));
  };
  const auto payload = [](const TetMesh& mesh) {
    return static_cast<std::int64_t>(28 * mesh.vertices.size() + 20 * mesh.tetrahedra.size());
  };
  // Beside the payload only the two counts differ: "60" for "5" and "144" for "2".
  EXPECT_EQ(size("box.msh") - payload(box), size("one.msh") - payload(one) + 1 + 2);
}

TEST(MshWriter, AnOlderFileIsReplacedAsAWhole) {
  const TemporaryFolder folder;
  const std::string path = folder.write("mesh.msh", std::string(100000, 'x'));
  ASSERT_TRUE(write_msh(path, testing::small_mesh()));
  const auto read = read_tet_mesh(path);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.tetrahedra, testing::small_mesh().tetrahedra);
}

TEST(MshWriter, AFolderThatIsNotThereIsASystemErrorThatNamesThePath) {
  const TemporaryFolder folder;
  const Status written = write_msh(folder.file("none/mesh.msh"), testing::small_mesh());
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind, ErrorKind::kSystem);
  EXPECT_NE(written.error().message.find("none/mesh.msh"), std::string::npos)
      << written.error().message;
}

}  // namespace

// Modes for ParaView: this project's own reader reads the written file.

namespace {

// The numbers of the DataArray of this name.
template <class T>
std::vector<T> array(const std::string& file, const std::string& name) {
  const std::size_t start = file.find('>', file.find("Name=\"" + name + "\"")) + 1;
  const std::string bytes = decode_base64(file.substr(start, file.find('<', start) - start)).bytes;
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof(size));
  EXPECT_EQ(size, bytes.size() - sizeof(size)) << name;
  std::vector<T> values((bytes.size() - sizeof(size)) / sizeof(T));
  std::memcpy(values.data(), bytes.data() + sizeof(size), values.size() * sizeof(T));
  return values;
}

TEST(Base64, IsWhatTheStandardSaysAndIsReadBack) {
  // RFC 4648, section 10.
  EXPECT_EQ(encode_base64(""), "");
  EXPECT_EQ(encode_base64("f"), "Zg==");
  EXPECT_EQ(encode_base64("fo"), "Zm8=");
  EXPECT_EQ(encode_base64("foo"), "Zm9v");
  EXPECT_EQ(encode_base64("foobar"), "Zm9vYmFy");
  std::string all;
  for (int value = 0; value < 256; ++value) {
    all += static_cast<char>(value);
    EXPECT_EQ(decode_base64(encode_base64(all)).bytes, all);
  }
}

TEST(ModesVtu, HasTheTetrahedraAndAVectorAPointForEveryMode) {
  const TemporaryFolder folder;
  const TetMesh mesh = testing::small_mesh();
  const BasisRows rows = BasisRows::Random(15, 3);
  const Eigen::Vector3d lambda(4.0, 9.0, 100.0);
  const Status written =
      write_modes_vtu(folder.file("a.vtu"), mesh.vertices,
                      std::span<const Tetrahedron>(mesh.tetrahedra), rows, lambda);
  ASSERT_TRUE(written) << written.error().message;
  const Result<MeshFile> file = read_tet_mesh(folder.file("a.vtu"));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->mesh.vertices, mesh.vertices);
  EXPECT_EQ(file->mesh.tetrahedra, mesh.tetrahedra);
  const std::string text = testing::slurp(folder.file("a.vtu"));
  for (Eigen::Index mode = 0; mode < 3; ++mode) {
    const auto values = array<double>(text, "mode_0" + std::to_string(mode + 1));
    ASSERT_EQ(values.size(), 15u);
    for (Eigen::Index row = 0; row < 15; ++row) EXPECT_EQ(values[row], rows(row, mode));
  }
  const auto hertz = array<double>(text, "frequency_hz");
  ASSERT_EQ(hertz.size(), 3u);
  EXPECT_DOUBLE_EQ(hertz[2], 10.0 / (2.0 * std::numbers::pi));
}

TEST(ModesVtu, TrianglesAreCellsOfThreeCorners) {
  const TemporaryFolder folder;
  const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  const std::vector<Triangle> triangles{{0, 1, 2}, {1, 3, 2}};
  // A hundred modes: the names sort as the numbers do.
  const BasisRows rows = BasisRows::Random(12, 100);
  ASSERT_TRUE(write_modes_vtu(folder.file("a.vtu"), points, std::span<const Triangle>(triangles),
                              rows, Eigen::VectorXd::Ones(100)));
  const std::string text = testing::slurp(folder.file("a.vtu"));
  EXPECT_EQ(array<std::int32_t>(text, "connectivity"),
            (std::vector<std::int32_t>{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(array<std::int64_t>(text, "offsets"), (std::vector<std::int64_t>{3, 6}));
  EXPECT_EQ(array<std::uint8_t>(text, "types"), (std::vector<std::uint8_t>{5, 5}));
  EXPECT_NE(text.find("Name=\"mode_001\""), std::string::npos);
  EXPECT_NE(text.find("Name=\"mode_100\""), std::string::npos);
  // Well-formed, and understood as far as our reader goes.
  const Result<MeshFile> file = read_tet_mesh(folder.file("a.vtu"));
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("expected tetrahedra, found 4 vertices and 2 triangles"),
            std::string::npos)
      << file.error().message;
}

TEST(ModesVtu, AnOutputThatCannotBeWrittenIsASystemError) {
  const Status status = write_modes_vtu("/nowhere/a.vtu", {}, std::span<const Triangle>(),
                                        BasisRows(0, 1), Eigen::VectorXd::Ones(1));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, ErrorKind::kSystem);
}

}  // namespace
}  // namespace tremolo
