// Bodies that nothing holds: what a free body keeps, and motions that are known.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::frame_model;
using testing::make_framed;
using testing::steps_of;

Model::Pointer soft_model() {
  return frame_model(6, true, 12.0, 160.0);
}

// Deformed, vibrating, flying and turning.
Body tumbling_body(const IntegratorOptions& options, std::string_view method = "ep4") {
  Body body = make_framed(soft_model(), FrameKind::kFree, options, method);
  EXPECT_TRUE(body.set_pose({{0.3, -0.2, 1.0}, testing_turn()}));
  EXPECT_TRUE(body.set_state(testing::random_vector(6, 0.03, 5), testing::random_vector(6, 0.5, 6)));
  EXPECT_TRUE(body.set_motion({1.2, 0.4, -0.7}, {3.0, -5.0, 9.0}));
  return body;
}

// Jacobi's top. moments: principal, ascending. spin: about them. Returns the time between two
// passages of the middle spin through zero in the same direction, and asks for L^2 > 2 T I2.
double flip_period(const Vector3d& moments, const Vector3d& spin) {
  const double I1 = moments[0], I2 = moments[1], I3 = moments[2];
  const double L2 = moments.cwiseProduct(spin).squaredNorm();
  const double T2 = moments.dot(spin.cwiseAbs2());
  EXPECT_GT(L2, T2 * I2);
  const double rate = std::sqrt((I3 - I2) * (L2 - T2 * I1) / (I1 * I2 * I3));
  const double k = std::sqrt((I2 - I1) * (T2 * I3 - L2) / ((I3 - I2) * (L2 - T2 * I1)));
  return 4.0 * std::comp_ellint_1(k) / rate;
}

}  // namespace
}  // namespace tremolo
