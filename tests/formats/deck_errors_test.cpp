// Errors about Abaqus and Nastran files give the name and the line.

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/meshes/writer_forms.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

using testing::replaced;
using testing::TemporaryFolder;

void expect_refused(const std::string& name, const std::string& text,
                    const std::vector<std::string>& parts) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.write(name, text));
  ASSERT_FALSE(file) << name << ": " << parts.front();
  EXPECT_EQ(file.error().kind, ErrorKind::kContent);
  for (const std::string& part : parts)
    EXPECT_NE(file.error().message.find(part), std::string::npos)
        << part << " is not in: " << file.error().message;
}

const std::string kInpTet =
    "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4\n7, 1, 2, 3, 4\n";

TEST(InpErrors, NameTheKeywordAndWhatToDo) {
  expect_refused("a.inp", kInpTet + "*NGEN\n1, 4, 1\n", {"line 8", "*NGEN", "write the nodes out"});
  expect_refused("a.inp", kInpTet + "*ELGEN\n7, 2\n", {"*ELGEN", "write the elements out"});
  expect_refused("a.inp", replaced(kInpTet, "*NODE", "*NODE, SYSTEM=C"), {"line 1", "SYSTEM=C"});
  expect_refused("a.inp", replaced(kInpTet, "C3D4", "C3D7"), {"line 6", "C3D10", "TYPE=C3D7"});
  expect_refused("a.inp", replaced(kInpTet, "7, 1, 2, 3, 4", "7, 1, 2, 3, 9"),
                 {"element 7", "node 9"});
  expect_refused("a.inp", replaced(kInpTet, "7, 1, 2, 3, 4", "7, 1, 2, 3"),
                 {"element 7", "expected 4 nodes, found 3"});
  expect_refused("a.inp", replaced(kInpTet, "4, 0, 0, 1", "3, 0, 0, 1"), {"node id 3", "twice"});
  expect_refused("a.inp", replaced(kInpTet, "0, 0, 1\n*", "0, 0, nan\n*"), {"finite"});
  expect_refused("a.inp", kInpTet + "*NSET, NSET=s\nunknown\n", {"line 9", "`unknown`"});
  expect_refused("a.inp", kInpTet + "*NSET, NSET=s, GENERATE\n1, 4000000000, 1\n",
                 {"line 9", "a file of this size"});
  expect_refused("a.inp", kInpTet + "*NSET, NSET=s, GENERATE\n5, 1, 1\n", {"line 9", "ascend"});
  expect_refused("a.inp",
                 "*PART, NAME=p\n" + kInpTet +
                     "*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=i, PART=q\n*END INSTANCE\n",
                 {"instance `i`", "part `q`"});
  expect_refused("a.inp", "no keyword\n", {"expected tetrahedra"});
}

TEST(InpInstances, OfOnePartAreTurnedAboutTheirAxisBehindTheirTranslation) {
  const TemporaryFolder folder;
  // A quarter turn about the axis through (1, 0, 0) along z, of what was moved by 1 along x.
  const Result<MeshFile> file = read_tet_mesh(folder.write(
      "a.inp", "*PART, NAME=p\n" + kInpTet +
                   "*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=i, PART=p\n*END INSTANCE\n"
                   "*INSTANCE, NAME=j, PART=P\n1, 0, 0\n1, 0, 0, 1, 0, 2, 90\n*END INSTANCE\n"
                   "*NSET, NSET=tip, INSTANCE=j\n2\n*END ASSEMBLY\n"));
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->mesh.vertices.size(), 8u);
  EXPECT_EQ(file->mesh.tetrahedra.size(), 2u);
  EXPECT_TRUE(file->mesh.vertices[5].isApprox(Eigen::Vector3d(1, 1, 0), 1e-15));
  EXPECT_EQ(file->mesh.node_sets.at("tip"), std::vector<VertexId>{5});
}

TEST(InpMaterials, OfSectionsAreTheRegions) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.write("a.inp", testing::inp_of_cae()));
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->materials.size(), 2u);
  for (const FileMaterial& material : file->materials) {
    EXPECT_EQ(material.problem, "");
    EXPECT_EQ(material.material, (Material{1e6, 0.3, 1000}));
  }
}

const std::string kBdfTet =
    "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
    "CTETRA,7,3,1,2,3,4\nENDDATA\n";

TEST(BdfErrors, NameTheCardAndItsLine) {
  expect_refused("a.bdf", replaced(kBdfTet, "GRID,4,,", "GRID,4,2,"),
                 {"line 5", "GRID", "CP 0", "`2`"});
  expect_refused("a.bdf", replaced(kBdfTet, "GRID,4,,0.", "GRID,4,,o."), {"line 5", "coordinate"});
  expect_refused("a.bdf", replaced(kBdfTet, "1,2,3,4\n", "1,2,3,9\n"),
                 {"line 6", "element 7", "9"});
  expect_refused("a.bdf", replaced(kBdfTet, "1,2,3,4\n", "1,2,3\n"), {"line 6", "an empty field"});
  expect_refused("a.bdf", replaced(kBdfTet, "1,2,3,4\n", "1,2,3,4,1\n"),
                 {"line 6", "4 or 10 nodes"});
  expect_refused("a.bdf", replaced(kBdfTet, "ENDDATA\n", ""), {"ENDDATA", "cut off"});
  expect_refused("a.bdf", replaced(kBdfTet, "BEGIN BULK\n", "BEGIN BULK\nINCLUDE 'b.bdf'\n"),
                 {"line 2", "INCLUDE"});
  expect_refused("a.bdf", replaced(kBdfTet, "BEGIN BULK\n", "BEGIN BULK\n+,1,2\n"),
                 {"line 2", "continuation"});
  expect_refused("a.bdf", replaced(kBdfTet, "BEGIN", "SET 3 = 1 THRU x\nBEGIN"),
                 {"line 1", "SET 3"});
}

TEST(BdfNumbers, NeedNoLetterBeforeTheirExponent) {
  const TemporaryFolder folder;
  const std::string text = replaced(kBdfTet, "GRID,2,,1.,0.,0.", "GRID,2,,1.25+2,-2.5-1,+.5D+1");
  const Result<MeshFile> file = read_tet_mesh(folder.write("a.bdf", text));
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->mesh.vertices[1], Eigen::Vector3d(125, -0.25, 5));
}

// Files without a count have no mark of a cut between two lines, but at every length the reader
// either refuses or returns a part of the mesh.
TEST(Decks, CutAtAnyLengthAreReadOrRefused) {
  const TemporaryFolder folder;
  for (const testing::WriterForm& form : testing::deck_forms()) {
    const auto& [name, bytes] = form.files.front();
    if (!name.ends_with(".inp") && !name.ends_with(".bdf")) continue;
    for (std::size_t length = 0; length < bytes.size(); length += 7) {
      const Result<MeshFile> file = read_tet_mesh(folder.write(name, bytes.substr(0, length)));
      if (!file) {
        // The name of an included file that is cut short is that of no file.
        const bool no_file = form.files.size() > 1 && file.error().kind == ErrorKind::kSystem;
        EXPECT_TRUE(no_file || file.error().kind == ErrorKind::kContent) << file.error().message;
        continue;
      }
      EXPECT_TRUE(name.ends_with(".inp") || length + 1 >= bytes.size()) << "ENDDATA is missing";
      EXPECT_LE(file->mesh.tetrahedra.size(), 96u);
    }
  }
}

TEST(Decks, WithAnyByteChangedAreReadOrRefused) {
  const TemporaryFolder folder;
  for (const std::string& text : {kInpTet + "*NSET, NSET=s, GENERATE\n1, 4, 1\n", kBdfTet})
    for (const char change : {'9', '-', '\n', '\0', '*', ',', '$', '\xff'})
      for (std::size_t at = 0; at < text.size(); ++at) {
        std::string changed = text;
        changed[at] = change;
        const bool abaqus = text.starts_with("*");
        const Result<MeshFile> file =
            read_tet_mesh(folder.write(abaqus ? "a.inp" : "a.bdf", changed));
        if (!file) EXPECT_FALSE(file.error().message.empty());
      }
}

}  // namespace

// The files of an imported model are in the basis file only for the export.

namespace {

using testing::tiny_basis;

BasisData imported() {
  BasisData data = tiny_basis();
  data.vega = {std::string("basis\0bytes", 11), "polynomials"};
  return data;
}

TEST(VegaSections, AreKeptByteForByteInBothEncodings) {
  for (BasisEncoding encoding : {BasisEncoding::kFull, BasisEncoding::kCompact}) {
    const auto bytes = encode_basis(imported(), encoding);
    ASSERT_TRUE(bytes) << bytes.error().message;
    auto reader = BasisReader::from_memory(*bytes);
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_TRUE(reader->verify_all());
    const auto files = read_vega_files(*reader);
    ASSERT_TRUE(files) << files.error().message;
    EXPECT_EQ(files->basis, imported().vega.basis);
    EXPECT_EQ(files->cubic, imported().vega.cubic);
  }
}

TEST(VegaSections, ADamagedOneIsSeenByTheExportAlone) {
  std::vector<std::byte> bytes = *encode_basis(imported());
  const std::string word = "polynomials";
  const auto at = std::search(bytes.begin(), bytes.end(), word.begin(), word.end(),
                              [](std::byte a, char b) { return a == static_cast<std::byte>(b); });
  ASSERT_NE(at, bytes.end());
  *at = std::byte{0};
  auto reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(read_basis(*reader));
  const auto files = read_vega_files(*reader);
  ASSERT_FALSE(files);
  EXPECT_NE(files.error().message.find("vega_cubic"), std::string::npos) << files.error().message;
}

TEST(VegaSections, AModelOfTremolosOwnHasNone) {
  const std::vector<std::byte> bytes = *encode_basis(tiny_basis());
  auto reader = BasisReader::from_memory(bytes);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->has("vega_basis"));
  const auto files = read_vega_files(*reader);
  ASSERT_TRUE(files);
  EXPECT_TRUE(files->basis.empty() && files->cubic.empty());
}

}  // namespace
}  // namespace tremolo
