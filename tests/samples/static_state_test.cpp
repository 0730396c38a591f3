// States at rest of the samples under a growing force.
#include "runtime/response/static_state.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "runtime/model.h"
#include "tests/lab/samples/sample_models.h"

namespace tremolo {
namespace {

using Eigen::VectorXd;

VectorXd weight_of(const Model& model, double gravity) {
  return model.inertia()->linear.topRows(3).transpose() * Eigen::Vector3d(0.0, 0.0, -gravity);
}

Model::Pointer sample(const char* name) {
  return reproduce::load_sample_models(TREMOLO_MODEL_DIR, {name}).front().model;
}

// At 24 m/s^2 the tower would buckle if it were symmetric: as it is, its least stiffness falls to a
// small positive number, with which the rounding of a solve is large, and rises again.
TEST(StaticStateOfSamples, TheTowerLeansPastTheLoadAtWhichAPerfectOneWouldBuckle) {
  const Model::Pointer tower = sample("tower");
  const Potential& potential = tower->potential();
  PotentialWorkspace workspace = potential.make_workspace(kUseTangent);
  Evaluation at = potential.make_evaluation();
  for (const double gravity : {24.0, 24.1, 25.0, 26.0, 28.0, 30.0, 40.0, 100.0}) {
    const VectorXd force = weight_of(*tower, gravity);
    const Result<VectorXd> state = static_state(potential, force);
    ASSERT_TRUE(state) << gravity << ": " << state.error().message;
    potential.evaluate(*state, kWantForce | kWantTangent, workspace, at);
    EXPECT_LT((at.force - force).norm(), 1e-8 * force.norm()) << gravity;
    EXPECT_EQ(at.tangent.llt().info(), Eigen::Success) << gravity;
  }
}

// The horse's first loss of stiffness, whatever multiple of it is asked for.
TEST(StaticStateOfSamples, TheHorseIsRefusedAtItsFirstInstability) {
  const Model::Pointer horse = sample("horse");
  EXPECT_TRUE(static_state(horse->potential(), weight_of(*horse, 80.2)));
  for (const double gravity : {85.0, 100.0, 200.0, 390.0}) {
    const Result<VectorXd> state = static_state(horse->potential(), weight_of(*horse, gravity));
    ASSERT_FALSE(state) << gravity;
    const std::string& message = state.error().message;
    const std::size_t from = message.find("at ");
    ASSERT_NE(from, std::string::npos) << message;
    EXPECT_NEAR(std::stod(message.substr(from + 3)) * gravity, 80.33, 0.02) << message;
  }
}

}  // namespace
}  // namespace tremolo
