// The forces of a cloth, their slopes and their work.
#include <cmath>
#include <numeric>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

SceneCloth damped_sheet(std::size_t columns, std::size_t rows) {
  SceneCloth cloth = testing::sample_sheet(columns, rows);
  cloth.structural.damping = 0.3;
  cloth.shear.damping = 0.2;
  cloth.bend.damping = 0.05;
  return cloth;
}

VectorXd cloth_force(const ClothModel& model, const VectorXd& x, const VectorXd& v,
                     ForcePart part = ForcePart::kAll) {
  VectorXd f(x.size());
  model.force(x, v, part, f);
  return f;
}

Eigen::MatrixXd dense_cloth_matrix(const BlockMatrix& a) {
  const Eigen::Index n = 3 * a.pattern().size();
  Eigen::MatrixXd dense(n, n);
  VectorXd y(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    a.multiply(VectorXd::Unit(n, k), y);
    dense.col(k) = y;
  }
  return dense;
}

TEST(ClothModel, ForceIsTheGradientOfThePotential) {
  ClothModel model = testing::sample_model(testing::sample_sheet(7, 5));
  model.set_gravity({0.3, -0.2, -9.81});
  const VectorXd x = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.08, 1);
  const VectorXd v = VectorXd::Zero(x.size());
  const VectorXd f = cloth_force(model, x, v);
  // Central differences: their error is h^2, and rounding's eps V/h, of forces of some 10 N.
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const VectorXd way = kStep * VectorXd::Unit(x.size(), i);
    const double slope = (model.potential(x - way) - model.potential(x + way)) / (2.0 * kStep);
    EXPECT_NEAR(f[i], slope, 1e-7) << i;
  }
}

TEST(ClothModel, InternalForcesHaveNeitherMomentumNorTorqueEvenDampedAndCrumpled) {
  for (const std::size_t columns : {5U, 16U, 80U}) {
    ClothModel model = testing::sample_model(damped_sheet(columns, 12));
    const VectorXd x = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.1, 2);
    const VectorXd v = testing::random_numbers(x.size(), 3.0, 3);
    const VectorXd f = cloth_force(model, x, v);
    Vector3d sum = Vector3d::Zero(), torque = Vector3d::Zero();
    double size = 0.0;
    for (Eigen::Index i = 0; i < f.size(); i += 3) {
      sum += f.segment<3>(i);
      torque += x.segment<3>(i).cross(f.segment<3>(i));
      size += f.segment<3>(i).norm();
    }
    EXPECT_LE(sum.norm(), 1e-14 * size);
    EXPECT_LE(torque.norm(), 1e-14 * size);
  }
}

TEST(ClothModel, RunsOfSpringsPullAsSpringsOneByOne) {
  const ClothModel model = testing::sample_model(damped_sheet(80, 12));
  const ClothParts& parts = model.parts();
  const VectorXd x = parts.x + testing::random_numbers(parts.x.size(), 0.1, 2);
  const VectorXd v = testing::random_numbers(x.size(), 3.0, 3);
  VectorXd f = VectorXd::Zero(x.size());
  for (const ClothSprings* springs : {&parts.structural, &parts.shear, &parts.bend})
    for (std::size_t i = 0; i < springs->pairs.size(); ++i) {
      const auto [a, b] = springs->pairs[i];
      const Vector3d r = x.segment<3>(3 * a) - x.segment<3>(3 * b);
      const Vector3d e = r.normalized();
      const double pull = springs->law.stiffness * (r.norm() - springs->rest[i]) +
                          springs->law.damping * e.dot(v.segment<3>(3 * a) - v.segment<3>(3 * b));
      f.segment<3>(3 * a) -= pull * e;
      f.segment<3>(3 * b) += pull * e;
    }
  EXPECT_LE((cloth_force(model, x, v) - f).norm(), 1e-13 * f.norm());
}

// Stretched springs, and velocities along them that stretch them further: nothing is left out.
TEST(ClothModel, TangentsAreTheForcesSlopesWhereNothingIsLeftOut) {
  ClothParts parts = testing::sample_chain(5, {0.1, 0.05, 0.02}, 0.1, 0.01, {300.0, 0.7});
  Result<ClothModel> model = ClothModel::create(parts);
  ASSERT_TRUE(model);
  const VectorXd x = parts.x, v = 2.0 * x;
  BlockMatrix position(model->pattern()), velocity(model->pattern());
  model->add_tangent(x, v, ForcePart::kAll, 1.0, 0.0, 0.0, position);
  model->add_tangent(x, v, ForcePart::kAll, 0.0, 1.0, 0.0, velocity);
  const Eigen::MatrixXd k = dense_cloth_matrix(position), d = dense_cloth_matrix(velocity);
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const VectorXd way = kStep * VectorXd::Unit(x.size(), i);
    const VectorXd by_x =
        (cloth_force(*model, x - way, v) - cloth_force(*model, x + way, v)) / (2.0 * kStep);
    const VectorXd by_v =
        (cloth_force(*model, x, v - way) - cloth_force(*model, x, v + way)) / (2.0 * kStep);
    // Differences of forces of 1 N to 1e-16, over 1e-6.
    EXPECT_LE((k.col(i) - by_x).norm(), 1e-8 * k.norm()) << i;
    EXPECT_LE((d.col(i) - by_v).norm(), 1e-8 * d.norm()) << i;
  }
}

// The full tangents and the products of the missing terms, under compression and with velocities
// across the springs.
TEST(ClothModel, FullTangentsWithTheMissingTermsAreTheSlopesOfTheForces) {
  constexpr double kStep = 1e-6, kTime = 0.01;
  ClothModel model = testing::sample_model(damped_sheet(5, 4));
  const VectorXd x0 = model.parts().x;
  const VectorXd x = 0.8 * x0 + testing::random_numbers(x0.size(), 0.02, 4);
  const VectorXd v = testing::random_numbers(x.size(), 2.0, 5);
  BlockMatrix still(model.pattern()), over_step(model.pattern());
  model.add_tangent(x, v, ForcePart::kAll, 1.0, 0.0, 1.0, still);
  model.add_step_tangent(x0, x, kTime, 1.0, over_step);
  const auto step_force = [&](const VectorXd& x1) {
    VectorXd f(x1.size());
    model.step_force(x0, x1, kTime, f);
    return f;
  };
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const VectorXd unit = VectorXd::Unit(x.size(), i), way = kStep * unit;
    VectorXd product(x.size());
    still.multiply(unit, product);
    model.add_missing_product(x, v, 1.0, unit, product);
    const VectorXd slope =
        (cloth_force(model, x - way, v) - cloth_force(model, x + way, v)) / (2.0 * kStep);
    // Differences of forces to 1e-15 of themselves, over 1e-6, and their third derivatives.
    EXPECT_LE((product - slope).norm(), 1e-7 * slope.norm()) << i;
    over_step.multiply(unit, product);
    model.add_missing_step_product(x0, x, kTime, unit, product);
    const VectorXd step_slope = (step_force(x - way) - step_force(x + way)) / (2.0 * kStep);
    EXPECT_LE((product - step_slope).norm(), 1e-7 * step_slope.norm()) << i;
  }
}

TEST(ClothModel, WindsTangentIsItsSlopeByVelocity) {
  SceneCloth cloth = testing::sample_sheet(4, 3);
  cloth.drag = 1.3;
  cloth.structural = cloth.shear = cloth.bend = {0.0, 0.0};
  ClothModel model = testing::sample_model(cloth);
  model.set_wind({1.0, 4.0, -3.0});
  const VectorXd x = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.1, 4);
  const VectorXd v = testing::random_numbers(x.size(), 1.0, 5);
  BlockMatrix velocity(model.pattern());
  model.add_tangent(x, v, ForcePart::kAll, 0.0, 1.0, 0.0, velocity);
  const Eigen::MatrixXd d = dense_cloth_matrix(velocity);
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const VectorXd way = kStep * VectorXd::Unit(x.size(), i);
    const VectorXd by_v =
        (cloth_force(model, x, v - way) - cloth_force(model, x, v + way)) / (2.0 * kStep);
    EXPECT_LE((d.col(i) - by_v).norm(), 1e-7 * d.norm()) << i;
  }
}

TEST(ClothModel, WindOnAFlatSheetIsHalfDragAreaSpeedSquared) {
  SceneCloth cloth = testing::sample_sheet(6, 9);
  cloth.grid.width = 0.7;
  cloth.grid.height = 1.5;
  cloth.drag = 1.2;
  ClothModel model = testing::sample_model(cloth);
  model.set_wind({3.0, 1.0, 5.0});
  const VectorXd f = cloth_force(model, model.parts().x, VectorXd::Zero(model.parts().x.size()));
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < f.size(); i += 3) sum += f.segment<3>(i);
  // 1/2 rho A w_n^2 along the normal; rounding of a hundred terms.
  EXPECT_LE((sum - Vector3d(0.0, 0.0, 0.5 * 1.2 * 0.7 * 1.5 * 25.0)).norm(), 1e-13);
}

TEST(ClothModel, TangentsAreSymmetricAndPositiveEvenUnderCompression) {
  SceneCloth cloth = damped_sheet(5, 4);
  cloth.drag = 1.2;
  ClothModel model = testing::sample_model(cloth);
  model.set_wind({2.0, 1.0, 7.0});
  const VectorXd x =
      0.5 * model.parts().x + testing::random_numbers(model.parts().x.size(), 0.05, 6);
  const VectorXd v = testing::random_numbers(x.size(), 5.0, 7);
  BlockMatrix a(model.pattern()), b(model.pattern());
  model.add_tangent(x, v, ForcePart::kAll, 1.0, 0.01, 0.0, a);
  model.add_step_tangent(model.parts().x, x, 0.01, 0.0, b);
  for (const BlockMatrix* matrix : {&a, &b}) {
    const Eigen::MatrixXd dense = dense_cloth_matrix(*matrix);
    EXPECT_LE((dense - dense.transpose()).norm(), 1e-14 * dense.norm());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense);
    EXPECT_GE(eigen.eigenvalues().minCoeff(), -1e-12 * eigen.eigenvalues().maxCoeff());
  }
}

TEST(ClothModel, StepForceBalancesEnergyMomentumAndAngularMomentum) {
  SceneCloth cloth = damped_sheet(9, 20);
  cloth.drag = 1.2;
  ClothModel model = testing::sample_model(cloth);
  model.set_gravity({0.0, 1.0, -9.81});
  model.set_wind({2.0, 1.0, 7.0});
  constexpr double kStep = 0.02;
  const VectorXd x0 = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.05, 8);
  const VectorXd x1 = x0 + testing::random_numbers(x0.size(), 0.1, 9);
  VectorXd f(x0.size());
  const StepWork work = model.step_force(x0, x1, kStep, f);
  const double change = model.potential(x1) - model.potential(x0);
  EXPECT_NEAR(f.dot(x1 - x0), -change - work.damped + work.driven,
              1e-13 * (std::abs(change) + work.damped + std::abs(work.driven)));
  EXPECT_GT(work.damped, 0.0);

  model.set_gravity(Vector3d::Zero());
  cloth.drag = 0.0;
  const ClothModel still = testing::sample_model(cloth);
  still.step_force(x0, x1, kStep, f);
  Vector3d sum = Vector3d::Zero(), torque = Vector3d::Zero();
  double size = 0.0;
  for (Eigen::Index i = 0; i < f.size(); i += 3) {
    sum += f.segment<3>(i);
    torque += 0.5 * (x0 + x1).segment<3>(i).cross(f.segment<3>(i));
    size += f.segment<3>(i).norm();
  }
  EXPECT_LE(sum.norm(), 1e-14 * size);
  EXPECT_LE(torque.norm(), 1e-14 * size);
}

TEST(ClothModel, StepForceOfNoWayIsTheForceAtRest) {
  const ClothModel model = testing::sample_model(testing::sample_sheet(6, 6));
  const VectorXd x = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.05, 8);
  VectorXd f(x.size());
  model.step_force(x, x, 0.01, f);
  EXPECT_LE((f - cloth_force(model, x, VectorXd::Zero(x.size()))).norm(), 1e-14 * f.norm());
}

TEST(ClothModel, PowerIsWhatForcesWithoutPotentialDo) {
  SceneCloth cloth = damped_sheet(8, 8);
  cloth.drag = 1.2;
  ClothModel model = testing::sample_model(cloth);
  model.set_wind({2.0, 1.0, 7.0});
  const VectorXd x = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.05, 8);
  const VectorXd v = testing::random_numbers(x.size(), 2.0, 9);
  const double power = v.dot(cloth_force(model, x, v)) - v.dot([&] {
    SceneCloth free = testing::sample_sheet(8, 8);
    return cloth_force(testing::sample_model(free), x, v);
  }());
  const StepWork work = model.power(x, v);
  EXPECT_NEAR(power, work.driven - work.damped, 1e-12 * (work.damped + std::abs(work.driven)));
}

TEST(ClothModel, PartsOfTheForceMakeUpTheWhole) {
  SceneCloth cloth = damped_sheet(8, 8);
  cloth.drag = 1.2;
  ClothModel model = testing::sample_model(cloth);
  model.set_gravity({0.0, 0.0, -9.81});
  const VectorXd x = model.parts().x + testing::random_numbers(model.parts().x.size(), 0.05, 8);
  const VectorXd v = testing::random_numbers(x.size(), 2.0, 9);
  const VectorXd all = cloth_force(model, x, v);
  const VectorXd sum =
      cloth_force(model, x, v, ForcePart::kStiff) + cloth_force(model, x, v, ForcePart::kSoft);
  EXPECT_LE((all - sum).norm(), 8 * kEpsilon * all.norm());
}

TEST(ClothModel, SpringsWithoutALengthAtTheMomentPullNowhereAndGiveNumbers) {
  ClothParts parts = testing::sample_chain(2, {0.1, 0.0, 0.0}, 0.1, 0.01, {300.0, 0.7});
  const Result<ClothModel> model = ClothModel::create(parts);
  ASSERT_TRUE(model);
  const VectorXd x = VectorXd::Zero(9), v = testing::random_numbers(9, 1.0, 1);
  VectorXd f(9);
  model->force(x, v, ForcePart::kAll, f);
  EXPECT_TRUE(f.isZero(0.0));
  model->step_force(x, x, 0.1, f);
  EXPECT_TRUE(f.isZero(0.0));
  BlockMatrix a(model->pattern());
  model->add_tangent(x, v, ForcePart::kAll, 1.0, 1.0, 0.0, a);
  model->add_step_tangent(x, x, 0.1, 0.0, a);
  EXPECT_TRUE(dense_cloth_matrix(a).allFinite());
}

TEST(ClothModel, AGridWeighsWhatItsAreaDoes) {
  SceneCloth cloth = testing::sample_sheet(13, 9);
  cloth.grid.width = 2.0;
  cloth.grid.height = 1.5;
  const ClothModel model = testing::sample_model(cloth);
  EXPECT_NEAR(model.mass().sum(), 0.2 * 3.0, 1e-15);
  EXPECT_EQ(model.structural().size(), 12U * 9 + 13 * 8);
  EXPECT_EQ(model.shear().size(), 2U * 12 * 8);
  EXPECT_EQ(model.bend().size(), 11U * 9 + 13 * 7);
  EXPECT_EQ(model.parts().triangles.size(), 2U * 12 * 8);
}

TEST(ClothModel, AHoldGoesStraightThroughAStep) {
  ClothModel model = testing::sample_model(testing::sample_sheet(4, 4));
  VectorXd x = model.parts().x;
  const Vector3d begun = x.segment<3>(15), goal = begun + Vector3d(0.1, -0.2, 0.3);
  model.hold(5, goal);
  const auto at = [&model](double time) {
    VectorXd y = model.parts().x;
    model.put_held(time, y);
    return Vector3d(y.segment<3>(15));
  };
  EXPECT_EQ(at(0.0), goal);
  model.begin_holds(2.0, 0.5, x);
  EXPECT_EQ(at(2.0), begun);
  EXPECT_LE((at(2.125) - (0.75 * begun + 0.25 * goal)).norm(), 1e-15);
  EXPECT_EQ(at(2.5), goal);
  EXPECT_EQ(at(2.5 - 1e-12), goal);
}

}  // namespace
}  // namespace tremolo
