// Principal stretches of a surface.
#include "runtime/apps/tremolo/output/stretch.h"

#include <gtest/gtest.h>

#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

// Three coordinates that move every vertex by a linear map of its rest position: q0 stretches x, q1
// shears x along y, q2 rotates infinitesimally about z.
Body linear_body() {
  BasisData data = testing::sample_basis(
      testing::random_strain_model(Eigen::Vector3d(10.0, 20.0, 30.0), 0.0, 1));
  for (std::size_t v = 0; v < data.surface.rest.size(); ++v) {
    const Eigen::Vector3d x = data.surface.rest[v];
    auto rows = data.surface.rows.middleRows(3 * v, 3);
    rows.setZero();
    rows(0, 0) = x[0];
    rows(0, 1) = x[1];
    rows(0, 2) = -x[1];
    rows(1, 2) = x[0];
  }
  Result<Model::Pointer> model = Model::from_data(data);
  EXPECT_TRUE(model);
  Result<Body> body = Body::create(*model, "verlet", {});
  EXPECT_TRUE(body);
  return std::move(*body);
}

// The same from the deformation gradient, by brute force over directions in the triangle.
StretchRange brute_force(const Model& model, const Eigen::Matrix3d& gradient) {
  StretchRange range;
  for (const Triangle& t : model.triangles()) {
    const auto& rest = model.surface().rest;
    const auto at = [&](int k) { return rest[t[k]]; };
    const Eigen::Vector3d a = (at(1) - at(0)).normalized();
    const Eigen::Vector3d b = (at(2) - at(0)).cross(a).cross(a).normalized();
    for (int k = 0; k < 20000; ++k) {
      const double angle = M_PI * k / 20000;
      const double stretch = (gradient * (std::cos(angle) * a + std::sin(angle) * b)).norm();
      range.smallest = std::min(range.smallest, stretch);
      range.largest = std::max(range.largest, stretch);
    }
  }
  return range;
}

TEST(SurfaceStretch, IsThatOfTheDeformationGradient) {
  Body body = linear_body();
  SurfaceStretch stretch(body.model());
  for (const Eigen::Vector3d& q : {Eigen::Vector3d(0.5, 0.0, 0.0), Eigen::Vector3d(-0.7, 0.0, 0.0),
                                   Eigen::Vector3d(0.2, -0.9, 0.3)}) {
    ASSERT_TRUE(body.set_state(q, Eigen::Vector3d::Zero()));
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
    gradient(0, 0) += q[0];
    gradient(0, 1) += q[1] - q[2];
    gradient(1, 0) += q[2];
    const StretchRange expected = brute_force(body.model(), gradient);
    const StretchRange measured = stretch.measure(body);
    // The directions are pi/20000 apart: quadratic in that near an extremum.
    EXPECT_NEAR(measured.smallest, expected.smallest, 1e-6);
    EXPECT_NEAR(measured.largest, expected.largest, 1e-6);
  }
}

TEST(SurfaceStretch, IsOneAtRest) {
  Body body = linear_body();
  SurfaceStretch stretch(body.model());
  EXPECT_NEAR(stretch.measure(body).smallest, 1.0, 1e-12);
  EXPECT_NEAR(stretch.measure(body).largest, 1.0, 1e-12);
}

}  // namespace
}  // namespace tremolo
