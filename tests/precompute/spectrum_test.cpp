// Slender beams of solid elements against Euler-Bernoulli: omega_n = (beta_n L)^2 sqrt(E I / (rho A
// L^4)). nu = 0 and L/h = 50, so that the solid's own limit differs only by shear and rotary
// inertia, omega (1 - 0.1417 (beta_n h)^2) after Timoshenko with shear factor 5/6.
//
// Linear tetrahedra lock in bending: with c cells across the thickness the frequencies come out too
// high by an error that falls as c^-2. The test refines, extrapolates, and prints how fine a mesh
// has to be.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "precompute/system/failure.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::vertices_on_plane;

constexpr double kLength = 1.0;
constexpr double kThickness = 0.02;  // along y: the bending that is compared
constexpr double kWidth = 0.03;      // along z: bends 1.5 times as fast, distinguished by direction
const Material kSteelLike{2e11, 0.0, 7800.0};

// Angular frequencies of the first three modes that move mostly along y.
Eigen::Vector3d bending_frequencies(int cells_across, bool both_ends) {
  const TetMesh mesh =
      box_mesh({50 * cells_across / 2, cells_across, cells_across}, {kLength, kThickness, kWidth});
  std::vector<VertexId> fixed = vertices_on_plane(mesh, 0, 0.0);
  if (both_ends) {
    const std::vector<VertexId> far = vertices_on_plane(mesh, 0, kLength);
    fixed.insert(fixed.end(), far.begin(), far.end());
  }
  std::sort(fixed.begin(), fixed.end());
  const DofMap map = make_dof_map(mesh, fixed, 1);
  const LocalDofs local = local_dofs(mesh, map, 0);
  const Solid solid = make_solid(mesh, kSteelLike);
  const Matrices matrices = assemble(solid, map, local, MassKind::kConsistent);
  const Modes modes = testing::SolvedPencil(matrices).modes(7);
  Eigen::Vector3d found = Eigen::Vector3d::Zero();
  int count = 0;
  for (Eigen::Index i = 0; i < 7 && count < 3; ++i) {
    const Eigen::Map<const Eigen::Matrix3Xd> motion(modes.vectors.col(i).data(), 3, local.nodes);
    if (motion.row(1).squaredNorm() > motion.row(2).squaredNorm() &&
        motion.row(1).squaredNorm() > motion.row(0).squaredNorm())
      found[count++] = std::sqrt(modes.squared_frequencies[i]);
  }
  EXPECT_EQ(count, 3);
  return found;
}

void check_spectrum(const char* name, bool both_ends, const Eigen::Vector3d& beta_l_squared) {
  const double inertia_radius = kThickness / std::sqrt(12.0);
  const double unit =
      std::sqrt(kSteelLike.young / kSteelLike.density) * inertia_radius / (kLength * kLength);
  Eigen::Vector3d levels[3];
  const int cells[3] = {2, 4, 8};
  for (int level = 0; level < 3; ++level)
    levels[level] = bending_frequencies(cells[level], both_ends);
  std::printf("%s: frequency over Euler-Bernoulli's; observed order; limit; Timoshenko\n", name);
  for (int n = 0; n < 3; ++n) {
    const double exact = beta_l_squared[n] * unit;
    const double coarse = levels[0][n] / exact, middle = levels[1][n] / exact;
    const double fine = levels[2][n] / exact;
    // Stiffness converges: omega^2 has the clean expansion in the cell size.
    const double order =
        std::log2((coarse * coarse - middle * middle) / (middle * middle - fine * fine));
    const double limit = std::sqrt(fine * fine + (fine * fine - middle * middle) / 3.0);
    const double wave = std::sqrt(beta_l_squared[n]) * kThickness / kLength;
    const double timoshenko = 1.0 - 0.1417 * wave * wave;
    std::printf("  mode %d: %d/%d/%d cells %.4f %.4f %.4f; %.2f; %.4f; %.4f\n", n + 1, cells[0],
                cells[1], cells[2], coarse, middle, fine, order, limit, timoshenko);
    EXPECT_NEAR(order, 2.0, 0.25);
    // The remaining error of the second-order extrapolation, relative to that of the finest mesh.
    EXPECT_NEAR(limit, timoshenko, 0.1 * std::abs(fine - limit));
    EXPECT_NEAR(limit, 1.0, 0.01);  // Euler-Bernoulli itself, within shear at L/h = 50
  }
}

TEST(Spectrum, ASlenderCantileverConvergesToEulerBernoulli) {
  check_spectrum("cantilever", false, {3.5160, 22.0345, 61.6972});
}

TEST(Spectrum, AClampedClampedBeamConvergesToEulerBernoulli) {
  check_spectrum("clamped-clamped", true, {22.3733, 61.6728, 120.9034});
}

}  // namespace
}  // namespace tremolo
