// Conjugate gradients over active control points: what smooth modes save and what they leave alone.
#include "runtime/bodies/tets/solve/active_solve.h"

#include <gtest/gtest.h>

#include "common/elements/elasticity.h"
#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/bodies/tets/elements/tet_system.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using namespace testing;

// A x = b of a rotated bar with a step's mass and stiffness, in single precision, with smooth modes
// or without: how many directions it took, and the solution.
struct Searched {
  int iterations = 0;
  Eigen::VectorXd x;
};
Searched search(const TetModel& model, const TetSystem& system, const BlockMatrix& matrix,
                double mass, const Eigen::VectorXd& b, bool smooth) {
  ActiveSolve solve(model.pattern(), model.smooth());
  solve.choose(system.active());
  solve.take_diagonal(matrix);
  if (smooth) solve.take_smooth(system.mean_rotation(), mass, 1.0);
  Searched found;
  SearchSizes now = solve.start(matrix, b, true);
  const double stop = 1e-8 * now.square;
  while (now.square > stop && found.iterations < 2000) {
    const double along = solve.multiply(matrix);
    const double before = now.product;
    now = solve.advance(before / along);
    solve.turn(now.product / before);
    ++found.iterations;
  }
  found.x.resize(b.size());
  solve.finish(found.x);
  return found;
}

TEST(ActiveSolve, SmoothModesSaveMostDirectionsAndChangeNoSolution) {
  TetRandom random(11);
  for (const bool held : {false, true})
    for (const bool mixed : {false, true}) {
      const TetModelPointer model = tet_bar({8, 2, 2}, {0.4, 0.1, 0.1}, held);
      TetSystem system(model, RotationLaw::kLeastEnergy);
      if (mixed) system.set_degrees(random_degrees(random, model->edges()));
      // Turned by a radian, which the modes follow, and bent a little, which they do not.
      Eigen::VectorXd x = model->rest();
      const Eigen::Matrix3d turn = rotation_by({0.6, -0.5, 0.7});
      for (Eigen::Index i = 0; i < x.size(); i += 3) {
        x[i + 2] += 0.4 * x[i] * x[i];
        x.segment<3>(i) = Eigen::Vector3d(turn * x.segment<3>(i));
      }
      system.follow_ends(x);
      system.evaluate(x);
      BlockMatrix matrix(model->pattern());
      const double mass = 3600.0;  // of a step of 1/60 s
      system.assemble({mass, {1.0, 0.0, TangentKind::kFrozen}}, matrix);
      // Right-hand side like that of a step: a push of the whole body, and of each control point.
      Eigen::VectorXd b = random_state(random, x.size(), 1e-3), weight(x.size());
      model->mass_times(Eigen::VectorXd::Ones(x.size()), weight);
      b += weight;
      system.fold(b);
      for (std::size_t i = 0; i < model->nodes(); ++i)
        if (system.active()[i] == 0) b.segment<3>(3 * i).setZero();
      const Searched plain = search(*model, system, matrix, mass, b, false);
      const Searched smooth = search(*model, system, matrix, mass, b, true);
      EXPECT_LT(smooth.iterations, 0.6 * plain.iterations) << held << mixed;
      EXPECT_LE((smooth.x - plain.x).norm(), 2e-3 * plain.x.norm()) << held << mixed;
    }
}

TEST(ActiveSolve, SmoothStiffnessCostsRigidMotionsAndUniformStrainWhatTheyCost) {
  const TetModelPointer model = tet_bar({4, 2, 2}, {0.4, 0.1, 0.1}, false);
  const SmoothSpace& space = *model->smooth();
  const double scale = 0.2;  // half the longest side: the fields' unit
  const auto mode = [](int field, int axis) {
    return Eigen::VectorXd::Unit(kSmoothModes, 3 * field + axis).eval();
  };
  EXPECT_NEAR(space.mass(0, 0), model->mass(), 1e-9 * model->mass());
  const double size = space.stiffness.norm();
  const Eigen::VectorXd turn = mode(1, 1) - mode(2, 0);  // u = (-y, x, 0)
  EXPECT_LE((space.stiffness * turn).norm(), 1e-6 * size);
  EXPECT_LE((space.stiffness * mode(0, 2)).norm(), 1e-6 * size);
  // A shear of 1/scale: G V / scale^2.
  const double modulus = testing::kTetGel.young / (2.0 * (1.0 + testing::kTetGel.poisson));
  const Eigen::VectorXd shear = mode(2, 0);
  EXPECT_NEAR(shear.dot(space.stiffness * shear), modulus * 0.004 / (scale * scale),
              1e-5 * modulus * 0.004 / (scale * scale));
}

}  // namespace
}  // namespace tremolo
