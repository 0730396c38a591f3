// `tremolo-precompute collider` as a user meets it: surfaces become files that the engine loads.
#include <filesystem>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/mesh/surface_mesh.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/surface/surface_writer.h"
#include "runtime/contact/collider.h"
#include "tests/support/distance_fields.h"
#include "tests/support/meshes/surfaces.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

class ColliderProgram : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }

  ProgramResult collider(const std::string& arguments) {
    return run_program(folder_, kMayBeRoot + kPrecompute + " collider " + arguments);
  }
  json made(const std::string& arguments) {
    const ProgramResult result = collider(arguments + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? json::parse(result.out) : json();
  }
  Collider loaded(const std::string& name) {
    const Result<Collider> shape = load_collider(folder_ + "/" + name);
    EXPECT_TRUE(shape) << shape.error().message;
    return shape ? *shape : Collider();
  }
  void save(const std::string& name, const SurfaceMesh& surface) {
    EXPECT_TRUE(write_surface(folder_ + "/" + name, surface));
  }
  void expect_collider_failure(const std::string& arguments, int code, const std::string& words) {
    const ProgramResult result = collider(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << arguments << "\n" << result.err;
  }
  // Files of the folder with this ending, and temporary ones.
  std::size_t files_of(const std::string& ending) const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      count += name.ends_with(ending) || name.find(".partial") != std::string::npos ? 1 : 0;
    }
    return count;
  }

  std::string folder_;
};

TetMesh sample_mesh(const std::string& name) {
  Result<MeshFile> file =
      read_tet_mesh(std::string(TREMOLO_SOURCE_DIR) + "/assets/meshes/" + name + ".msh");
  EXPECT_TRUE(file);
  return file ? std::move(file->mesh) : TetMesh{};
}

// Vertices of the boundary are on the surface; inner vertices are inside, by at most their distance
// from the nearest boundary vertex.
TEST_F(ColliderProgram, SampleSurfacesKeepTheirShape) {
  for (const char* name : {"horse", "basket"}) {
    const TetMesh mesh = sample_mesh(name);
    save("a.ply", boundary_mesh(mesh));
    const json report = made("a.ply -o a.collider");
    ASSERT_FALSE(report.is_null());
    EXPECT_LE(report["error_max_share"], 0.005);
    EXPECT_EQ(report["holes_closed"], 0);
    EXPECT_EQ(report["file_bytes"], std::filesystem::file_size(folder_ + "/a.collider"));
    const Collider shape = loaded("a.collider");
    const double error = 1.2 * static_cast<double>(report["error_max"]);
    for (const VertexId v : boundary_surface(mesh).vertex_ids)
      EXPECT_NEAR(signed_distance(shape, mesh.vertices[v]).distance, 0.0, error) << name;
    for (const Tetrahedron& tet : mesh.tetrahedra) {
      Vector3d middle = Vector3d::Zero();
      for (const VertexId v : tet) middle += 0.25 * mesh.vertices[v];
      EXPECT_LT(signed_distance(shape, middle).distance, error) << name;
      const Vector3d beyond = 4.0 * middle + Vector3d(0, 0, 2.0);
      EXPECT_GT(signed_distance(shape, beyond).distance, 1.0);
      const std::optional<double> hit = first_hit(shape, beyond, middle);
      EXPECT_TRUE(hit || signed_distance(shape, middle).distance > 0.0);
    }
    EXPECT_NEAR(largest_extent(shape), report["size"],
                4.0 * static_cast<double>(report["spacing"]));
  }
}

TEST_F(ColliderProgram, ABoundaryOfAMeshIsASurface) {
  const json report =
      made(std::string(TREMOLO_SOURCE_DIR) + "/assets/meshes/beam.msh -o b.collider");
  EXPECT_EQ(report["cells"], 64);
  EXPECT_NE(report["format"].get<std::string>().find("boundary"), std::string::npos);
  EXPECT_EQ(bounds(loaded("b.collider")).high.allFinite(), true);
}

TEST_F(ColliderProgram, UnitAndUpAxisAreTaken) {
  save("box.obj", testing::box_surface({1600, 1800, 1400}, {-800, -900, -700}));
  const json report = made("box.obj -o box.collider --unit mm --up y --cells 40 --margin 0.3");
  EXPECT_EQ(report["cells"], 40);
  EXPECT_NEAR(report["margin"], 0.3, 1e-12);
  EXPECT_NEAR(report["size"], 1.8, 1e-12);
  const Collider shape = loaded("box.collider");
  // (x, y, z) -> (x, -z, y)
  const testing::DistanceFormula formula = testing::box_formula({0.8, 0.7, 0.9});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1.1, 1.1);
  for (int trial = 0; trial < 1000; ++trial) {
    const double a = number(random), b = number(random), c = number(random);
    const Vector3d x(a, 0.9 * b, 1.05 * c);
    // At the corners and on the middle surfaces the error is a share of a cell, 0.045 m.
    EXPECT_NEAR(signed_distance(shape, x).distance, formula(x), 0.3 * 0.045);
  }
}

TEST_F(ColliderProgram, WithoutCellsTheErrorDecides) {
  // Across the cells and thinner than one of 64: some of it would be missed.
  SurfaceMesh plate_mesh = testing::box_surface({1.0, 0.7, 0.006});
  for (Vector3d& x : plate_mesh.vertices) x.z() += 0.1 * x.x() + 0.03 * x.y();
  save("plate.obj", plate_mesh);
  const json report = made("plate.obj -o plate.collider");
  EXPECT_GT(report["cells"], 64);
  EXPECT_LE(report["error_max_share"], 0.005);
  const Collider plate = loaded("plate.collider");
  EXPECT_LE(report["missed_share"], 0.002);
  for (int i = 1; i < 50; ++i)
    for (int j = 1; j < 35; ++j)
      EXPECT_TRUE(first_hit(plate, {0.02 * i, 0.02 * j, 0.7}, {0.02 * i, 0.02 * j, -0.7}));
}

TEST_F(ColliderProgram, HolesAreClosedAndTold) {
  save("holed.ply", testing::sphere_surface(1.0, 40, 80, 0.1));
  const json report = made("holed.ply -o ball.collider --cells 24");
  EXPECT_EQ(report["holes_closed"], 1);
  EXPECT_NEAR(signed_distance(loaded("ball.collider"), {0, 0, 0.9}).distance, -0.1, 0.01);
  save("bowl.ply", testing::sphere_surface(1.0, 40, 80, 1.5));
  expect_collider_failure("bowl.ply -o bowl.collider", 3, "bowl.ply: the surface is open");
  EXPECT_EQ(made("bowl.ply -o bowl.collider --fill-holes --cells 24")["holes_closed"], 1);
}

TEST_F(ColliderProgram, ErrorsAreNamedAndLeaveNothing) {
  save("sheet.obj", testing::plane_surface(4));
  save("box.obj", testing::box_surface({1, 1, 1}));
  save("foil.obj", testing::box_surface({1, 1, 0.001}));
  std::ofstream(folder_ + "/noise.obj") << "v 1 2\nnonsense\n";
  std::ofstream(folder_ + "/noise.stl") << std::string(300, 'x');
  expect_collider_failure("sheet.obj -o a.collider", 3, "sheet.obj: the surface is open");
  expect_collider_failure("sheet.obj -o a.collider --fill-holes", 3, "encloses no volume");
  expect_collider_failure("foil.obj -o a.collider --cells 16", 3, "no node of the grid is inside");
  expect_collider_failure("box.obj -o a.collider --cells 2000", 3, "cells are possible");
  expect_collider_failure("noise.obj -o a.collider", 3, "noise.obj: ");
  expect_collider_failure("noise.stl -o a.collider", 3, "noise.stl: ");
  expect_collider_failure("missing.obj -o a.collider", 1, "missing.obj: ");
  expect_collider_failure("box.obj -o missing/a.collider", 1, "missing/a.collider");
  expect_collider_failure("box.obj -o box.obj", 2, "box.obj");
  expect_collider_failure("box.obj", 2, "--output");
  expect_collider_failure("-o a.collider", 2, "surface");
  expect_collider_failure("box.obj -o a.collider --cells 1", 2, "--cells");
  expect_collider_failure("box.obj -o a.collider --margin -1", 2, "--margin");
  expect_collider_failure("box.obj -o a.collider --unit parsec", 2, "parsec");
  expect_collider_failure("box.obj -o a.collider --frobnicate", 2, "frobnicate");
  EXPECT_EQ(files_of(".collider"), 0U);
  EXPECT_EQ(collider("--help").code, 0);
}

TEST_F(ColliderProgram, TheSameSurfaceGivesTheSameFile) {
  save("torus.ply", testing::torus_surface(1.0, 0.4));
  made("torus.ply -o torus.collider --cells 24");
  const std::string first = slurp(folder_ + "/torus.collider");
  made("torus.ply -o torus.collider --cells 24 --threads 1");
  const std::string second = slurp(folder_ + "/torus.collider");
  EXPECT_GT(first.size(), 20000U);
  EXPECT_TRUE(first == second);
}

}  // namespace
}  // namespace tremolo
