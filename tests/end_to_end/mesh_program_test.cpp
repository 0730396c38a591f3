// tremolo-mesh: a recipe reproduces its mesh.
#include <array>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "common/mesh/mesh_quality.h"
#include "formats/mesh/mesh_reader.h"
#include "tests/support/meshes/surface_files.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

TEST(MeshProgram, MakesTheBeamAnewTheSameEachTime) {
  const std::string folder = fresh_folder();
  const ProgramResult first = run_program(folder, kMesh + "beam -o a.msh --surface a.ply");
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_NE(first.out.find("dihedral angles"), std::string::npos);
  EXPECT_NE(first.out.find("radius ratio"), std::string::npos);
  EXPECT_GT(std::filesystem::file_size(folder + "/a.ply"), 1000u);
  ASSERT_EQ(run_program(folder, kMesh + "beam -o b.msh").code, 0);
  EXPECT_EQ(slurp(folder + "/a.msh"), slurp(folder + "/b.msh"));

  auto made = read_tet_mesh(folder + "/a.msh");
  auto committed = read_tet_mesh(TREMOLO_SOURCE_DIR "/assets/meshes/beam.msh");
  ASSERT_TRUE(made && committed);
  const auto report = check_mesh(made->mesh);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->parts, 1u);
  EXPECT_GE(mesh_quality(made->mesh).min_dihedral_deg, 8.0);
  // Another processor may round a Delaunay predicate's input differently: the same solid, not
  // necessarily the same vertices as the committed one.
  EXPECT_NEAR(report->volume, mesh_quality(committed->mesh).volume, 0.01 * report->volume);
}

TEST(MeshProgram, TheSameSurfaceAsObjAndAsOffGivesTheSameMesh) {
  const std::string folder = fresh_folder();
  const std::array<std::string, 2> star = testing::star_prism();
  std::ofstream(folder + "/star.obj") << star[0];
  std::ofstream(folder + "/star.off") << star[1];
  for (const std::string name : {"obj", "off"}) {
    const ProgramResult made = run_program(folder, kMesh + "star." + name + " -o " + name + ".msh");
    ASSERT_EQ(made.code, 0) << made.err;
  }
  const std::string obj = slurp(folder + "/obj.msh");
  EXPECT_GT(obj.size(), 10'000U);
  EXPECT_EQ(obj, slurp(folder + "/off.msh"));
}

// Its spikes ask for more, and are lost where tetrahedra are larger.
TEST(MeshProgram, ACountThatCannotBeMetGivesTheNearestMesh) {
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/star.off") << testing::star_prism()[1];
  const ProgramResult made = run_program(folder, kMesh + "star.off -o star.msh --tets 3000");
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_TRUE(read_tet_mesh(folder + "/star.msh"));
}

TEST(MeshProgram, WrongUsageIsToldApartAndWritesNothing) {
  const std::string folder = fresh_folder();
  const ProgramResult unknown = run_program(folder, kMesh + "giraffe -o x.msh");
  EXPECT_EQ(unknown.code, 2) << unknown.err;
  EXPECT_NE(unknown.err.find("horse"), std::string::npos) << "the recipes are listed";
  EXPECT_EQ(run_program(folder, kMesh + "beam -o x.msh --size 0.01 --tets 100").code, 2);
  EXPECT_EQ(run_program(folder, kMesh + "beam -o x.msh --size -1").code, 2);
  EXPECT_EQ(run_program(folder, kMesh + "beam").code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder + "/x.msh"));
  EXPECT_EQ(run_program(folder, kMesh + "beam -o no/folder/x.msh").code, 1);
  EXPECT_EQ(run_program(folder, kMesh + "--help").code, 0);
  EXPECT_EQ(run_program(folder, kMesh + "--version").code, 0);
}

}  // namespace
}  // namespace tremolo
