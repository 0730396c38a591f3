#include "precompute/mesher/surface_mesher.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "tests/support/meshes/surfaces.h"

namespace tremolo {
namespace {

using namespace testing;

// The bounds that Tremolo states for good surfaces.
constexpr double kLeastAngle = 8.0;  // degrees
constexpr double kMostError = 0.01;  // of the diagonal

MeshedSurface mesh_well(const SurfaceMesh& surface, const SurfaceMeshOptions& options = {}) {
  Result<MeshedSurface> meshed = mesh_surface(as_render_surface(surface), options);
  if (!meshed) throw std::runtime_error(meshed.error().message);
  const SurfaceMeshReport& report = meshed->report;
  EXPECT_GE(report.quality.min_dihedral_deg, kLeastAngle);
  EXPECT_GT(report.quality.min_volume, 0.0);
  EXPECT_LE(report.mesh_to_surface, kMostError * report.diagonal);
  EXPECT_LE(report.surface_to_mesh, kMostError * report.diagonal);
  EXPECT_TRUE(check_mesh(meshed->mesh));
  return std::move(*meshed);
}

std::string refusal(const SurfaceMesh& surface, const SurfaceMeshOptions& options = {}) {
  const Result<MeshedSurface> meshed = mesh_surface(as_render_surface(surface), options);
  if (meshed) return "";
  EXPECT_EQ(meshed.error().kind, ErrorKind::kContent);
  return meshed.error().message;
}

TEST(SurfaceMesher, MeshesGoodSurfacesWell) {
  for (const SurfaceMesh& surface :
       {sphere_surface(1.0), torus_surface(1.0, 0.3),
        together(sphere_surface(1.0), reversed(sphere_surface(0.5)))}) {
    const MeshedSurface meshed = mesh_well(surface);
    // Chords that are 0.3 % of the diagonal off cost a tube of a twelfth of it 2 % of its volume.
    EXPECT_NEAR(meshed.report.quality.volume, enclosed_volume(surface),
                0.03 * enclosed_volume(surface));
    EXPECT_EQ(meshed.report.quality.parts, 1u);
  }
}

double printed(double x) {
  return std::round(x * 1e10) / 1e10;
}

// CGAL's cheese.off: floats of 0.05 m printed with ten decimals, so that its planes are 1e-9 of its
// size off. With those numbers meshing takes ten times as long as with the floats.
TEST(SurfaceMesher, FloatsThatWerePrintedInDecimalsComeBack) {
  std::vector<Eigen::Vector3d> floats, decimals, doubles;
  for (int i = 1; i <= 40; ++i) {
    const Eigen::Vector3d x = 0.05 * Eigen::Vector3d(std::sin(i), std::sin(3 * i), std::cos(i));
    // Floats below 0.001 are closer together than ten decimals are.
    if (x.cwiseAbs().minCoeff() < 0.001) continue;
    floats.push_back(x.unaryExpr([](double v) { return double(float(v)); }));
    decimals.push_back(floats.back().unaryExpr(&printed));
    doubles.push_back(x);
  }
  const std::vector<Eigen::Vector3d> given = doubles;
  restore_printed_floats(decimals, 1.0);
  EXPECT_EQ(decimals, floats);
  restore_printed_floats(doubles, 1.0);
  EXPECT_EQ(doubles, given);

  std::vector<Eigen::Vector3d> inches = floats;
  for (Eigen::Vector3d& x : inches) x = 0.0254 * x.unaryExpr(&printed);
  restore_printed_floats(inches, 0.0254);
  for (std::size_t i = 0; i < inches.size(); ++i) EXPECT_EQ(inches[i], 0.0254 * floats[i]);
}

TEST(SurfaceMesher, KeepsSharpEdges) {
  const MeshedSurface meshed = mesh_well(box_surface({1.0, 2.0, 0.5}));
  // Faces are plane and edges are kept: nothing is left but rounding.
  EXPECT_NEAR(meshed.report.quality.volume, 1.0, 1e-9);
  EXPECT_LE(meshed.report.surface_to_mesh, 1e-9);
}

// A bar's sharp edges ask for more than that, unless the distance to the surface is given up.
TEST(SurfaceMesher, ANumberOfTetrahedraThatIsMissedIsTold) {
  const auto is_reported_missed = [](const SurfaceMeshOptions& options, std::size_t& count) {
    const Result<MeshedSurface> meshed =
        mesh_surface(as_render_surface(box_surface({1.0, 0.1, 0.1})), options);
    EXPECT_TRUE(meshed);
    count = meshed->mesh.tetrahedra.size();
    std::string all;
    for (const std::string& line : describe(meshed->report)) all += line + "\n";
    return all.find(std::to_string(options.tets) + " tetrahedra were asked for, " +
                    std::to_string(count) + " came out") != std::string::npos;
  };
  for (const int wanted : {100, 300, 1000, 4000}) {
    std::size_t count = 0;
    const bool miss = is_reported_missed({.tets = wanted}, count);
    const double share = static_cast<double>(count) / wanted;
    EXPECT_EQ(miss, std::abs(share - 1.0) > 0.1) << wanted << ": " << count;
    // The nearest of six tries: the last one of them gave nine times as many.
    EXPECT_LE(share, wanted >= 300 ? 3.0 : 10.0) << wanted << ": " << count;
  }
}

TEST(SurfaceMesher, UnitsAndPlaceChangeNothingButUnitsAndPlace) {
  const SurfaceMesh surface = torus_surface(1.0, 0.3);
  const MeshedSurface plain = mesh_well(surface);
  for (const double factor : {1e-6, 1e6}) {
    SurfaceMesh other = surface;
    for (Eigen::Vector3d& x : other.vertices) x *= factor;
    EXPECT_NEAR(mesh_well(other).report.quality.volume / (factor * factor * factor),
                plain.report.quality.volume, 0.01 * plain.report.quality.volume);
  }
  SurfaceMesh far = surface;
  for (Eigen::Vector3d& x : far.vertices) x += Eigen::Vector3d(1e5, -3e5, 2e5);
  EXPECT_NEAR(mesh_well(far).report.quality.volume, plain.report.quality.volume,
              0.01 * plain.report.quality.volume);
}

TEST(SurfaceMesher, GivesTheSameMeshForTheSameInput) {
  const MeshedSurface a = mesh_well(sphere_surface(1.0)), b = mesh_well(sphere_surface(1.0));
  EXPECT_EQ(a.mesh.tetrahedra, b.mesh.tetrahedra);
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
}

TEST(SurfaceMesher, MeetsTheCountAndTheSizeAskedFor) {
  for (const int wanted : {2'000, 20'000})
    EXPECT_NEAR(static_cast<double>(
                    mesh_well(torus_surface(1.0, 0.3), {.tets = wanted}).mesh.tetrahedra.size()),
                wanted, 0.1 * wanted);
  // Half the size, eight times the tetrahedra; facets on the surface blur it.
  const auto count = [](double size) {
    return static_cast<double>(
        mesh_well(box_surface({1.0, 1.0, 1.0}), {.size = size}).mesh.tetrahedra.size());
  };
  EXPECT_NEAR(std::log2(count(0.1) / count(0.2)), 3.0, 0.5);
}

TEST(SurfaceMesher, ClosesASmallHole) {
  const SurfaceMesh open = sphere_surface(1.0, 24, 48, 0.3);
  const MeshedSurface meshed = mesh_well(open);
  EXPECT_EQ(meshed.report.findings.holes, 1u);
  EXPECT_NEAR(meshed.report.quality.volume, 4.0 / 3.0 * std::numbers::pi, 0.1);
  EXPECT_GT(meshed.report.cap_to_surface, 0.0);
}

TEST(SurfaceMesher, MeshesWhatRunsThroughItself) {
  // A tube along a figure of eight: where it crosses itself the solid angle is two.
  SurfaceMesh eight = torus_surface(1.0, 0.15, 96, 16);
  for (std::size_t i = 0; i < 96; ++i) {
    const double a = 2.0 * std::numbers::pi * static_cast<double>(i) / 96.0;
    const Eigen::Vector3d centre(std::sin(a), std::sin(a) * std::cos(a), 0.0);
    const Eigen::Vector3d along = Eigen::Vector3d(std::cos(a), std::cos(2.0 * a), 0.0).normalized();
    for (std::size_t j = 0; j < 16; ++j) {
      const double b = 2.0 * std::numbers::pi * static_cast<double>(j) / 16.0;
      eight.vertices[16 * i + j] =
          centre + 0.15 * (std::cos(b) * Eigen::Vector3d(along[1], -along[0], 0.0) +
                           std::sin(b) * Eigen::Vector3d::UnitZ());
    }
  }
  const MeshedSurface meshed = mesh_well(eight);
  EXPECT_GT(meshed.report.findings.crossings, 0u);
  EXPECT_EQ(meshed.report.quality.parts, 1u);
  // Less than the tube, by about once the overlap.
  EXPECT_LT(meshed.report.quality.volume, enclosed_volume(eight));
  EXPECT_GT(meshed.report.quality.volume, 0.85 * enclosed_volume(eight));
}

TEST(SurfaceMesher, AFinBoundsNothing) {
  SurfaceMesh fin = box_surface({1.0, 1.0, 1.0});
  fin.vertices.push_back({0.5, 0.5, 1.6});
  fin.triangles.push_back({4, 7, 8});
  EXPECT_NEAR(mesh_well(fin).report.quality.volume, 1.0, 0.02);
}

TEST(SurfaceMesher, LeavesCrumbsOutUnlessAsked) {
  SurfaceMesh crumb = sphere_surface(0.05);
  for (Eigen::Vector3d& x : crumb.vertices) x += Eigen::Vector3d(1.3, 0, 0);
  const SurfaceMesh both = together(sphere_surface(1.0), crumb);
  EXPECT_EQ(mesh_well(both).report.quality.parts, 1u);
  SurfaceMeshOptions options;
  options.keep_crumbs = true;
  EXPECT_EQ(mesh_surface(as_render_surface(both), options)->report.quality.parts, 2u);
}

TEST(SurfaceMesher, RefusesSheetsWithAdviceAndThickensThem) {
  EXPECT_NE(refusal(plane_surface(8)).find("--thicken"), std::string::npos);
  EXPECT_NE(refusal(strip_surface(1)).find("--thicken"), std::string::npos);
  EXPECT_NE(refusal(sphere_surface(1.0, 24, 48, 1.5)).find("--fill-holes"), std::string::npos);
  const MeshedSurface plate = mesh_well(plane_surface(8), {.thicken = 0.05});
  // A rounded rim: area times thickness, and half a tube of radius 0.025 along 4 m.
  EXPECT_NEAR(plate.report.quality.volume, 0.05 + 4.0 * 0.5 * std::numbers::pi * 0.025 * 0.025,
              2e-3);
  EXPECT_GT(mesh_well(strip_surface(1), {.thicken = 0.08}).report.quality.volume, 0.0);
}

TEST(SurfaceMesher, SaysWhenWallsAreTooThin) {
  const SurfaceMesh shell = together(sphere_surface(1.0), reversed(sphere_surface(0.999)));
  const std::string message = refusal(shell);
  EXPECT_NE(message.find("thick"), std::string::npos);
  EXPECT_NE(message.find("--tets"), std::string::npos);
}

// The volume is length times area of the walls. With the size that the message advises the walls
// are there.
TEST(SurfaceMesher, WallsThatTheSizeWouldLoseAreRefusedWithTheSizeThatKeepsThem) {
  const SurfaceMesh plate = box_surface({0.3, 0.2, 0.001});
  const std::string message = refusal(plate);
  EXPECT_NE(message.find("walls are about 0.001 m thick"), std::string::npos) << message;
  EXPECT_NE(message.find("--tets"), std::string::npos) << message;
  const std::size_t at = message.find("--size ");
  ASSERT_NE(at, std::string::npos) << message;
  const double size = std::stod(message.substr(at + 7));
  // A smaller plate of the same thickness takes less time.
  const SurfaceMesh part = box_surface({0.025, 0.02, 0.001});
  EXPECT_NEAR(mesh_well(part, {.size = size}).report.quality.volume, 5e-7, 1e-12);
}

// A thin ring of which chords cut off more than 2 %. The number in the warning is that of the two
// volumes; a finer mesh needs no warning.
TEST(SurfaceMesher, AVolumeThatIsOffIsTold) {
  const SurfaceMesh ring = torus_surface(1.0, 0.05, 96, 32);
  const auto warning = [&ring](const SurfaceMeshOptions& options, double& off) {
    const Result<MeshedSurface> meshed = mesh_surface(as_render_surface(ring), options);
    EXPECT_TRUE(meshed);
    off = 1.0 - meshed->report.quality.volume / enclosed_volume(ring);
    for (const std::string& line : meshed->report.notes)
      if (line.starts_with("warning: the mesh has ")) return std::stod(line.substr(22));
    return 0.0;
  };
  double off = 0;
  const double told = warning({}, off);
  EXPECT_GT(off, 0.02);
  EXPECT_NEAR(told, 100.0 * off, 0.1);
  EXPECT_EQ(warning({.error = 0.001}, off), 0.0);
  EXPECT_LT(off, 0.02);
}

// The sampled distance of the ring's mesh is above the one asked for.
TEST(SurfaceMesher, ADistanceThatIsMissedIsTold) {
  const auto far = [](double error, bool& told) {
    const Result<MeshedSurface> meshed =
        mesh_surface(as_render_surface(torus_surface(1.0, 0.05, 96, 32)), {.error = error});
    EXPECT_TRUE(meshed);
    told = false;
    for (const std::string& line : meshed->report.notes)
      told = told || line.find("where --error asked for") != std::string::npos;
    return std::max(meshed->report.mesh_to_surface, meshed->report.surface_to_mesh);
  };
  for (const double error : {0.02, 0.003, 0.001}) {
    bool told = false;
    const double found = far(error, told);
    EXPECT_EQ(told, found > 1.1 * error) << error << ": " << found;
  }
}

TEST(SurfaceMesher, RefusesNothingAtAll) {
  EXPECT_NE(refusal(SurfaceMesh{}), "");
  SurfaceMesh line = plane_surface(1);
  for (Eigen::Vector3d& x : line.vertices) x[1] = 0;
  EXPECT_NE(refusal(line), "");
}

}  // namespace
}  // namespace tremolo
