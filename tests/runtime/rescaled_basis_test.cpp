// A rescaled model is the body of the other material: same energy of a displacement, same mass.
#include "formats/basis/rescaled_basis.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/reduced_energy.h"
#include "tests/support/tiny_basis.h"

namespace tremolo {
namespace {

TEST(RescaledBasis, HasTheEnergyOfAStifferMaterialForTheSameDisplacement) {
  const BasisData data = testing::tiny_basis();
  const double stiffness = 3.0, density = 7.0;
  const Result<BasisData> made = rescaled(data, stiffness, density);
  ASSERT_TRUE(made) << made.error().message;
  const Eigen::Vector2d q(0.3, -0.02);
  const Eigen::Vector2d other = std::sqrt(density) * q;  // moves the vertices equally
  EXPECT_TRUE((made->surface.rows * other).isApprox(data.surface.rows * q, 1e-14));
  EXPECT_TRUE((made->interior.rows * other).isApprox(data.interior.rows * q, 1e-14));
  const double before = reduced_energy(data.lambda, data.cubic, data.quartic, q).energy;
  const double after = reduced_energy(made->lambda, made->cubic, made->quartic, other).energy;
  EXPECT_NEAR(after, stiffness * before, 1e-13 * stiffness * before);
  EXPECT_NEAR(made->lambda[0], data.lambda[0] * stiffness / density, 1e-12);
  EXPECT_EQ(made->total_mass, 7 * data.total_mass);
}

TEST(RescaledBasis, ByOneIsTheSameAndThereAndBackToo) {
  const BasisData data = testing::tiny_basis();
  const Result<BasisData> same = rescaled(data, 1, 1);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->cubic, data.cubic);
  const Result<BasisData> there = rescaled(data, 2, 4);
  ASSERT_TRUE(there);
  const Result<BasisData> back = rescaled(*there, 0.5, 0.25);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->cubic, data.cubic);  // powers of two
  EXPECT_EQ(back->surface.rows, data.surface.rows);
}

TEST(RescaledBasis, RefusesFactorsThatAreNone) {
  for (const double factor : {0.0, -1.0, std::nan(""), 1e308 * 10}) {
    EXPECT_FALSE(rescaled(testing::tiny_basis(), factor, 1));
    EXPECT_FALSE(rescaled(testing::tiny_basis(), 1, factor));
  }
  EXPECT_FALSE(rescaled(testing::tiny_basis(), 1e308, 1e-10));
}

}  // namespace
}  // namespace tremolo
