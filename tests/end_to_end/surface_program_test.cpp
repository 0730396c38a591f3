// Surfaces of modelling programs through tremolo-mesh and tremolo-precompute: their orientation,
// bodies that touch, and what the messages name.

#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/meshes/surfaces.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using namespace testing;

const std::string kModel =
    " --fix none --tets 600 --linear --linear-modes 2 --modes 2 --young 1e5 --density 500 -o ";

void write_obj(const std::string& path, const SurfaceMesh& surface,
               const std::vector<Eigen::Vector3d>& normals = {}) {
  std::ofstream file(path);
  file.precision(17);
  for (const Eigen::Vector3d& x : surface.vertices) file << "v " << x.transpose() << "\n";
  for (const Eigen::Vector3d& n : normals) file << "vn " << n.transpose() << "\n";
  for (const Triangle& t : surface.triangles) {
    file << "f";
    for (const VertexId v : t) {
      file << " " << v + 1;
      if (!normals.empty()) file << "//" << v + 1;
    }
    file << "\n";
  }
}

SurfaceMesh moved(SurfaceMesh surface, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& x : surface.vertices) x += by;
  return surface;
}

class SurfaceProgram : public ::testing::Test {
 protected:
  ProgramResult run(const std::string& command) const { return run_program(folder_, command); }
  void expect_failure(const std::string& command, int code,
                      const std::vector<std::string>& words) const {
    const ProgramResult result = run(command);
    EXPECT_EQ(result.code, code) << result.err;
    for (const std::string& word : words)
      EXPECT_NE(result.err.find(word), std::string::npos) << word << " in " << result.err;
  }
  std::string folder_ = fresh_folder();
};

TEST_F(SurfaceProgram, TheDrawnSurfaceFacesOutwardsToo) {
  const SurfaceMesh ball = sphere_surface(0.1, 12, 24);
  std::vector<Eigen::Vector3d> inwards;
  for (const Eigen::Vector3d& x : ball.vertices) inwards.push_back(-x.normalized());
  write_obj(folder_ + "/in.obj", reversed(ball), inwards);
  write_obj(folder_ + "/random.obj", turned_at_random(ball, 0.6));
  for (const std::string name : {"in", "random"}) {
    const ProgramResult result = run(kPrecompute + name + ".obj" + kModel + name + ".tremolo");
    ASSERT_EQ(result.code, 0) << result.err;
    const Result<BasisData> data = read_basis(folder_ + "/" + name + ".tremolo");
    ASSERT_TRUE(data && data->render);
    const RenderSurface& drawn = data->render->surface;
    ASSERT_EQ(drawn.triangles.size(), ball.triangles.size());
    std::size_t inward = 0, inward_normals = 0;
    for (const Triangle& t : drawn.triangles) {
      const Eigen::Vector3d &a = drawn.vertices[t[0]], &b = drawn.vertices[t[1]],
                            &c = drawn.vertices[t[2]];
      inward += (b - a).cross(c - a).dot(a + b + c) <= 0;
    }
    for (std::size_t v = 0; v < drawn.normals.size(); ++v)
      inward_normals += drawn.normals[v].cast<double>().dot(drawn.vertices[v]) <= 0;
    EXPECT_EQ(inward, 0u) << name;
    EXPECT_EQ(inward_normals, 0u) << name;
    EXPECT_EQ(drawn.normals.empty(), name == "random");
  }
}

// Normals that face outwards already stay, whichever way the triangles do.
TEST_F(SurfaceProgram, GoodNormalsOfTurnedTrianglesStay) {
  const SurfaceMesh ball = sphere_surface(0.1, 12, 24);
  std::vector<Eigen::Vector3d> outwards;
  for (const Eigen::Vector3d& x : ball.vertices) outwards.push_back(x.normalized());
  write_obj(folder_ + "/ball.obj", reversed(ball), outwards);
  ASSERT_EQ(run(kPrecompute + "ball.obj" + kModel + "ball.tremolo").code, 0);
  const Result<BasisData> data = read_basis(folder_ + "/ball.tremolo");
  ASSERT_TRUE(data && data->render);
  const RenderSurface& drawn = data->render->surface;
  ASSERT_FALSE(drawn.normals.empty());
  for (std::size_t v = 0; v < drawn.normals.size(); ++v)
    EXPECT_GT(drawn.normals[v].cast<double>().dot(drawn.vertices[v]), 0);
}

TEST_F(SurfaceProgram, UnconnectedPartsOfAFreeBodyAreAWarning) {
  const SurfaceMesh box = box_surface({0.1, 0.1, 0.1});
  write_obj(folder_ + "/two.obj", together(box, moved(box, {0.2, 0, 0})));
  const ProgramResult result = run(kPrecompute + "two.obj" + kModel + "two.tremolo");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("warning: a free body of 2 parts that are not connected: its 12 rigid "
                            "motions are left out"),
            std::string::npos)
      << result.err;
}

TEST_F(SurfaceProgram, BodiesThatTouchAlongAnEdgeAreAWarning) {
  const SurfaceMesh box = box_surface({0.1, 0.1, 0.1});
  write_obj(folder_ + "/hinge.obj", together(box, moved(box, {0.1, 0.1, 0})));
  write_obj(folder_ + "/wall.obj", together(box, moved(box, {0.1, 0, 0})));
  const ProgramResult hinge = run(kMesh + "hinge.obj -o hinge.msh --tets 2000");
  EXPECT_EQ(hinge.code, 0) << hinge.err;
  EXPECT_NE(hinge.err.find("warning: bodies touch along 1 edge only"), std::string::npos)
      << hinge.err;
  const ProgramResult wall = run(kMesh + "wall.obj -o wall.msh --tets 2000");
  EXPECT_EQ(wall.code, 0) << wall.err;
  EXPECT_EQ(wall.err.find("warning"), std::string::npos) << wall.err;
}

TEST_F(SurfaceProgram, MessagesNameWhatIsWrong) {
  SurfaceMesh ball = sphere_surface(0.1, 12, 24);
  write_obj(folder_ + "/ball.obj", ball);
  // In the answer's place comes the reason for which it cannot be written.
  expect_failure("ulimit -f 4; " + kPrecompute + "ball.obj --fix none -o ball.tremolo", 1,
                 {"ball.obj: the mesh cannot be handed over in memory", "File too large"});
  write_obj(folder_ + "/noext", ball);
  expect_failure(kPrecompute + "noext --fix none -o no.tremolo", 3,
                 {"noext, line 1: expected a tetrahedral mesh",
                  "A surface is known by the extension of its name: .obj, .ply"});
  expect_failure(kMesh + "ball.obj -o ball.stl", 2,
                 {"--output ball.stl: tetrahedra are written as MSH 2.2, into a file named .msh"});
  EXPECT_FALSE(std::ifstream(folder_ + "/ball.stl"));
  ball.vertices[24] = {1e300, 0, 0};
  write_obj(folder_ + "/far.obj", ball);
  expect_failure(kMesh + "far.obj -o far.msh", 3,
                 {"far.obj: vertex 24 (from 0, in the file's order) is at (1e+300, 0, 0) m"});
  std::ofstream wide(folder_ + "/wide.obj", std::ios::binary);
  wide << "\xff\xfe";
  for (const char c : slurp(folder_ + "/ball.obj")) wide << c << '\0';
  wide.close();
  expect_failure(kMesh + "wide.obj -o wide.msh", 3, {"wide.obj", "UTF-16", "save it as UTF-8"});
}

}  // namespace
}  // namespace tremolo
