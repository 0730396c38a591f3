// Modes for ParaView: this project's own reader reads the written file.
#include "formats/vtk/vtu_writer.h"

#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "formats/file/base64.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/small_mesh.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

using testing::TemporaryFolder;

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
