// Colours, objects and materials of a surface, on the mesh.
#include "precompute/embedding/surface_sets.h"

#include <gtest/gtest.h>

#include "common/mesh/selector.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

using Ids = std::vector<VertexId>;

constexpr Colour kRed{255, 0, 0, 255};
constexpr Colour kBlue{0, 0, 255, 255};

// A square of two triangles, x from 0 to 1, at the height z.
void add_square(RenderSurface& surface, double z, const Colour& colour, std::uint32_t object,
                std::uint32_t material) {
  const auto first = static_cast<VertexId>(surface.vertices.size());
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
    surface.vertices.emplace_back(x, y, z);
  surface.triangles.push_back({first, first + 1, first + 2});
  surface.triangles.push_back({first, first + 2, first + 3});
  surface.colours.insert(surface.colours.end(), 4, colour);
  surface.object_of.insert(surface.object_of.end(), 2, object);
  surface.material_of.insert(surface.material_of.end(), 2, material);
}

// A red floor just under the unit cube and a blue ceiling just above it.
RenderSurface floor_and_ceiling() {
  RenderSurface surface;
  surface.objects = {"floor", "ceiling"};
  surface.materials = {"stone"};
  add_square(surface, -0.01, kRed, 0, 0);
  add_square(surface, 1.01, kBlue, 1, 0);
  return surface;
}

TetMesh cube() {
  return testing::box_mesh({2, 2, 2}, {1, 1, 1});
}

TEST(SurfaceSets, ObjectsAndMaterialsAreTheBoundaryVerticesNextToThem) {
  TetMesh mesh = cube();
  EXPECT_TRUE(add_surface_sets(floor_and_ceiling(), mesh).empty());
  const Ids low = testing::vertices_on_plane(mesh, 2, 0.0);
  const Ids& floor = mesh.node_sets.at("floor");
  for (const VertexId id : low) EXPECT_TRUE(std::binary_search(floor.begin(), floor.end(), id));
  for (const VertexId id : testing::vertices_on_plane(mesh, 2, 1.0))
    EXPECT_FALSE(std::binary_search(floor.begin(), floor.end(), id));
  EXPECT_EQ(mesh.node_sets.at("stone").size(), 26u) << "all but the one inside";
  EXPECT_EQ(floor.size() + mesh.node_sets.at("ceiling").size(), 26u);
}

TEST(SurfaceSets, PaintGoesToTheBoundaryAndNotInside) {
  TetMesh mesh = cube();
  add_surface_sets(floor_and_ceiling(), mesh);
  ASSERT_EQ(mesh.colours.size(), 27u);
  EXPECT_EQ(mesh.colours[13], Colour{}) << "inside";
  EXPECT_EQ(mesh.colours[0], kRed);
  EXPECT_EQ(mesh.colours[26], kBlue);
  const auto red = select_vertices(*parse_selector("colour:red and z<0.1"), mesh);
  ASSERT_TRUE(red) << red.error().message;
  EXPECT_EQ(*red, testing::vertices_on_plane(mesh, 2, 0.0));
}

TEST(SurfaceSets, AColourBetweenTwoVerticesIsBetweenTheirs) {
  TetMesh mesh = cube();
  RenderSurface surface = floor_and_ceiling();
  surface.colours[1] = surface.colours[2] = kBlue;  // the floor at x = 1
  add_surface_sets(surface, mesh);
  EXPECT_EQ(mesh.colours[0], kRed);
  EXPECT_EQ(mesh.colours[1], (Colour{128, 0, 128, 255}));
  EXPECT_EQ(mesh.colours[2], kBlue);
}

TEST(SurfaceSets, AnObjectThatIsNearestToNoVertexGetsThoseNearestToIt) {
  TetMesh mesh = cube();
  RenderSurface surface = floor_and_ceiling();
  surface.objects.emplace_back("button");
  const auto first = static_cast<VertexId>(surface.vertices.size());
  for (const double x : {0.24, 0.26, 0.25})  // farther away than the floor
    surface.vertices.emplace_back(x, x == 0.25 ? 0.26 : 0.24, -0.02);
  surface.colours.insert(surface.colours.end(), 3, kBlue);
  surface.triangles.push_back({first, first + 1, first + 2});
  surface.object_of.push_back(2);
  surface.material_of.push_back(0);
  add_surface_sets(surface, mesh);
  const Ids& button = mesh.node_sets.at("button");
  ASSERT_FALSE(button.empty());
  for (const VertexId id : button) EXPECT_LE(mesh.vertices[id].norm(), 0.75) << id;
}

TEST(SurfaceSets, TheMeshsOwnSetsAndColoursStay) {
  TetMesh mesh = cube();
  mesh.node_sets["floor"] = {26};
  mesh.colours.assign(27, kBlue);
  const std::vector<std::string> notes = add_surface_sets(floor_and_ceiling(), mesh);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("`floor`"), std::string::npos);
  EXPECT_EQ(mesh.node_sets.at("floor"), (Ids{26}));
  EXPECT_EQ(mesh.colours[0], kBlue);
}

TEST(SurfaceSets, ASurfaceWithoutColoursPaintsNothing) {
  TetMesh mesh = cube();
  RenderSurface surface = floor_and_ceiling();
  surface.colours.clear();
  add_surface_sets(surface, mesh);
  EXPECT_TRUE(mesh.colours.empty());
  EXPECT_TRUE(mesh.node_sets.contains("ceiling"));
}

}  // namespace
}  // namespace tremolo
