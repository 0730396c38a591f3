// Node ids, groups and sets beyond what the small mesh shows, and lists of ids.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "formats/basis/selector_reader.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::replaced;
using testing::TemporaryFolder;
using Ids = std::vector<VertexId>;

TEST(MshGroups, WithoutANameAreCalledByDimensionAndTag) {
  const TemporaryFolder folder;
  for (const std::string& text : {testing::msh2_text(), testing::msh4_text()}) {
    const std::size_t names = text.find("$PhysicalNames");
    const std::size_t end = text.find("$EndPhysicalNames\n") + 18;
    const Result<MeshFile> file =
        read_tet_mesh(folder.write("a.msh", text.substr(0, names) + text.substr(end)));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_EQ(file->mesh.node_sets.at("surface 8"), (Ids{0, 1, 2}));
    EXPECT_EQ(file->mesh.node_sets.at("volume 4"), (Ids{0, 1, 2, 3, 4}));
  }
}

TEST(MshGroups, WithoutANameAreToldApartFromOneOfThatName) {
  const TemporaryFolder folder;
  // The surface's group 8 is called as the volume's group 4 would be without its name.
  const std::string text = testing::msh2_text();
  const std::size_t names = text.find("$PhysicalNames");
  const std::size_t end = text.find("$EndPhysicalNames\n");
  const Result<MeshFile> file = read_tet_mesh(folder.write(
      "a.msh", text.substr(0, names) + "$PhysicalNames\n1\n2 8 \"volume 4\"\n" + text.substr(end)));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->mesh.node_sets.at("volume 4"), (Ids{0, 1, 2}));
  EXPECT_EQ(file->mesh.node_sets.at("volume 4 (unnamed)"), (Ids{0, 1, 2, 3, 4}));
}

TEST(MshGroups, ATetrahedronOfTwoGroupsIsTakenOnce) {
  // Version 2 writes it once for each group; the same group twice stays a duplicate.
  const TemporaryFolder folder;
  const std::string three = replaced(testing::msh2_text(), "$Elements\n3", "$Elements\n4");
  const Result<MeshFile> grouped = read_tet_mesh(
      folder.write("a.msh", replaced(three, "$EndElements", "9 4 2 5 1 2 9 5 7\n$EndElements")));
  ASSERT_TRUE(grouped) << grouped.error().message;
  EXPECT_EQ(grouped->mesh.tetrahedra, testing::small_mesh().tetrahedra);
  EXPECT_EQ(grouped->mesh.node_sets.at("volume 5"), (Ids{0, 1, 2, 3}));
  const Result<MeshFile> doubled = read_tet_mesh(
      folder.write("a.msh", replaced(three, "$EndElements", "9 4 2 4 1 2 9 5 7\n$EndElements")));
  ASSERT_TRUE(doubled);
  EXPECT_EQ(doubled->mesh.tetrahedra.size(), 3u);
}

TEST(IdList, TakesAnySeparatorsAndComments) {
  const TemporaryFolder folder;
  const Result<Ids> ids =
      read_id_list(folder.write("ids.txt", "# left end\r\n7, 3\n0\t9 # last\n\n3"), 10);
  ASSERT_TRUE(ids) << ids.error().message;
  EXPECT_EQ(*ids, (Ids{0, 3, 7, 9}));
}

TEST(IdList, NamesTheLineOfWhatIsNoId) {
  const TemporaryFolder folder;
  for (const char* text :
       {"1\n10\n", "1\n-1\n", "1\n2.5\n", "1\nx\n", "1\n99999999999999999999\n"}) {
    const Result<Ids> ids = read_id_list(folder.write("ids.txt", text), 10);
    ASSERT_FALSE(ids) << text;
    EXPECT_EQ(ids.error().kind, ErrorKind::kContent);
    EXPECT_NE(ids.error().message.find("ids.txt, line 2"), std::string::npos)
        << ids.error().message;
  }
}

TEST(IdList, WithoutIdsIsRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_id_list(folder.write("ids.txt", "# none\n"), 10).error().kind,
            ErrorKind::kContent);
  EXPECT_EQ(read_id_list(folder.write("ids.txt", ""), 10).error().kind, ErrorKind::kContent);
  EXPECT_EQ(read_id_list(folder.file("missing"), 10).error().kind, ErrorKind::kSystem);
}

TEST(ResolveSelector, ReadsFilesAndLeavesTheRestToTheMesh) {
  const TemporaryFolder folder;
  const TetMesh mesh = testing::small_mesh();
  const Result<Ids> listed = resolve_selector("file:" + folder.write("ids.txt", "4 1"), mesh);
  ASSERT_TRUE(listed) << listed.error().message;
  EXPECT_EQ(*listed, (Ids{1, 4}));
  const Result<Ids> below = resolve_selector("z<0.5", mesh);
  ASSERT_TRUE(below);
  EXPECT_EQ(*below, (Ids{0, 1, 2}));
  EXPECT_EQ(resolve_selector("file:" + folder.file("missing"), mesh).error().kind,
            ErrorKind::kSystem);
  EXPECT_EQ(resolve_selector("file:" + folder.write("ids.txt", "5"), mesh).error().kind,
            ErrorKind::kContent);
  EXPECT_EQ(resolve_selector("x<", mesh).error().kind, ErrorKind::kUsage);
}

}  // namespace
}  // namespace tremolo
