// Regions and materials: every format that can hold them gives the same ones.
#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vega/veg_regions.h"
#include "tests/support/meshes/mesh_variants.h"
#include "tests/support/meshes/vega_files.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::replaced;
using testing::TemporaryFolder;
using Regions = std::vector<std::int32_t>;
using Names = std::vector<std::string>;

MeshFile read(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  Result<MeshFile> file = read_tet_mesh(folder.write(name, bytes));
  EXPECT_TRUE(file) << file.error().message;
  if (!file) return {};
  EXPECT_TRUE(check_mesh(file->mesh));
  return std::move(*file);
}

std::string all_notes(const MeshFile& file) {
  std::string text;
  for (const std::string& note : file.notes) text += note + "\n";
  return text;
}

TEST(Regions, OfAnMshFileAreItsPhysicalVolumes) {
  for (const std::string& text : {testing::msh2_text(), testing::msh2_binary(false),
                                  testing::msh4_text(), testing::msh4_binary(true)}) {
    const MeshFile file = read("a.msh", text);
    EXPECT_EQ(file.mesh.region_of, (Regions{0, 0}));
    EXPECT_EQ(file.mesh.region_names, Names{"body"});
  }
  const MeshFile two = read("a.msh", replaced(testing::msh2_text(), "3 4 2 4 1", "3 4 2 -6 1"));
  EXPECT_EQ(two.mesh.region_of, (Regions{0, 1}));
  EXPECT_EQ(two.mesh.region_names, (Names{"body", "volume 6"}));
  const MeshFile partly = read("a.msh", replaced(testing::msh2_text(), "2 4 2 4 1", "2 4 2 0 1"));
  EXPECT_EQ(partly.mesh.region_of, (Regions{-1, 0}));
  const std::string none = replaced(testing::msh2_text(), "2 4 2 4 1", "2 4 2 0 1");
  EXPECT_TRUE(read("a.msh", replaced(none, "3 4 2 4 1", "3 4 0 ")).mesh.region_of.empty());
}

TEST(Regions, TheFirstOfSeveralPhysicalVolumesCountsAndIsNoted) {
  const std::string three = replaced(testing::msh2_text(), "$Elements\n3", "$Elements\n4");
  const MeshFile repeated =
      read("a.msh", replaced(three, "$EndElements", "9 4 2 5 1 2 9 5 7\n$EndElements"));
  EXPECT_EQ(repeated.mesh.region_of, (Regions{0, 0}));
  EXPECT_EQ(repeated.mesh.region_names, Names{"body"});
  EXPECT_NE(all_notes(repeated).find("region of the first"), std::string::npos);
  // Version 4: the volume's entity has the groups 4 and 9.
  const MeshFile listed = read("a.msh", replaced(testing::msh4_text(), "1 0 0 0 1 1 1 1 4 1 6\n",
                                                 "1 0 0 0 1 1 1 2 4 9 1 6\n"));
  EXPECT_EQ(listed.mesh.region_of, (Regions{0, 0}));
  EXPECT_EQ(listed.mesh.region_names, Names{"body"});
  EXPECT_NE(all_notes(listed).find("2 tetrahedra of several"), std::string::npos);
}

TEST(Regions, OfALegacyVtkFileAreItsCellData) {
  const std::string text = testing::vtk_text_5_1();
  for (const char* data :
       {"CELL_DATA 3\nSCALARS material int 1\nLOOKUP_TABLE default\n9 3 -4\n",
        "CELL_DATA 3\nSCALARS MaterialIDs double\nLOOKUP_TABLE default\n9.5 3 -4\n",
        "POINT_DATA 5\nSCALARS region int 1\nLOOKUP_TABLE default\n1 2 3 4 5\nVECTORS v float\n"
        "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15\nCELL_DATA 3\nNORMALS n float\n1 2 3 4 5 6 7 8 9\n"
        "FIELD FieldData 2\nother 1 3 int\n1 1 1\ngmsh:physical 1 3 int\n9 3 -4\n",
        "CELL_DATA 3\nCOLOR_SCALARS c 2\n0 0 1 0.5 0 0\nTEXTURE_COORDINATES t 2 float\n1 2 3 4 5 "
        "6\n"
        "SCALARS s float\n1 2 3\nLOOKUP_TABLE mine 2\n0 0 0 1 1 1 1 1\nSCALARS material int\n9 3 "
        "-4\n",
        // A better name wins, wherever it is.
        "CELL_DATA 3\nSCALARS CellEntityIds int 1\nLOOKUP_TABLE default\n1 1 1\n"
        "SCALARS Region int 1\nLOOKUP_TABLE default\n9 3 -4\nMETADATA\nINFORMATION 0\n\n"}) {
    const MeshFile file = read("a.vtk", text + data);
    EXPECT_EQ(file.mesh.region_of, (Regions{0, 1})) << data;
    EXPECT_EQ(file.mesh.region_names, (Names{"region 3", "region -4"})) << data;
  }
}

TEST(Regions, OfABinaryVtkFileAreItsCellData) {
  testing::ByteWriter bytes(true);
  bytes.text(testing::vtk_binary_5_1()).text("CELL_DATA 3\nSCALARS material int 1\n");
  bytes.text("LOOKUP_TABLE default\n");
  for (std::int32_t value : {9, 3, 4}) bytes.put(value);
  const MeshFile file = read("a.vtk", bytes.text("\n").str());
  EXPECT_EQ(file.mesh.region_of, (Regions{0, 1}));
  EXPECT_EQ(file.mesh.region_names, (Names{"region 3", "region 4"}));
}

TEST(Regions, CellDataThatAreNoRegionsLeaveTheMesh) {
  const std::string text = testing::vtk_text_5_1();
  for (const auto& [data, note] : std::vector<std::pair<const char*, const char*>>{
           {"CELL_DATA 3\nSCALARS material float 1\nLOOKUP_TABLE default\n1 0.5 2\n", "integers"},
           {"CELL_DATA 3\nSCALARS material float 1\nLOOKUP_TABLE default\n1 nan 2\n", "integers"},
           {"CELL_DATA 3\nSCALARS material int 1\nLOOKUP_TABLE default\n1 2\n", "end here"},
           {"CELL_DATA 2\nSCALARS material int 1\nLOOKUP_TABLE default\n1 2\n", "2 numbers for 3"},
           {"CELL_DATA 99999999999\nSCALARS material int 1\nLOOKUP_TABLE default\n1 2 3\n",
            "end here"},
           {"CELL_DATA 3\nSCALARS temperature int 1\nLOOKUP_TABLE default\n1 2 3\n", ""},
           {"CELL_DATA 3\nVECTORS material int\n1 2 3 4 5 6 7 8 9\n", ""}}) {
    const MeshFile file = read("a.vtk", text + data);
    EXPECT_EQ(file.mesh.tetrahedra.size(), 2u);
    EXPECT_TRUE(file.mesh.region_of.empty()) << data;
    EXPECT_NE(all_notes(file).find(note), std::string::npos) << data << all_notes(file);
  }
}

TEST(Regions, OfAVtuFileAreItsCellData) {
  const auto with = [](const std::string& array) {
    return replaced(testing::vtu_text(), "</Cells>",
                    "</Cells>\n<CellData>" + array + "</CellData>");
  };
  const std::string start = "<DataArray type=\"Int32\" format=\"ascii\" Name=\"";
  const MeshFile file = read("a.vtu", with(start + "gmsh:physical\">9 3 3</DataArray>" + start +
                                           "Material\">9 3 -4</DataArray>"));
  EXPECT_EQ(file.mesh.region_of, (Regions{0, 1}));
  EXPECT_EQ(file.mesh.region_names, (Names{"region 3", "region -4"}));
  EXPECT_NE(all_notes(file).find("`Material`"), std::string::npos);
  const MeshFile short_array = read("a.vtu", with(start + "material\">9 3</DataArray>"));
  EXPECT_TRUE(short_array.mesh.region_of.empty());
  EXPECT_NE(all_notes(short_array).find("not read"), std::string::npos);
}

TEST(Regions, OfTetGenFilesAreTheLastAttribute) {
  const TemporaryFolder folder;
  folder.write("a.node", testing::node_text(1));
  const auto regions = [&](const std::string& ele) {
    const Result<MeshFile> file = read_tet_mesh(folder.write("a.ele", ele));
    EXPECT_TRUE(file) << file.error().message;
    return file->mesh.region_of.empty() ? Names{} : file->mesh.region_names;
  };
  EXPECT_EQ(regions(testing::ele_text(1)), Names{"region -3"});
  EXPECT_EQ(regions("2 4 2\n1 1 2 3 4 0.5 7\n2 2 5 3 4 0.5 8.0\n"),
            (Names{"region 7", "region 8"}));
  EXPECT_EQ(regions("2 4 1\n1 1 2 3 4 7\n2 2 5 3 4 7.5\n"), Names{});
  EXPECT_EQ(regions("2 4 0\n1 1 2 3 4\n2 2 5 3 4\n"), Names{});
}

std::string veg_with(const std::string& tail) {
  const std::string text = testing::veg_text(1);
  return text.substr(0, text.find("*MATERIAL")) + tail;
}

TEST(Regions, OfAVegFileAreItsMaterials) {
  const std::string materials =
      "*MATERIAL soft wood\nENU, 600, 1e9, 0.3\n*MATERIAL steel\nENU,7800,2e11,0.25 # rigid\n";
  const std::string sets = "*SET one\n1\n*SET two\n2,\n";
  const MeshFile file = read("a.veg", veg_with(materials + sets +
                                               "*REGION\none, soft wood\n"
                                               "*REGION\ntwo, steel\n"));
  EXPECT_EQ(file.mesh.region_of, (Regions{0, 1}));
  EXPECT_EQ(file.mesh.region_names, (Names{"softwood", "steel"}));
  ASSERT_EQ(file.materials.size(), 2u);
  EXPECT_EQ(file.materials[0].region, "softwood");
  EXPECT_EQ(file.materials[1].problem, "");
  EXPECT_EQ(file.materials[1].material, (Material{2e11, 0.25, 7800}));
  // The last region that lists an element decides, as in VegaFEM; the rest stays without.
  const MeshFile overlapping = read("a.veg", veg_with(materials + sets +
                                                      "*REGION\nallElements, steel\n*REGION\none, "
                                                      "softwood\n"));
  EXPECT_EQ(overlapping.mesh.region_of, (Regions{0, 1}));
  EXPECT_EQ(overlapping.mesh.region_names, (Names{"softwood", "steel"}));
  EXPECT_NE(all_notes(overlapping).find("1 tetrahedra are in several regions"), std::string::npos);
  const MeshFile partly = read("a.veg", veg_with(materials + sets +
                                                 "*REGION\ntwo, steel\n"
                                                 "*REGION\nthree, steel\n"));
  EXPECT_EQ(partly.mesh.region_of, (Regions{-1, 0}));
  EXPECT_NE(all_notes(partly).find("does not have"), std::string::npos);
}

TEST(Regions, OfAMaterialWithoutANameAreNotLost) {
  const MeshFile file = read("a.veg", veg_with("*MATERIAL\nENU, 600, 1e9, 0.3\n"
                                               "*REGION\nallElements\n"));
  EXPECT_EQ(file.mesh.region_of, (Regions{0, 0}));
  EXPECT_EQ(file.mesh.region_names, Names{"(unnamed)"});
  ASSERT_EQ(file.materials.size(), 1u);
  EXPECT_EQ(file.materials[0].region, "(unnamed)");
}

TEST(Regions, OfAVegbFileAreItsMaterialsToo) {
  const MeshFile file = read("a.vegb", testing::vegb_bytes(testing::small_mesh()));
  // All elements are of material 0, then the first one of material 2, which is no St. Venant's.
  EXPECT_EQ(file.mesh.region_of, (Regions{0, 1}));
  EXPECT_EQ(file.mesh.region_names, (Names{"material 2", "material 0"}));
  ASSERT_EQ(file.materials.size(), 3u);
  EXPECT_EQ(file.materials[0].material, (Material{1e6, 0.45, 1000}));
  EXPECT_EQ(file.materials[1].material.orthotropic->young, Eigen::Vector3d(1e6, 2e6, 3e6));
  EXPECT_NE(file.materials[2].problem.find("`MOONEYRIVLIN`"), std::string::npos);
}

TEST(VegMaterial, ThatCannotBeUsedSaysWhereAndWhy) {
  for (const auto& [line, words] : std::vector<std::pair<const char*, const char*>>{
           {"MOONEYRIVLIN, 1000, 1, 2, 3\n", "`MOONEYRIVLIN`"},
           {"ENU, 1000, 1e6\n", "3 numbers"},
           {"ENU, 1000, 1e6, soft\n", "`soft`"},
           {"ENU, 1000, 1e6, 0.5\n", "Poisson"},
           {"ENU, 0, 1e6, 0.3\n", "density"},
           {"", "constants"}}) {
    const MeshFile file = read(
        "a.veg", veg_with(std::string("*MATERIAL wood\n") + line + "*REGION\nallElements, wood\n"));
    ASSERT_EQ(file.materials.size(), 1u);
    EXPECT_NE(file.materials[0].problem.find(words), std::string::npos)
        << file.materials[0].problem;
    EXPECT_NE(file.materials[0].problem.find("a.veg, line 1"), std::string::npos)
        << file.materials[0].problem;
    EXPECT_EQ(file.mesh.region_names, Names{"wood"});
  }
}

TEST(VegMaterial, OfEveryOrthotropicKindIsRead) {
  // A quarter turn about z: axis 1 is y, axis 2 is -x.
  const std::vector<double> turn{0, -1, 0, 1, 0, 0, 0, 0, 1};
  const auto of = [&](const char* kind, std::vector<double> numbers, bool turned) {
    if (turned) numbers.insert(numbers.end(), turn.begin(), turn.end());
    const Result<Material> material = veg_material(kind, numbers);
    EXPECT_TRUE(material) << material.error().message;
    return material ? *material->orthotropic : OrthotropicElasticity{};
  };
  const std::vector<double> nine{700, 9e9, 4e9, 1e9, 0.1, 0.2, 0.05, 1e9, 2e9, 3e9};
  for (const char* kind : {"ORTHOTROPIC", "ORTHOTROPIC_N3G3R9", "ORTHOTROPIC_N3G3"}) {
    const bool turned = std::string(kind) != "ORTHOTROPIC_N3G3";
    const OrthotropicElasticity o = of(kind, nine, turned);
    EXPECT_EQ(o.young, Eigen::Vector3d(9e9, 4e9, 1e9));
    EXPECT_EQ(o.poisson, Eigen::Vector3d(0.1, 0.2, 0.05));
    EXPECT_EQ(o.shear, Eigen::Vector3d(1e9, 2e9, 3e9));
    EXPECT_EQ(o.axes.col(0), turned ? Eigen::Vector3d(0, 1, 0) : Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(o.axes.col(1), turned ? Eigen::Vector3d(-1, 0, 0) : Eigen::Vector3d(0, 1, 0));
  }
  for (const char* kind : {"ORTHOTROPIC_N1G1R9", "ORTHOTROPIC_N1G1"}) {
    const OrthotropicElasticity o =
        of(kind, {700, 9e9, 4e9, 1e9, 0.25, 2}, std::string(kind).ends_with("R9"));
    // nu sqrt(E_i/E_j) and G sqrt(E_i E_j) / (2 (1 + nu)).
    EXPECT_DOUBLE_EQ(o.poisson[0], 0.375);
    EXPECT_DOUBLE_EQ(o.poisson[1], 0.5);
    EXPECT_DOUBLE_EQ(o.poisson[2], 0.25 / 3);
    EXPECT_DOUBLE_EQ(o.shear[0], 2 * 6e9 / 2.5);
  }
  EXPECT_DOUBLE_EQ(of("ORTHOTROPIC_N1R9", {700, 9e9, 4e9, 1e9, 0.25}, true).shear[1], 2e9 / 2.5);
  EXPECT_DOUBLE_EQ(of("ORTHOTROPIC_N1", {700, 9e9, 4e9, 1e9, 0.25}, false).shear[2], 3e9 / 2.5);
  EXPECT_FALSE(veg_material("ORTHOTROPIC_N2", nine));
  EXPECT_FALSE(veg_material("ORTHOTROPIC", nine));  // no axes
  std::vector<double> skewed = nine;
  skewed.insert(skewed.end(), {1, 0.1, 0, 0, 1, 0, 0, 0, 1});
  EXPECT_FALSE(veg_material("ORTHOTROPIC", skewed));
  for (std::size_t i = 0; i < 9; ++i) {
    std::vector<double> hollow = nine;
    hollow.insert(hollow.end(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    hollow[10 + i] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(veg_material("ORTHOTROPIC", hollow)) << i;
  }
}

TEST(Regions, OfAVegbFileHaveTheVerticesOfTheirOwnElements) {
  const TetMesh mesh = testing::small_mesh();
  const std::string bytes = testing::vegb_bytes(mesh);
  for (std::int32_t element : {0, 1}) {
    // The set's one element is before the number of regions and the two regions.
    std::string turned = bytes;
    std::memcpy(&turned[bytes.size() - 24], &element, 4);
    Tetrahedron expected = mesh.tetrahedra[element];
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(read("a.vegb", turned).mesh.node_sets.at("first"),
              std::vector<VertexId>(expected.begin(), expected.end()));
  }
}

TEST(MeshCheck, RefusesRegionsThatDoNotFitTheMesh) {
  TetMesh mesh = testing::small_mesh();
  mesh.region_names = {"a"};
  mesh.region_of = {0, -1};
  EXPECT_TRUE(check_mesh(mesh));
  for (const Regions& bad : {Regions{0}, Regions{0, 1}, Regions{0, -2}, Regions{0, 0, 0}}) {
    mesh.region_of = bad;
    EXPECT_FALSE(check_mesh(mesh));
  }
}

TEST(VegbRegions, TheLastRegionThatListsAnElementDecides) {
  const testing::TemporaryFolder folder;
  // Region 0: the first material, all elements; region 1: the third, element 0.
  const Result<MeshFile> file =
      read_tet_mesh(folder.write("a.vegb", testing::vegb_bytes(testing::small_mesh())));
  ASSERT_TRUE(file) << file.error().message;
  const TetMesh& mesh = file->mesh;
  ASSERT_EQ(mesh.region_of.size(), 2u);
  const auto region = [&](std::size_t tet) { return mesh.region_names.at(mesh.region_of[tet]); };
  EXPECT_EQ(region(0), "material 2");
  EXPECT_EQ(region(1), "material 0");
  ASSERT_EQ(file->materials.size(), 3u);
  EXPECT_EQ(file->materials[0].material, (Material{1e6, 0.45, 1000.0}));
  ASSERT_TRUE(file->materials[1].material.orthotropic) << file->materials[1].problem;
  EXPECT_EQ(file->materials[1].material.orthotropic->shear, Eigen::Vector3d(4e5, 5e5, 6e5));
  EXPECT_EQ(file->materials[1].material.density, 1100.0);
  EXPECT_FALSE(file->materials[2].problem.empty()) << "Mooney-Rivlin is not StVK";
}

}  // namespace
}  // namespace tremolo
