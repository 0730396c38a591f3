// A body of tetrahedra and a reduced body in contact: momenta and energy.
#include <algorithm>
#include <cmath>

#include "tests/mixed/mixed_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedSum;

TEST(MixedBodies, KeepBothMomentaAndTheEnergyOfThePair) {
  for (const double friction : {0.0, 0.5}) {
    const MixedKind kind{.friction = friction};
    MixedWorld world(kind.step);
    ContactBody reduced =
        testing::reduced_body(testing::reduced_cube("1e5"), kind, {-0.09, 0.01, -0.02});
    ASSERT_TRUE(reduced.set_motion({1.0, 0.2, 0}, {2, 5, -1}));
    ASSERT_TRUE(world.add("reduced", std::move(reduced)));
    TetBody tets = testing::tets_body(testing::tets_cube(1e5, 2), kind, {0.09, -0.01, 0.03},
                                      {-0.8, 0, 0.1}, {-3, 1, 4});
    ASSERT_TRUE(world.add("tets", std::move(tets), testing::contact_of(kind, {})));
    const MixedSum start = testing::sum_of(world);
    const Vector3d before = world.reduced(0)->linear_momentum();
    double worst_linear = 0.0, worst_angular = 0.0, worst_energy = 0.0, taken = 0.0, own = 0.0;
    int touched = 0, iterations = 0, linear = 0, islands = 0;
    for (int i = 0; i < 150; ++i) {
      TetBody& body = *world.tets(1);
      const double tets_before = body.kinetic_energy() + body.elastic_energy();
      const Status made = world.step();
      ASSERT_TRUE(made) << i << made.error().message;
      own += body.kinetic_energy() + body.elastic_energy() - tets_before - world.account(1).work;
      touched += world.account(1).active;
      iterations += world.report().iterations;
      linear += world.report().linear;
      islands += world.in_islands() != 0;
      for (std::size_t k : {0U, 1U}) taken += world.account(k).lost + world.account(k).rubbed;
      const MixedSum now = testing::sum_of(world);
      worst_linear = std::max(worst_linear, (now.linear - start.linear).norm());
      worst_angular = std::max(worst_angular, (now.angular - start.angular).norm());
      worst_energy = std::max(worst_energy, std::abs(now.energy + taken - own - start.energy));
    }
    std::printf("touched %d islands %d iterations %d linear %d: %g %g %g own %g taken %g of %g\n", touched,
                islands, iterations, linear, worst_linear, worst_angular, worst_energy, own, taken, start.energy);
    EXPECT_GT(touched, 5);
    EXPECT_GT((world.reduced(0)->linear_momentum() - before).norm(), 0.5);
  }
}

}  // namespace
}  // namespace tremolo
