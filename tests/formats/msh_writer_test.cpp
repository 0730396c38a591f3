#include "formats/msh/msh_writer.h"

#include <cmath>
#include <cstdint>
#include <filesystem>

#include <gtest/gtest.h>

#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/small_mesh.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::TemporaryFolder;

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
}  // namespace tremolo
