// Cloth from a file: seams are joined, polygons keep their area, texture coordinates stay.
#include <string>

#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using testing::TemporaryFolder;

std::string face_line(std::initializer_list<int> vertices) {
  std::string line = "f";
  for (const int v : vertices) line += " " + std::to_string(v + 1) + "/" + std::to_string(v + 1);
  return line + "\n";
}

// A sheet of 4 x 1 squares of 0.1 m whose middle column of vertices stands twice, with texture
// coordinates that differ there: numbers 0 to 5 on the left, 6 to 11 on the right. off: how far the
// second column is from the first, m.
std::string seamed_sheet(double off = 0.0) {
  std::string text, faces;
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 2; ++j) {
        const double x = 0.1 * (2 * half + i) + (half == 1 && i == 0 ? off : 0.0);
        text += "v " + std::to_string(x) + " " + std::to_string(0.1 * j) + " 0\n";
        text += "vt " + std::to_string(0.5 * half + 0.1 * i) + " " + std::to_string(j) + "\n";
      }
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i < 2; ++i) {
      const int a = 6 * half + 2 * i;
      faces += face_line({a, a + 2, a + 3, a + 1});
    }
  return text + faces;
}

SceneCloth cloth_of(const std::string& file) {
  SceneCloth cloth;
  cloth.file = file;
  cloth.density = 0.2;
  return cloth;
}

TEST(ClothFile, AVertexThatStandsTwiceAlongASeamIsOneParticle) {
  const TemporaryFolder folder;
  const Result<ClothParts> parts =
      make_cloth_parts(cloth_of(folder.write("a.obj", seamed_sheet())));
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ(parts->particles(), 10U);
  EXPECT_EQ(parts->vertices(), 12U);
  EXPECT_EQ(parts->joined, 2U);
  // The seam bends as any other row: 4 squares have 17 edges and 7 of them two triangles.
  EXPECT_EQ(parts->structural.pairs.size(), 17U);
  EXPECT_EQ(parts->bend.pairs.size(), 7U);
  EXPECT_EQ(parts->particle_of_vertex(4), parts->particle_of_vertex(6));
  EXPECT_EQ(parts->particle_of_vertex(11), 9U);
  EXPECT_EQ(parts->vertex_of_particle(9), 11U);
  EXPECT_NEAR(parts->mass.sum(), 0.2 * 0.04, 1e-15);
  // The drawn surface keeps the file's vertices and texture coordinates.
  ASSERT_NE(parts->drawn, nullptr);
  EXPECT_EQ(parts->drawn->vertices.size(), 12U);
  ASSERT_EQ(parts->drawn->uvs.size(), 12U);
  EXPECT_EQ(parts->drawn->uvs[6], Eigen::Vector2f(0.5F, 0));
  const ClothLook look = look_of(*parts);
  ASSERT_EQ(look.particles.size(), 12U);
  EXPECT_EQ(look.particles[4], look.particles[6]);
  EXPECT_EQ(look.uvs.size(), 12U);
  EXPECT_EQ(look.triangles.size(), 8U);
}

TEST(ClothFile, ColumnsThatAreApartStayApart) {
  const TemporaryFolder folder;
  const auto parts = make_cloth_parts(cloth_of(folder.write("a.obj", seamed_sheet(1e-3))));
  ASSERT_TRUE(parts) << parts.error().message;
  EXPECT_EQ(parts->particles(), 12U);
  EXPECT_EQ(parts->joined, 0U);
  EXPECT_TRUE(parts->particle_of.empty());
}

TEST(ClothFile, LayersThatLieOnEachOtherAreJoinedAtTheirBordersAlone) {
  // Two sheets of 2 x 2 squares at one place: a cushion, whose middles are free of each other.
  SurfaceMesh mesh;
  for (int layer = 0; layer < 2; ++layer) {
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) mesh.vertices.emplace_back(i, j, 0);
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const VertexId a = 9 * layer + 3 * j + i;
        mesh.triangles.push_back({a, a + 1, a + 4});
        mesh.triangles.push_back({a, a + 4, a + 3});
      }
  }
  const JoinedSeams joined = join_seams(mesh);
  EXPECT_EQ(joined.mesh.vertices.size(), 10U);
  EXPECT_NE(joined.particle_of[4], joined.particle_of[13]);
  EXPECT_EQ(joined.particle_of[0], joined.particle_of[9]);
}

// Pins and hands count as the file does.
TEST(ClothFile, PinsOfASeamedMeshHaveTheFilesNumbers) {
  const TemporaryFolder folder;
  ClothScene scene;
  scene.options.step = 1e-3;
  SceneCloth cloth = cloth_of(folder.write("a.obj", seamed_sheet()));
  cloth.pins = {{.particles = {11}, .motion = {}}};
  scene.cloths = {cloth};
  const Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  const auto held = world->model(0).held();
  for (std::size_t i = 0; i < held.size(); ++i) EXPECT_EQ(held[i] != 0, i == 9) << i;
  scene.cloths[0].pins[0].particles = {12};
  const Result<ClothWorld> none = ClothWorld::create(scene);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("no vertex 12: there are 12"), std::string::npos)
      << none.error().message;
}

TEST(ClothFile, AConcavePolygonWeighsWhatItCovers) {
  const TemporaryFolder folder;
  // An L of 3 m^2, from each of its corners.
  const char* corners[] = {"0 0", "2 0", "2 1", "1 1", "1 2", "0 2"};
  for (int first = 0; first < 6; ++first) {
    std::string text, face = "f";
    for (int k = 0; k < 6; ++k) {
      text += std::string("v ") + corners[(first + k) % 6] + " 0\n";
      face += " " + std::to_string(k + 1);
    }
    const auto parts = make_cloth_parts(cloth_of(folder.write("l.obj", text + face + "\n")));
    ASSERT_TRUE(parts) << parts.error().message;
    EXPECT_NEAR(parts->mass.sum(), 0.6, 1e-15) << first;
  }
}

}  // namespace
}  // namespace tremolo
