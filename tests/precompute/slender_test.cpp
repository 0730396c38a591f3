// Slender beams on fine meshes: the forces of their slow bending are small relative to what the
// last digit of a displacement makes, but the frequencies are right, and the precompute gives them.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/computed_basis.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"

namespace tremolo {
namespace {

struct Slender {
  double scaled_frequency = 0;  // f_1 L / h, Hz
  double residual = 0;          // of the first mode
  bool certified = false;
};

Slender cantilever(const TetMesh& mesh, const std::string& fix, int modes) {
  PrecomputeRequest request = testing::basis_request({2e11, 0.0, 7800.0}, fix);
  request.basis.linear = true;
  request.basis.linear_modes = request.basis.modes = modes;
  const PrecomputeResult result = testing::compute_basis(mesh, request).result;
  return {std::sqrt(result.data.lambda[0]), result.findings.mode_residuals.front(),
          result.findings.certified};
}

// L = 1 m and h = 1/slenderness, 3/2 as wide, with the same cells whatever h is.
Slender flat_cantilever(int slenderness) {
  const double thickness = 1.0 / slenderness;
  Slender beam = cantilever(
      testing::box_mesh({2 * slenderness, 2, 3}, {1.0, thickness, 1.5 * thickness}), "x<1e-9", 2);
  beam.scaled_frequency /= thickness;
  return beam;
}

TEST(Slender, FineMeshesOfSlenderBeamsAreNotRefusedForRounding) {
  const Slender stout = flat_cantilever(50), slender = flat_cantilever(400);
  EXPECT_LT(stout.residual, 1e-6);
  EXPECT_GT(slender.residual, 1e-6);  // else this test is about nothing
  // Both meshes lock equally; shear is worth 1e-4 of the stouter one, and rounding less.
  EXPECT_NEAR(slender.scaled_frequency / stout.scaled_frequency, 1.0, 5e-4);
}

// Its modes come in pairs that rounding parts by 1e-6: the certificate must not look between them.
TEST(Slender, PairsOfASlenderSquareBeamAreCertified) {
  const double thickness = 1.0 / 400;
  const TetMesh mesh = testing::symmetric_box({400, 2, 2}, {1.0, thickness, thickness});
  for (const int modes : {1, 2, 3, 4})
    EXPECT_TRUE(cantilever(mesh, "x<-0.4999", modes).certified) << modes;
}

}  // namespace
}  // namespace tremolo
