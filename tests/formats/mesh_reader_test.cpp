// Every format gives the same mesh, and nothing in a file can do harm.

#include "formats/mesh/mesh_reader.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "common/mesh/mesh_quality.h"
#include "formats/file/scanner.h"
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

// Editors and exporters put a byte-order mark before UTF-8. tests/formats/surface_dialects_test.cpp
// has those of surfaces.

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
