// Meshes whose parts lie in further files: *INCLUDE and INPUT of Abaqus, pieces of a .pvtu.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/meshes/writer_forms.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::replaced;
using testing::TemporaryFolder;

class IncludedFiles : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directory(folder_.file("parts")); }
  void expect_same(const std::string& name, const Result<MeshFile>& whole) {
    const Result<MeshFile> file = read_tet_mesh(folder_.file(name));
    ASSERT_TRUE(file) << file.error().message;
    ASSERT_TRUE(whole) << whole.error().message;
    EXPECT_EQ(file->mesh.vertices, whole->mesh.vertices);
    EXPECT_EQ(file->mesh.tetrahedra, whole->mesh.tetrahedra);
    EXPECT_EQ(file->mesh.node_sets, whole->mesh.node_sets);
    EXPECT_EQ(file->mesh.region_of, whole->mesh.region_of);
  }
  void expect_refused(const std::string& name, const std::vector<std::string>& parts,
                      ErrorKind kind = ErrorKind::kContent) {
    const Result<MeshFile> file = read_tet_mesh(folder_.file(name));
    ASSERT_FALSE(file) << name << ": " << parts.front();
    EXPECT_EQ(file.error().kind, kind) << file.error().message;
    for (const std::string& part : parts)
      EXPECT_NE(file.error().message.find(part), std::string::npos)
          << part << " is not in: " << file.error().message;
  }
  TemporaryFolder folder_;
};

// Data lines alone, a keyword with its data, a file in a file, and the same with INPUT.
TEST_F(IncludedFiles, OfAbaqusStandWhereTheyAreNamed) {
  const std::string text = testing::inp_of_meshio();
  const Result<MeshFile> whole = read_tet_mesh(folder_.write("whole.inp", text));
  const std::size_t nodes = text.find("*NODE\n") + 6, elements = text.find("*ELEMENT");
  const std::size_t data = text.find('\n', elements) + 1, second = text.find("*ELEMENT", data);
  const std::size_t sets = text.find("*ELSET");
  folder_.write("parts/nodes.txt", "** of nodes\n" + text.substr(nodes, elements - nodes));
  folder_.write("parts/cells.inp",
                text.substr(elements, second - elements) + "*INCLUDE, INPUT=more.inp\n");
  folder_.write("parts/more.inp", text.substr(second, sets - second));
  folder_.write("parts/data.inp", text.substr(data, second - data));
  folder_.write("a.inp", text.substr(0, nodes) +
                             "*Include, input=parts/nodes.txt\n*INCLUDE, "
                             "INPUT=\"parts\\cells.inp\"\n" +
                             text.substr(sets));
  expect_same("a.inp", whole);
  folder_.write("b.inp", "*INCLUDE, INPUT=a.inp\n");
  expect_same("b.inp", whole);
  folder_.write("c.inp",
                "*HEADING\nof INPUT\n*NODE, INPUT=parts/nodes.txt\n*ELEMENT, TYPE=C3D4, "
                "INPUT=parts/data.inp\n*INCLUDE, INPUT=parts/more.inp\n" +
                    text.substr(sets));
  expect_same("c.inp", whole);
}

TEST_F(IncludedFiles, OfAbaqusAreRefusedByNameWhereTheyGoInCirclesOrElsewhere) {
  const std::string start = "*HEADING\nx\n";
  folder_.write("a.inp", start + "*INCLUDE, INPUT=parts/b.inp\n");
  folder_.write("parts/b.inp", "** b\n*INCLUDE, INPUT=c.inp\n");
  folder_.write("parts/c.inp", "*INCLUDE, INPUT=b.inp\n");
  expect_refused("a.inp", {"parts/c.inp, line 1", "`b.inp` includes itself"});
  folder_.write("parts/c.inp", "*INCLUDE, INPUT=none.inp\n");
  expect_refused("a.inp", {"none.inp", "parts/c.inp, line 1"}, ErrorKind::kSystem);
  for (const std::string name : {"../a.inp", "/etc/passwd", "parts/../../x.inp", "..\\a.inp", ""}) {
    folder_.write("parts/d.inp", start + "*INCLUDE, INPUT=" + name + "\n");
    expect_refused("parts/d.inp", {"line 3", "same folder or below"});
  }
  // Six levels.
  for (int level = 0; level < 7; ++level)
    folder_.write("l" + std::to_string(level) + ".inp",
                  start + "*INCLUDE, INPUT=l" + std::to_string(level + 1) + ".inp\n");
  expect_refused("l0.inp", {"l5.inp, line 3", "5 levels"});
}

// Files of which each names the next one many times would else be read without end.
TEST_F(IncludedFiles, OfAbaqusTakeMemoryInProportionToTheirSizes) {
  std::string many;
  for (int n = 0; n < 40; ++n) many += "*INCLUDE, INPUT=next.inp\n";
  folder_.write("a.inp", "*HEADING\nx\n" + replaced("x", "x", many));
  folder_.write("next.inp", "*NSET, NSET=s, GENERATE\n1, 100, 1\n" + std::string(4000, '\n'));
  expect_refused("a.inp", {"a.inp, line", "16 times at most"});
}

// The two pieces of form_vtu() as files of their own.
class VtuPieces : public IncludedFiles {
 protected:
  void SetUp() override {
    IncludedFiles::SetUp();
    const std::string both = testing::form_vtu(
        {testing::VtuForm::Compression::kNone, testing::VtuForm::Place::kText, false, 2});
    const std::size_t first = both.find("<Piece"), second = both.find("<Piece", first + 1);
    const std::size_t end = both.find("</UnstructuredGrid>");
    head_ = both.substr(0, first);
    low_ = head_ + both.substr(first, second - first) + both.substr(end);
    high_ = head_ + both.substr(second);
    folder_.write("parts/a_0.vtu", low_);
    folder_.write("parts/a_1.vtu", high_);
  }
  static std::string list(const std::string& sources) {
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\" "
           "byte_order=\"LittleEndian\">\n<PUnstructuredGrid GhostLevel=\"0\">\n<PPoints>"
           "<PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>\n" +
           sources + "</PUnstructuredGrid>\n</VTKFile>\n";
  }
  static std::string piece(const std::string& name) { return "<Piece Source=\"" + name + "\"/>\n"; }
  std::string head_, low_, high_;
};

TEST_F(VtuPieces, AreOneMeshWhosePointsStayApart) {
  // An empty piece, as a process without cells writes it, comes first.
  folder_.write("parts/a_2.vtu", head_ +
                                     "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\">\n"
                                     "<Points></Points>\n<Cells></Cells>\n</Piece>\n"
                                     "</UnstructuredGrid>\n</VTKFile>\n");
  folder_.write("a.pvtu",
                list(piece("parts/a_2.vtu") + piece("parts/a_0.vtu") + piece("parts/a_1.vtu")));
  const Result<MeshFile> file = read_tet_mesh(folder_.file("a.pvtu"));
  ASSERT_TRUE(file) << file.error().message;
  const testing::FormBar bar;
  EXPECT_EQ(file->mesh.tetrahedra.size(), bar.mesh.tetrahedra.size());
  // The nine points of the middle are in both halves.
  EXPECT_EQ(file->mesh.vertices.size(), bar.mesh.vertices.size() + 9);
  TetMesh mesh = file->mesh;
  const Result<MeshReport> report = check_mesh(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->parts, 2u);
  EXPECT_NEAR(report->volume, 0.125, 1e-12);
  EXPECT_EQ(file->mesh.region_names, (std::vector<std::string>{"region 1", "region 2"}));
  EXPECT_TRUE(std::any_of(file->notes.begin(), file->notes.end(), [](const std::string& note) {
    return note.find("--merge") != std::string::npos;
  }));
}

// vtkGhostType 1: of another piece; 0: its own.
TEST_F(VtuPieces, LeaveOutTheGhostCellsThatOtherPiecesHave) {
  const testing::FormBar bar;
  const auto with_ghosts = [](std::string text, std::size_t count, std::size_t ghosts) {
    std::string values;
    for (std::size_t c = 0; c < count; ++c) values += c < ghosts ? "1 " : "0 ";
    return replaced(text, "<CellData>\n",
                    "<CellData>\n<DataArray type=\"UInt8\" Name=\"vtkGhostType\" "
                    "format=\"ascii\">" +
                        values + "</DataArray>\n");
  };
  const std::size_t low = bar.tets_of_half(0).size();
  folder_.write("parts/a_0.vtu", with_ghosts(low_, low, 5));
  folder_.write("a.pvtu", list(piece("parts/a_0.vtu") + piece("parts/a_1.vtu")));
  const Result<MeshFile> file = read_tet_mesh(folder_.file("a.pvtu"));
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->mesh.tetrahedra.size(), bar.half.size() - 5);
  // The others keep their order and their regions.
  const Result<MeshFile> alone = read_tet_mesh(folder_.write("low.vtu", low_));
  ASSERT_TRUE(alone);
  for (std::size_t t = 0; t < low - 5; ++t)
    EXPECT_EQ(file->mesh.tetrahedra[t], alone->mesh.tetrahedra[t + 5]) << t;
  std::size_t of_low = 0;
  for (const auto region : file->mesh.region_of)
    of_low += region >= 0 && file->mesh.region_names[region] == "region 1" ? 1 : 0;
  EXPECT_EQ(of_low, low - 5);
}

TEST_F(VtuPieces, AreRefusedByNameWhereTheyAreMissingRepeatedOrElsewhere) {
  const auto expect = [&](const std::string& sources, const std::vector<std::string>& parts,
                          ErrorKind kind = ErrorKind::kContent) {
    folder_.write("a.pvtu", list(sources));
    expect_refused("a.pvtu", parts, kind);
  };
  expect(piece("parts/none.vtu"), {"none.vtu", "a.pvtu"}, ErrorKind::kSystem);
  expect(piece("../a.vtu"), {"a.pvtu", "same folder or below", "`../a.vtu`"});
  expect(piece("parts/a_0.vtu") + piece("parts/a_0.vtu"), {"each once", "a_0.vtu"});
  expect("<Piece/>\n", {"Source=FILE"});
  expect("", {"expected a Piece, found none"});
  expect(piece("a.pvtu"), {"a.pvtu", "partitioned itself"});
  folder_.write("parts/a_0.vtu", replaced(low_, "Name=\"types\"", "Name=\"kinds\""));
  expect(piece("parts/a_0.vtu"), {"a_0.vtu", "types"});
}

}  // namespace
}  // namespace tremolo
