#include "precompute/problem/up_axis.h"

#include <gtest/gtest.h>

#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

using testing::box_mesh;

// A pyramid that stands on its square along an axis and has a ridge at the other end.
TetMesh standing_along(int axis) {
  TetMesh mesh = box_mesh({4, 4, 4}, {1, 1, 1});
  for (Eigen::Vector3d& x : mesh.vertices) {
    const double narrow = 1 - 0.9 * x[axis];
    for (int other = 0; other < 3; ++other)
      if (other != axis) x[other] = 0.5 + narrow * (x[other] - 0.5);
  }
  return mesh;
}

TEST(UpAxis, TurningIsAQuarterTurnAboutX) {
  TetMesh mesh;
  mesh.vertices = {{1, 2, 3}};
  RenderSurface surface;
  surface.vertices = {{1, 2, 3}};
  surface.normals = {{0, 1, 0}};
  turn_y_to_z(mesh);
  turn_y_to_z(surface);
  EXPECT_EQ(mesh.vertices[0], Eigen::Vector3d(1, -3, 2));
  EXPECT_EQ(surface.vertices[0], Eigen::Vector3d(1, -3, 2));
  EXPECT_EQ(surface.normals[0], Eigen::Vector3f(0, 0, 1)) << "up is up";
}

TEST(UpAxis, ATurnedMaterialTurnsItsAxes) {
  std::vector<FileMaterial> materials(2);
  materials[0].material.orthotropic.emplace();
  turn_y_to_z(materials);
  Eigen::Matrix3d turned;
  turned << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  EXPECT_EQ(materials[0].material.orthotropic->axes, turned);
  EXPECT_FALSE(materials[1].material.orthotropic);
}

// The hint on selectors as the user writes them.
std::string hint_on(const std::vector<std::string>& texts, const TetMesh& mesh, bool y_by_format) {
  std::vector<Selector> selectors;
  for (const std::string& text : texts) selectors.push_back(*parse_selector(text));
  return side_hint(selectors, mesh, y_by_format);
}

TEST(UpAxis, WhoHoldsTheSideOfAStandingBodyIsTold) {
  const TetMesh standing = standing_along(1);
  const std::string hint = hint_on({"x<0.1", "z<5%"}, standing, false);
  EXPECT_NE(hint.find("z<5%"), std::string::npos) << hint;
  EXPECT_NE(hint.find("--up y"), std::string::npos) << hint;
  EXPECT_NE(hint_on({"z<=0.01 and x>0"}, standing, false), "");
  // A format that has y up needs no foot.
  EXPECT_NE(hint_on({"z<5%"}, standing_along(0), true), "");
}

TEST(UpAxis, WhoMayWellMeanItIsNotTold) {
  for (const char* selector : {"y<5%", "x<0.1", "none", "z>95%", "z<5% and y<50%", "foot"})
    EXPECT_EQ(hint_on({selector}, standing_along(1), true), "") << selector;
  for (const TetMesh& mesh :
       {standing_along(2), standing_along(0), box_mesh({2, 2, 2}, {0.1, 0.2, 0.3})})
    EXPECT_EQ(hint_on({"z<5%"}, mesh, false), "");
}

TEST(UpAxis, FormatsThatHaveYUpAreKnown) {
  EXPECT_TRUE(has_y_up("a/duck.GLB") && has_y_up("duck.gltf") && has_y_up("duck.x3d"));
  EXPECT_FALSE(has_y_up("duck.obj") || has_y_up("glb") || has_y_up("duck.stl"));
}

}  // namespace
}  // namespace tremolo
