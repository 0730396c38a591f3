// Editors and exporters put a byte-order mark before UTF-8. tests/formats/surface_dialects_test.cpp
// has those of surfaces.
#include <string>

#include <gtest/gtest.h>

#include "formats/file/text_scanner.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

TEST(ByteOrderMark, IsSkippedInEveryTextOfTetrahedra) {
  std::size_t read = 0;
  for (const testing::MeshVariant& variant : testing::all_mesh_variants()) {
    const testing::TemporaryFolder folder;
    bool text = true;
    for (const auto& [name, bytes] : variant.files) text &= bytes.find('\0') == std::string::npos;
    if (!text) continue;
    for (const auto& [name, bytes] : variant.files)
      folder.write(name, std::string(kByteOrderMark) + bytes);
    const Result<MeshFile> file = read_tet_mesh(folder.file(variant.files[0].first));
    ASSERT_TRUE(file) << variant.name << ": " << file.error().message;
    EXPECT_EQ(file->mesh.vertices, testing::small_mesh().vertices) << variant.name;
    EXPECT_EQ(file->mesh.tetrahedra, testing::small_mesh().tetrahedra) << variant.name;
    ++read;
  }
  EXPECT_GE(read, 6U) << "MSH 2 and 4, VTK, VTU, VEG, TetGen";
}

TEST(ByteOrderMark, CountsForNoLineAndNoToken) {
  TextScanner scanner("\xef\xbb\xbf\nfirst 2x", "a.txt");
  EXPECT_EQ(scanner.token(), "first");
  int number = 0;
  EXPECT_FALSE(scanner.read(number, "a number"));
  EXPECT_NE(scanner.error().message.find("line 2"), std::string::npos) << scanner.error().message;
  EXPECT_EQ(without_mark("\xef\xbb\xbf"), "");
  EXPECT_EQ(without_mark("\xef\xbb"), "\xef\xbb");
}

}  // namespace
}  // namespace tremolo
