// Every format gives the same mesh, and nothing in a file can do harm.
#include "formats/mesh/mesh_reader.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::MeshVariant;
using testing::TemporaryFolder;

bool is_small_mesh(const TetMesh& mesh) {
  const TetMesh expected = testing::small_mesh();
  return mesh.vertices == expected.vertices && mesh.tetrahedra == expected.tetrahedra;
}

Result<MeshFile> read(const TemporaryFolder& folder, const MeshVariant& variant) {
  for (const auto& [name, bytes] : variant.files) folder.write(name, bytes);
  return read_tet_mesh(folder.file(variant.files[0].first));
}

class EveryVariant : public ::testing::TestWithParam<MeshVariant> {};

TEST_P(EveryVariant, GivesTheSameMeshAndItsSets) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read(folder, GetParam());
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(is_small_mesh(file->mesh));
  EXPECT_EQ(file->mesh.node_sets, GetParam().sets);
  EXPECT_FALSE(file->format.empty());
}

TEST_P(EveryVariant, NotesTheTriangleThatIsSkippedOrServesForASetOnly) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read(folder, GetParam());
  ASSERT_TRUE(file) << file.error().message;
  // In MSH it is what the group "the foot" is made of.
  const bool in_group = GetParam().name[0] == 'M', alone = GetParam().name[1] == 'T';
  EXPECT_EQ(std::count(file->notes.begin(), file->notes.end(), "1 triangles skipped"), alone);
  EXPECT_EQ(std::count(file->notes.begin(), file->notes.end(),
                       "1 triangles are in named sets, for selectors; only tetrahedra are "
                       "computed with"),
            in_group);
}

TEST_P(EveryVariant, WithCrLfLineEndsGivesTheSameMesh) {
  MeshVariant variant = GetParam();
  for (auto& [name, bytes] : variant.files) {
    // A binary file whose bytes were changed like this is damaged, not a variant.
    if (bytes.find('\0') != std::string::npos) return;
    bytes = testing::with_crlf(bytes);
  }
  const TemporaryFolder folder;
  const Result<MeshFile> file = read(folder, variant);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(is_small_mesh(file->mesh));
  EXPECT_EQ(file->mesh.node_sets, variant.sets);
}

TEST_P(EveryVariant, CutAtAnyLengthIsAnErrorOrTheSameMesh) {
  const TemporaryFolder folder;
  ASSERT_TRUE(read(folder, GetParam()));
  for (const auto& [name, bytes] : GetParam().files) {
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      folder.write(name, bytes.substr(0, length));
      const Result<MeshFile> file = read_tet_mesh(folder.file(GetParam().files[0].first));
      if (file) {
        EXPECT_TRUE(is_small_mesh(file->mesh)) << name << " cut at byte " << length;
      } else {
        EXPECT_EQ(file.error().kind, ErrorKind::kContent) << file.error().message;
        EXPECT_NE(file.error().message.find(folder.file("")), std::string::npos);
      }
    }
    folder.write(name, bytes);
  }
}

TEST_P(EveryVariant, WithAnyByteChangedIsReadOrRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(read(folder, GetParam()));
  // Characters that make other numbers, signs and ends, and bits that make huge counts.
  for (const char change : {'9', '-', '\n', '\0', '\x7f', '\xff'}) {
    for (const auto& [name, bytes] : GetParam().files) {
      for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string changed = bytes;
        changed[at] = change;
        folder.write(name, changed);
        const Result<MeshFile> file = read_tet_mesh(folder.file(GetParam().files[0].first));
        if (file) {
          EXPECT_LE(file->mesh.vertices.size(), bytes.size());
          for (const Tetrahedron& tet : file->mesh.tetrahedra)
            for (VertexId v : tet)
              ASSERT_LT(static_cast<std::size_t>(v), file->mesh.vertices.size());
        } else {
          EXPECT_FALSE(file.error().message.empty());
        }
      }
      folder.write(name, bytes);
    }
  }
}

TEST_P(EveryVariant, WithManyBytesChangedIsReadOrRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(read(folder, GetParam()));
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    for (const auto& [name, bytes] : GetParam().files) {
      std::string changed = bytes;
      for (int n = 0; n < 4; ++n)
        changed[random() % changed.size()] = static_cast<char>(random() & 0xff);
      folder.write(name, changed);
    }
    const Result<MeshFile> file = read_tet_mesh(folder.file(GetParam().files[0].first));
    EXPECT_TRUE(file || !file.error().message.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Mesh, EveryVariant, ::testing::ValuesIn(testing::all_mesh_variants()),
                         [](const auto& variant) {
                           std::string name = variant.param.name;
                           for (char& c : name)
                             if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
                           return name;
                         });

Error error_of(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.write(name, bytes));
  return file ? Error{ErrorKind::kSystem, "it was read"} : file.error();
}

TEST(MeshReader, AMissingFileIsASystemError) {
  const TemporaryFolder folder;
  for (const char* name : {"none.msh", "none.vtk", "none.node", "none.ele", "none"}) {
    const Result<MeshFile> file = read_tet_mesh(folder.file(name));
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().kind, ErrorKind::kSystem);
    EXPECT_NE(file.error().message.find(name), std::string::npos) << file.error().message;
  }
}

TEST(MeshReader, AFolderIsASystemError) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.file(""));
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, ErrorKind::kSystem);
}

TEST(MeshReader, AnEmptyFileIsAContentError) {
  for (const char* name : {"a.msh", "a.vtk", "a.vtu", "a.veg", "a"}) {
    const Error error = error_of(name, "");
    EXPECT_EQ(error.kind, ErrorKind::kContent);
    EXPECT_NE(error.message.find("empty"), std::string::npos) << error.message;
  }
}

TEST(MeshReader, SomethingElseIsRefusedWithTheFormatsThatAreRead) {
  for (const char* text : {"solid cube\nfacet normal 0 0 1\n", "\x89PNG\r\n\x1a\n", "v 0 0 0\n",
                           "\n\n\n", "<html></html>"}) {
    const Error error = error_of("picture", text);
    EXPECT_EQ(error.kind, ErrorKind::kContent);
    for (const char* part : {"line 1", ".msh", ".vtk", ".veg", ".node"})
      EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
  }
}

TEST(MeshReader, AnExtensionPromisesAFormat) {
  EXPECT_NE(error_of("a.msh", "hello").message.find("$MeshFormat"), std::string::npos);
  EXPECT_NE(error_of("a.vtk", "hello").message.find("vtk DataFile"), std::string::npos);
  EXPECT_NE(error_of("a.veg", "hello").message.find("*VERTICES"), std::string::npos);
  EXPECT_NE(error_of("a.vtu", "hello").message.find("XML"), std::string::npos);
}

TEST(MeshReader, TheContentCountsMoreThanTheExtension) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.write("a.vtk", testing::msh4_text()));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->format, "MSH 4.1 text");
}

}  // namespace
}  // namespace tremolo
