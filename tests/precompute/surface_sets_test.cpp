// Colours, objects and materials of a surface, on the mesh.
#include "precompute/embedding/surface_sets.h"

#include <gtest/gtest.h>

#include "common/mesh/selector.h"
#include "precompute/problem/material_rules.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/surfaces.h"

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

// The corners of a box are all the vertices of its surface: those of a face mean the whole face.
TEST(SurfaceSets, NumbersOfTheSurfaceMeanItsPlaces) {
  TetMesh mesh = testing::box_mesh({4, 3, 3}, {2, 1, 1});
  add_given_vertices(testing::as_render_surface(testing::box_surface({2, 1, 1})), mesh);
  const auto chosen = [&mesh](const std::string& text) {
    const Result<Ids> ids = select_vertices(*parse_selector(text), mesh);
    return ids ? *ids : Ids{};
  };
  EXPECT_EQ(chosen("vertex:0,2,4,6"), testing::vertices_on_plane(mesh, 0, 0.0));
  EXPECT_EQ(chosen("vertex:4,5,6,7"), testing::vertices_on_plane(mesh, 2, 1.0));
  for (VertexId corner = 0; corner < 8; ++corner) {
    const Ids one = chosen("vertex:" + std::to_string(corner));
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(mesh.vertices[one[0]],
              Eigen::Vector3d(2.0 * (corner & 1), corner >> 1 & 1, corner >> 2));
  }
  EXPECT_EQ(chosen("vertex:0,1").size(), 5u) << "an edge of four elements";
  EXPECT_EQ(chosen("vertex:0,7").size(), 2u) << "opposite corners";
  EXPECT_EQ(chosen("vertex:0,1,2,3,4,5,6,7").size(), boundary_surface(mesh).vertex_ids.size());
  EXPECT_TRUE(chosen("vertex:8").empty()) << "the mesh has it, the surface has not";
}

// Of a surface far finer than the mesh a few triangles may have no vertex of the mesh over them.
TEST(SurfaceSets, SmallTrianglesMeanTheVerticesNextToThem) {
  TetMesh mesh = testing::box_mesh({2, 2, 2}, {1, 1, 1});
  RenderSurface surface = testing::as_render_surface(testing::plane_surface(64));
  add_given_vertices(surface, mesh);
  const Result<Ids> ids = select_vertices(*parse_selector("vertex:66,67,131"), mesh);
  ASSERT_TRUE(ids);
  ASSERT_EQ(ids->size(), 1u);
  EXPECT_EQ(mesh.vertices[ids->front()], Eigen::Vector3d::Zero());
}

double volume_of(const std::string& name, const TetMesh& mesh) {
  double sum = 0;
  for (const std::int32_t t : mesh.solids.at(name)) sum += signed_volume(mesh, mesh.tetrahedra[t]);
  return sum;
}

// Two objects side by side, and one that floats within the left one. Each has its own volume.
TEST(SurfaceSets, ObjectsHoldTheTetrahedraInsideThem) {
  using testing::box_surface;
  TetMesh mesh = testing::box_mesh({8, 4, 4}, {2, 1, 1});
  const SurfaceMesh bone = box_surface({0.5, 0.5, 0.5}, {0.25, 0.25, 0.25});
  const SurfaceMesh all = testing::together(
      testing::together(box_surface({1, 1, 1}), box_surface({1, 1, 1}, {1, 0, 0})), bone);
  RenderSurface surface = testing::as_render_surface(all);
  surface.objects = {"left", "right", "bone"};
  for (std::size_t t = 0; t < 36; ++t) surface.object_of[t] = static_cast<std::uint32_t>(t / 12);
  add_solids(surface, mesh);
  EXPECT_NEAR(volume_of("bone", mesh), 0.125, 1e-12);
  EXPECT_NEAR(volume_of("left", mesh), 0.875, 1e-12);
  EXPECT_NEAR(volume_of("right", mesh), 1.0, 1e-12);
  EXPECT_NEAR(volume_of("plain", mesh), 2.0, 1e-12) << "the material of all";

  // A rule for the object takes these, not those that have all vertices on the boundary.
  Material heavy;
  heavy.density = 5000;
  const Result<MaterialTable> table =
      assign_materials({{"left", heavy, parse_selector("left")}}, Material{}, mesh, {});
  ASSERT_TRUE(table) << table.error().message;
  const std::vector<MaterialShare> shares = material_shares(*table, mesh);
  ASSERT_EQ(shares.size(), 2u);
  EXPECT_NEAR(shares[1].volume, 0.875, 1e-12);
}

}  // namespace
}  // namespace tremolo
