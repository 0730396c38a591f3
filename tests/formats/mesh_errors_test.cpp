// Errors in a mesh file: the message has the position, the expected text and the found one.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>

#include <gtest/gtest.h>

#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::replaced;
using testing::TemporaryFolder;
using Parts = std::initializer_list<const char*>;

void expect_message(const Result<MeshFile>& file, Parts parts) {
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, ErrorKind::kContent) << file.error().message;
  for (const char* part : parts)
    EXPECT_NE(file.error().message.find(part), std::string::npos)
        << "`" << part << "` is not in: " << file.error().message;
}

void expect_error(const std::string& name, const std::string& bytes, Parts parts) {
  ASSERT_FALSE(bytes.empty()) << "the test does not fit its file";
  const TemporaryFolder folder;
  expect_message(read_tet_mesh(folder.write(name, bytes)), parts);
}

// Little-endian bytes of a number, for files made by msh2_binary(false) and msh4_binary(false).
template <class T>
std::string bytes_of(T value) {
  return testing::ByteWriter(false).put(value).str();
}

void expect_tetgen_error(const std::string& node, const std::string& ele, Parts parts) {
  ASSERT_FALSE(node.empty() || ele.empty()) << "the test does not fit its file";
  const TemporaryFolder folder;
  folder.write("a.node", node);
  expect_message(read_tet_mesh(folder.write("a.ele", ele)), parts);
}

TEST(Msh2Errors, NameLineExpectedAndFound) {
  const std::string good = testing::msh2_text();
  expect_error("a.msh", replaced(good, "2.2 0 8", "1 0 8"), {"line 2", "2.2 or 4.1", "`1`"});
  expect_error("a.msh", replaced(good, "2.2 0 8", "2.2 7 8"), {"line 2", "file type", "7"});
  expect_error("a.msh", replaced(good, "2.2 0 8", "2.2 0 4"), {"line 2", "data size 8", "4"});
  expect_error("a.msh", replaced(good, "\"body\"", "body"), {"line 7", "quotes", "body"});
  expect_error("a.msh", replaced(good, "3 4 \"body\"", "4 4 \"body\""), {"line 7", "0 to 3", "4"});
  expect_error("a.msh", replaced(good, "2 0 0 0", "2 0 0 x"), {"line 11", "coordinate", "`x`"});
  expect_error("a.msh", replaced(good, "2 0 0 0", "2 0 0 nan"),
               {"line 11", "vertex 2", "z", "nan"});
  expect_error("a.msh", replaced(good, "2 0 0 0", "2 inf 0 0"),
               {"line 11", "vertex 2", "x", "inf"});
  expect_error("a.msh", replaced(good, "2 0 0 0", "2 0 1e999 0"), {"line 11", "1e999"});
  expect_error("a.msh", replaced(good, "2 0 0 0", "9 0 0 0"), {"vertex id 9", "twice"});
  expect_error("a.msh", replaced(good, "2 0 0 0", "2.5 0 0 0"), {"line 11", "node id", "`2.5`"});
  expect_error("a.msh", replaced(good, "2 4 2 4 1 2 9 5 7", "2 4 2 4 1 2 9 5 8"),
               {"line 20", "element 2", "vertex 8", "2 to 9"});
  expect_error("a.msh", replaced(good, "2 4 2 4 1 2", "2 777 2 4 1 2"),
               {"line 20", "element type", "777"});
  expect_error("a.msh", replaced(good, "2 4 2 4 1 2", "2 4 -2 4 1 2"), {"line 20", "tags", "-2"});
  expect_error("a.msh", replaced(good, "$Elements\n3", "$Elements\n4"),
               {"line 22", "element id", "`$EndElements`"});
  expect_error("a.msh", replaced(good, "$Elements\n3", "$Elements\n2"),
               {"line 21", "`$EndElements`", "`3`"});
  expect_error("a.msh", replaced(good, "$Nodes\n5", "$Nodes\n6"), {"line 16", "`$EndNodes`"});
}

TEST(Msh2Errors, SectionsMustBeThereOnceAndInOrder) {
  const std::string format = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
  const std::string nodes = "$Nodes\n1\n1 0 0 0\n$EndNodes\n";
  const std::string elements = "$Elements\n0\n$EndElements\n";
  expect_error("a.msh", format, {"without $Nodes"});
  expect_error("a.msh", format + nodes, {"without $Elements"});
  expect_error("a.msh", format + elements + nodes, {"line 4", "$Elements before $Nodes"});
  expect_error("a.msh", format + nodes + nodes, {"line 8", "second section $Nodes"});
  expect_error("a.msh", format + nodes + elements + elements, {"line 11", "second"});
  expect_error("a.msh", format + "stray", {"line 4", "section", "`stray`"});
  expect_error("a.msh", format + "$", {"line 4", "section", "`$`"});
  expect_error("a.msh", format + "$?\n", {"line 5", "`$End?`"});
  expect_error("a.msh", format + "$\n" + nodes + elements, {"line 4", "section", "`$`"});
}

TEST(Msh2Errors, NameTheOffsetInABinaryFile) {
  const std::string good = testing::msh2_binary(false);
  const std::size_t node = good.find("$Nodes\n5\n") + 9;
  std::string bad = good;
  bad.replace(node + 4, 8, bytes_of(std::nan("")));
  // The vertex is complete when it is checked: the position is that of its last coordinate.
  expect_error("a.msh", bad, {("byte " + std::to_string(node + 20)).c_str(), "vertex 2", "nan"});
  const std::size_t element = good.find("$Elements\n3\n") + 12;
  bad = good;
  bad.replace(element + 4, 4, bytes_of(std::int32_t{77}));
  expect_error("a.msh", bad, {("byte " + std::to_string(element + 4)).c_str(), "1 to 3", "77"});
  bad = good;
  bad.replace(good.find("2.2 1 8\n") + 8, 4, bytes_of(std::int32_t{3}));
  expect_error("a.msh", bad, {"byte", "byte order", "3"});
}

TEST(Msh4Errors, NameLineExpectedAndFound) {
  const std::string good = testing::msh4_text();
  expect_error("a.msh", replaced(good, "4.1 0 8", "4.0 0 8"), {"line 2", "2.2 or 4.1", "`4.0`"});
  expect_error("a.msh", replaced(good, "\n2 6 1 3\n", "\n2 6 2 3\n"), {"line 17", "0 or 1", "2"});
  expect_error("a.msh", replaced(good, "\n2 6 1 3\n", "\n2 6 1 9\n"),
               {"line 17", "at most 5", "9"});
  expect_error("a.msh", replaced(good, "\n2 6 1 3\n", "\n4 6 1 3\n"), {"line 17", "0 to 3", "4"});
  expect_error("a.msh", replaced(good, "2 5 2 9\n", "2 6 2 9\n"), {"6 nodes", "found 5"});
  expect_error("a.msh", replaced(good, "2 5 2 9\n", "1 5 2 9\n"), {"5 nodes", "found 3"});
  expect_error("a.msh", replaced(good, "2 3 1 3\n", "2 4 1 3\n"), {"4 elements", "found 3"});
  expect_error("a.msh", replaced(good, "2 2 9 5 7\n", "2 2 9 5 8\n"),
               {"line 35", "element 2", "vertex 8"});
  expect_error("a.msh", replaced(good, "2 6 2 1\n", "2 6 -1 1\n"), {"element type", "-1"});
  expect_error("a.msh", replaced(good, "\n1 0 1 1\n", "\n1 0 1 2\n"), {"entity", "`$EndEntities`"});
}

// Each block goes into the set of each group of its entity: g groups and b blocks in a file of
// g + b lines would be g * b members.
TEST(Msh4Errors, AnEntityOfTooManyGroupsIsRefused) {
  const auto file = [](int groups) {
    std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 " +
                       std::to_string(groups);
    for (int g = 1; g <= groups; ++g) text += " " + std::to_string(g);
    return text +
           " 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n"
           "0 0 1\n$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n";
  };
  const TemporaryFolder folder;
  const Result<MeshFile> many = read_tet_mesh(folder.write("a.msh", file(64)));
  ASSERT_TRUE(many) << many.error().message;
  EXPECT_EQ(many->mesh.node_sets.size(), 64u);
  expect_error("a.msh", file(65), {"at most 64", "65", "entity 1"});
}

TEST(VtuErrors, DeepNestingIsNoHarm) {
  std::string text = "<VTKFile type=\"UnstructuredGrid\">";
  for (int n = 0; n < 300'000; ++n) text += "<a>";
  expect_error("a.vtu", text, {"byte"});
}

TEST(MeshErrors, CountsThatTheFileCannotHoldAreRefusedBeforeMemoryIsTaken) {
  // Each would need far more memory than any machine has.
  const char* huge = "4611686018427387904";
  const auto nodes = [huge](const std::string& text, const std::string& from,
                            const std::string& to) { return replaced(text, from, to + huge); };
  expect_error("a.msh", nodes(testing::msh2_text(), "$Nodes\n5", "$Nodes\n"),
               {"line 10", huge, "nodes", "bytes"});
  expect_error("a.msh", nodes(testing::msh2_text(), "$Elements\n3", "$Elements\n"),
               {"line 18", huge, "elements"});
  expect_error("a.msh", nodes(testing::msh2_text(), "Names\n2", "Names\n"),
               {"line 5", huge, "names"});
  expect_error("a.msh", nodes(testing::msh4_text(), "2 6 2 1", "2 6 2 "), {huge});
  expect_error("a.msh", nodes(testing::msh2_binary(true), "$Nodes\n5", "$Nodes\n"),
               {"byte", huge, "nodes"});
  expect_error("a.vtk", nodes(testing::vtk_text(), "POINTS 5", "POINTS "),
               {"line 8", huge, "points"});
  expect_error("a.vtk", nodes(testing::vtk_text(), "CELLS 3 14", "CELLS 3 "), {huge, "cells"});
  expect_error("a.vtk", nodes(testing::vtk_binary(), "CELLS 3 14", "CELLS 3 "), {"byte", huge});
  expect_error("a.vtk", nodes(testing::vtk_binary_5_1(), "CELLS 4 11", "CELLS 4 "), {huge});
  expect_error("a.vtk", nodes(testing::vtk_text(), "TIME 1 2", std::string("TIME ") + huge + " "),
               {"line 5", "FIELD", "fits"});
  expect_error("a.vtu",
               replaced(testing::vtu_text(), "Points=\"5", std::string("Points=\"") + huge),
               {"NumberOfPoints", huge});
  expect_error("a.vtu", replaced(testing::vtu_text(), "3 7 11", std::string("3 7 ") + huge),
               {"offsets", huge});
  expect_error("a.veg", nodes(testing::veg_text(0), "VERTICES\n5", "VERTICES\n"), {"vertex"});
  expect_tetgen_error(replaced(testing::node_text(0), "5 3 1 1", std::string(huge) + " 3 1 1"),
                      testing::ele_text(0), {"a.node, line 2", huge, "points"});
}

TEST(VtkErrors, NameLineExpectedAndFound) {
  const std::string good = testing::vtk_text();
  expect_error("a.vtk", replaced(good, "\nASCII\n", "\nHEX\n"), {"line 3", "ASCII", "`HEX`"});
  expect_error("a.vtk", replaced(good, "UNSTRUCTURED_GRID", "POLYDATA"),
               {"line 4", "UNSTRUCTURED_GRID", "`POLYDATA`"});
  expect_error("a.vtk", replaced(good, "0.125", "nan"),
               {"line 8", "POINTS", "vertex 3", "x", "nan"});
  expect_error("a.vtk", replaced(good, "0.125", "0,125"), {"line 12", "`0,125`"});
  expect_error("a.vtk", replaced(good, "4 1 4 2 3", "4 1 5 2 3"),
               {"line 17", "CELLS", "element 2", "vertex 5", "0 to 4"});
  expect_error("a.vtk", replaced(good, "4 1 4 2 3", "4 1 -1 2 3"), {"element 2", "vertex -1"});
  expect_error("a.vtk", replaced(good, "4 1 4 2 3", "5 1 4 2 3"), {"cell 2", "5"});
  expect_error("a.vtk", replaced(good, "4 1 4 2 3", "3 1 4 2 3"), {"expected a list of 13"});
  expect_error("a.vtk", replaced(good, "CELLS 3 14", "CELLS 99 14"), {"99 cells"});
  expect_error("a.vtk", replaced(good, "CELL_TYPES 3\n5\n", "CELL_TYPES 2\n"),
               {"2 types of 3 cells"});
  expect_error("a.vtk", replaced(good, "TYPES 3\n5\n10", "TYPES 3\n5\n12"),
               {"cell 1", "hexahedra", "8 nodes", "4"});
  expect_error("a.vtk", replaced(good, "TYPES 3\n5\n10", "TYPES 3\n5\n99"), {"cell 1", "type 99"});
  expect_error("a.vtk", replaced(good, "POINTS 5 double", "POINTS 5"), {"line 14"});
  expect_error("a.vtk", replaced(good, "METADATA", "OTHERDATA"), {"line 14", "`OTHERDATA`"});
  expect_error("a.vtk", good.substr(0, good.find("CELL_TYPES")), {"without CELL_TYPES"});
}

TEST(VtkErrors, OffsetsMustAscendWithinTheListOfNodes) {
  const std::string good = testing::vtk_text_5_1();
  expect_error("a.vtk", replaced(good, "0 3 7 11", "0 8 7 11"), {"cell 1", "8", "7"});
  expect_error("a.vtk", replaced(good, "0 3 7 11", "1 3 7 11"), {"offsets from 0 to 11"});
  expect_error("a.vtk", replaced(good, "0 3 7 11", "0 3 7 12"), {"offsets from 0 to 11", "12"});
}

TEST(VtuErrors, NameTheArrayExpectedAndFound) {
  const std::string good = testing::vtu_text();
  const std::string encoded = testing::vtu_base64(false, false);
  expect_error("a.vtu", replaced(good, "</Points>", "</Pints>"), {"byte", "well-formed XML"});
  expect_error("a.vtu", replaced(good, "type=\"UnstructuredGrid\"", "type=\"ImageData\""),
               {"UnstructuredGrid", "`ImageData`"});
  expect_error("a.vtu",
               replaced(good, "byte_order", "compressor=\"vtkLZMADataCompressor\" byte_order"),
               {"zlib or LZ4", "vtkLZMADataCompressor"});
  expect_error("a.vtu", replaced(good, "LittleEndian", "MiddleEndian"), {"`MiddleEndian`"});
  expect_error("a.vtu", replaced(good, "0.125", "nan"), {"points", "vertex 3", "nan"});
  expect_error("a.vtu", replaced(good, "0.125", "o.125"), {"array `points`", "`o.125`"});
  expect_error("a.vtu", replaced(good, "5 10 10", "5 10"), {"array `types`", "a number"});
  expect_error("a.vtu", replaced(good, "5 10 10", "5 10 10 10"), {"array `types`", "found more"});
  expect_error("a.vtu", replaced(good, "3 7 11", "3 7 -1"), {"offsets", "-1"});
  expect_error("a.vtu", replaced(good, "Name=\"types\"", "Name=\"kinds\""), {"types", "none"});
  expect_error("a.vtu", replaced(encoded, "UInt32", "UInt64"), {"points"});
  expect_error("a.vtu", replaced(encoded, "type=\"UInt8\"", "type=\"Bool\""), {"types", "`Bool`"});
  expect_error("a.vtu", replaced(encoded, "type=\"UInt8\"", "type=\"Float32\""),
               {"types", "integers"});
  expect_error("a.vtu",
               replaced(good, "<DataArray format=\"ascii\" type=\"UInt8\"",
                        "<DataArray format=\"appended\" type=\"UInt8\""),
               {"types", "offset", "a number of bytes"});
}

TEST(VegErrors, NameLineExpectedAndFound) {
  const std::string good = testing::veg_text(1);
  expect_error("a.veg", replaced(good, "5 3 0 0", "5 2 0 0"), {"line 4", "dimension 3", "2"});
  expect_error("a.veg", replaced(good, "1 0 0 0\n", "1 0 0\n"), {"line 5", "coordinate", "line"});
  expect_error("a.veg", replaced(good, "1 0 0 0\n", "1 0 0 inf\n"), {"line 5", "vertex 1", "inf"});
  expect_error("a.veg", replaced(good, "TETS", "CUBIC"), {"line 12", "TETS", "`CUBIC`"});
  expect_error("a.veg", replaced(good, "2 4 0\n", "2 10 0\n"), {"line 13", "linear", "10"});
  expect_error("a.veg", replaced(good, "1 1 2 3 4\n", "1 1 2 3 6\n"),
               {"line 14", "element 1", "6"});
  expect_error("a.veg", replaced(good, "1 1 2 3 4\n", "1 1 2 3 0\n"),
               {"line 14", "element 1", "0"});
  expect_error("a.veg", replaced(good, "1 1 2 3 4\n", "1 1 2 3\n"), {"line 14", "node", "line"});
  expect_error("a.veg", replaced(good, "1 1 2 3 4\n", "5 1 2 3 4\n"), {"line 14", "0 or 1", "5"});
  expect_error("a.veg", replaced(good, "2 2 5 3 4\n", "1 2 5 3 4\n"), {"line 15", "id 2", "1"});
  expect_error("a.veg", replaced(good, "first\n1,", "first\n0,"), {"line 21", "`first`", "0"});
  expect_error("a.veg", replaced(good, "first\n1,", "first\n3,"), {"line 21", "`first`", "3"});
  expect_error("a.veg", replaced(good, "*REGION", "*LEGION"), {"line 18", "`*LEGION`"});
  expect_error("a.veg", replaced(good, "*ELEMENTS", "*VERTICES"), {"line 11", "a second"});
  expect_error("a.veg", good.substr(0, good.find("*ELEMENTS")), {"*ELEMENTS", "end of the file"});
}

TEST(VegErrors, IncludesStayInTheirFolderAndEndSomewhere) {
  const std::string start = "*VERTICES\n*INCLUDE ";
  expect_error("a.veg", start + "../b.node\n", {"line 2", "same folder", "`../b.node`"});
  expect_error("a.veg", start + "/etc/passwd\n", {"line 2", "same folder"});
  expect_error("a.veg", start + "\n", {"line 2", "name of a file"});
  // A file that includes itself is read as its own inclusion once and then refused.
  expect_error("a.veg", "*INCLUDE a.veg\n", {"each once", "`a.veg`"});
  // To the system a name ends at a NUL: it would be another spelling of one file.
  expect_error("a.veg", start + std::string("b.node\0x", 8) + "\n", {"line 2", "each once"});
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.write("a.veg", start + "none.node\n"));
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, ErrorKind::kSystem);
  EXPECT_NE(file.error().message.find("none.node"), std::string::npos);
}

TEST(TetgenErrors, NameFileLineExpectedAndFound) {
  const std::string node = testing::node_text(1);
  const std::string ele = testing::ele_text(1);
  expect_tetgen_error(replaced(node, "5 3 1 1", "5 2 1 1"), ele, {"a.node, line 2", "3", "2"});
  expect_tetgen_error(replaced(node, "5 3 1 1", "6 3 1 1"), ele, {"a.node, line 9", "point id"});
  expect_tetgen_error(replaced(node, "0.125", "nan"), ele, {"a.node, line 6", "vertex 4", "nan"});
  expect_tetgen_error(replaced(node, "0.125", "-"), ele, {"a.node, line 6", "`-`"});
  expect_tetgen_error(node, replaced(ele, "2  4  1", "2  20  1"),
                      {"a.ele, line 1", "4 or 10 nodes", "20"});
  expect_tetgen_error(node, replaced(ele, "2  4  1", "3  4  1"), {"a.ele, line 1", "3 tetrahedra"});
  expect_tetgen_error(node, replaced(ele, "1 1 2 3 4", "1 1 2 3 6"),
                      {"a.ele, line 2", "element 1", "vertex 6", "1 to 5"});
  expect_tetgen_error(testing::node_text(0), ele, {"a.ele, line 3", "vertex 5", "0 to 4"});
}

TEST(TetgenErrors, AMissingPartnerIsNamed) {
  const TemporaryFolder folder;
  const Result<MeshFile> file = read_tet_mesh(folder.write("a.node", testing::node_text(0)));
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, ErrorKind::kSystem);
  EXPECT_NE(file.error().message.find("a.ele"), std::string::npos);
}

TEST(MeshErrors, AMeshWithoutTetrahedraSaysWhatItHolds) {
  const std::string text = testing::msh2_text();
  expect_error(
      "a.msh",
      replaced(replaced(replaced(text, "2 4 2 4 1 2 9 5 7\n", ""), "3 4 2 4 1 9 3 5 7\n", ""),
               "$Elements\n3", "$Elements\n1"),
      {"expected tetrahedra", "5 vertices", "1 triangles"});
  expect_error("a.veg", "*VERTICES\n1 3\n0 0 0 0\n*ELEMENTS\nTET\n0 4\n",
               {"expected tetrahedra", "1 vertices and no cells"});
}

TEST(MeshErrors, CubicTetrahedraAreRefusedByName) {
  const std::string format =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n";
  expect_error(
      "a.msh",
      format + "$Elements\n1\n7 29 0 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n$EndElements\n",
      {"line 10", "element 7", "20-node tetrahedra", "linear or quadratic"});
}

// Places in vegb_bytes(small_mesh()): 8 of the version, 4 of the type, 4 and 5 vertices of 24
// bytes, 4, 4 and 2 elements of 16, then the materials.
std::string vegb_with(std::size_t at, std::int32_t value) {
  return testing::vegb_bytes(testing::small_mesh()).replace(at, 4, bytes_of(value));
}

TEST(VegbErrors, NameByteExpectedAndFound) {
  const std::string good = testing::vegb_bytes(testing::small_mesh());
  expect_error("a.vegb", "hello, it is no mesh", {"byte 0", "version 1"});
  expect_error("a.vegb", vegb_with(8, 2), {"byte 8", "type 1, tetrahedra", "2, cubes"});
  expect_error("a.vegb", vegb_with(12, -5), {"byte 12", "number of vertices", "-5"});
  expect_error("a.vegb", vegb_with(12, 0x7fffffff), {"byte 16", "2147483647", "24 bytes each"});
  expect_error("a.vegb", std::string(good).replace(16 + 8, 8, bytes_of(std::nan(""))),
               {"byte 32", "vertex 0", "y", "nan"});
  expect_error("a.vegb", vegb_with(136, 0x7fffffff), {"byte 144", "elements", "16 bytes each"});
  expect_error("a.vegb", vegb_with(140, 8), {"byte 140", "4 nodes", "8"});
  expect_error("a.vegb", vegb_with(144, 5), {"byte 156", "element 0", "vertex 5", "0 to 4"});
  expect_error("a.vegb", vegb_with(144, -1), {"element 0", "vertex -1"});
  expect_error("a.vegb", vegb_with(176, -1), {"byte 176", "number of materials", "-1"});
  expect_error("a.vegb", vegb_with(180, 0x7fffffff), {"byte 184", "name of a material"});
  expect_error("a.vegb", vegb_with(194, 4), {"byte 194", "type 1, 2 or 3", "4", "material 0"});
  expect_error("a.vegb", good + "x", {"end of the file", "1 more bytes"});
  const std::string name(300, 'n');
  expect_error("a.vegb",
               good.substr(0, 180) + bytes_of(std::int32_t{300}) + name + good.substr(184 + 10),
               {"name of a material", "at most 256", "300"});
  // From the end: two regions of 8 bytes, their number, the element of the set, its number.
  const std::size_t end = good.size();
  expect_error("a.vegb", vegb_with(end - 4, 2), {"region 1", "set 2", "below 2"});
  expect_error("a.vegb", vegb_with(end - 8, 3), {"region 1", "material 3", "below 3"});
  expect_error("a.vegb", vegb_with(end - 20, 0x7fffffff), {"number of regions", "8 bytes each"});
  expect_error("a.vegb", vegb_with(end - 24, 2), {"set `first`", "element 2", "below 2"});
  expect_error("a.vegb", vegb_with(end - 28, 0x7fffffff), {"number of elements of a set"});
}

}  // namespace
}  // namespace tremolo
