// The nearest rotation against its definition.
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runtime/bodies/tets/elements/element_turn.h"
#include "tests/support/meshes/random_tet.h"

namespace tremolo {
namespace {

using testing::TetRandom;

TEST(NearestRotation, IsTheFactorOfAStretchedRotation) {
  TetRandom random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Matrix3d turn = random.rotation(), axes = random.rotation();
    const Eigen::Vector3d stretch(random.between(0.01, 3.0), random.between(0.01, 3.0),
                                  random.between(0.01, 3.0));
    const Eigen::Matrix3d a = turn * axes * stretch.asDiagonal() * axes.transpose();
    EXPECT_LE((nearest_rotation(a) - turn).norm(), 1e-12);
  }
}

TEST(NearestRotation, IsNearerThanAnyOtherAlsoToWhatIsInsideOut) {
  TetRandom random(2);
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::Matrix3d a;
    for (int j = 0; j < 3; ++j) a.col(j) = random.vector(1.0);
    if (trial % 4 == 0) a.col(2) = a.col(0) + a.col(1);  // flat
    const Eigen::Matrix3d nearest = nearest_rotation(a);
    EXPECT_LE((nearest.transpose() * nearest - Eigen::Matrix3d::Identity()).norm(), 1e-13);
    EXPECT_GT(nearest.determinant(), 0.0);
    for (int other = 0; other < 50; ++other) {
      const Eigen::Matrix3d turned =
          other < 25 ? random.rotation()
                     : Eigen::Matrix3d(nearest * rotation_by(random.vector(0.05)));
      EXPECT_LE((a - nearest).norm(), (a - turned).norm() + 1e-14);
    }
  }
}

TEST(NearestRotation, IsARotationForWhateverComes) {
  const double kInf = std::numeric_limits<double>::infinity();
  for (const double value : {0.0, 1e-300, 1e300, kInf, std::nan("")}) {
    const Eigen::Matrix3d turn = nearest_rotation(Eigen::Matrix3d::Constant(value));
    EXPECT_LE((turn.transpose() * turn - Eigen::Matrix3d::Identity()).norm(), 1e-13);
    EXPECT_NEAR(turn.determinant(), 1.0, 1e-13);
  }
}

TEST(NearestRotation, OfASmallTurnIsThatTurn) {
  const Eigen::Vector3d w(1e-9, -2e-9, 3e-9);
  EXPECT_LE((nearest_rotation(rotation_by(w)) - rotation_by(w)).norm(), 1e-15);
  EXPECT_LE((axial(rotation_by(w)) + 2.0 * w).norm(), 1e-17);
}

}  // namespace
}  // namespace tremolo
