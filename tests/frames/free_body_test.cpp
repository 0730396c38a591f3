// Free bodies: conserved quantities, and motions with known solutions.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::frame_model;
using testing::make_framed;
using testing::steps_of;

Pose tilted_pose() {
  return {{0.3, -0.2, 1.0}, Eigen::Quaterniond(0.5, 0.1, -0.7, 0.5).normalized()};
}

// Deformed, vibrating, flying and turning.
ContactBody tumbling_body(const IntegratorOptions& options, std::string_view method = "ep4") {
  ContactBody body =
      make_framed(frame_model(6, true, 12.0, 160.0), FrameKind::kFree, options, method);
  EXPECT_TRUE(body.set_pose(tilted_pose()));
  EXPECT_TRUE(
      body.set_state(testing::random_vector(6, 0.03, 5), testing::random_vector(6, 0.5, 6)));
  EXPECT_TRUE(body.set_motion({1.2, 0.4, -0.7}, {3.0, -5.0, 9.0}));
  return body;
}

// Principal moments of a rigid body about its centre, ascending, and axes.
Eigen::SelfAdjointEigenSolver<Matrix3d> principal_axes(const Model& model) {
  const InertiaIntegrals& I = *model.inertia();
  const Vector3d centre = I.first_moment / I.mass;
  const Matrix3d P = I.second_moment - I.mass * centre * centre.transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(P.trace() * Matrix3d::Identity() - P);
}

// Jacobi's solution: the period of the middle spin. It requires L^2 > 2 T I2.
double flip_period(const Vector3d& moments, const Vector3d& spin) {
  const double I1 = moments[0], I2 = moments[1], I3 = moments[2];
  const double L2 = moments.cwiseProduct(spin).squaredNorm();
  const double T2 = moments.dot(spin.cwiseAbs2());
  EXPECT_GT(L2, T2 * I2);
  const double rate = std::sqrt((I3 - I2) * (L2 - T2 * I1) / (I1 * I2 * I3));
  const double k = std::sqrt((I2 - I1) * (T2 * I3 - L2) / ((I3 - I2) * (L2 - T2 * I1)));
  return 4.0 * std::comp_ellint_1(k) / rate;
}

// The period of a body's middle spin, measured: between two rising passages through zero that lie
// `turns` apart, each found by a straight line.
double measured_period(ContactBody body, const Vector3d& middle, int turns) {
  double first = -1.0, before = middle.dot(body.rigid_state().spin);
  for (int passages = 0; body.time() < 1000.0;) {
    EXPECT_TRUE(body.step().converged);
    const double now = middle.dot(body.rigid_state().spin);
    if (before < 0.0 && now >= 0.0) {
      const double at = body.time() - body.options().step * now / (now - before);
      if (passages++ == 0) first = at;
      if (passages > turns) return (at - first) / turns;
    }
    before = now;
  }
  return 0.0;
}

TEST(FreeBody, EulersTopFlipsInItsPeriodAndTheErrorIsOfSecondOrder) {
  // So stiff that it stretches by 1e-8 only.
  const Model::Pointer model = frame_model(2, true, 4e4, 6e4, 0.0);
  const auto axes = principal_axes(*model);
  const Vector3d turning(0.3, 6.0, 0.9);  // about the principal axes; the middle one is unstable
  const Vector3d spin = axes.eigenvectors() * turning;
  const double exact = flip_period(axes.eigenvalues(), turning);
  std::vector<double> errors;
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    ContactBody body = make_framed(model, FrameKind::kFree, {.step = step});
    ASSERT_TRUE(body.set_motion(Vector3d::Zero(), spin));
    errors.push_back(
        std::abs(measured_period(std::move(body), axes.eigenvectors().col(1), 3) / exact - 1.0));
  }
  std::printf("flip period %.6g s, errors %.2e %.2e %.2e\n", exact, errors[0], errors[1],
              errors[2]);
  EXPECT_LE(errors[2], 1e-4);
  EXPECT_NEAR(errors[0] / errors[1], 4.0, 0.4);
}

TEST(FreeBody, FallsInAParabolaAndKeepsItsShape) {
  const Vector3d gravity(0.3, -0.2, -9.81), velocity(2.0, 1.0, 5.0);
  ContactBody body =
      make_framed(frame_model(6, true, 12.0, 160.0), FrameKind::kFree, {.step = 3e-3});
  ASSERT_TRUE(body.set_pose(tilted_pose()));
  ASSERT_TRUE(body.set_motion(velocity, Vector3d::Zero()));
  ASSERT_TRUE(body.set_gravity(gravity));
  const Vector3d start = body.rigid_state().centre;
  const double energy = body.energy().total();
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(body.step().converged);
    const double t = body.time();
    const Vector3d there = start + t * velocity + 0.5 * t * t * gravity;
    ASSERT_LE((body.rigid_state().centre - there).norm(), 1e-13 * (1.0 + there.norm()));
    ASSERT_LE(body.state().q.norm(), 1e-15);
  }
  EXPECT_TRUE(body.pose().rotation.isApprox(tilted_pose().rotation, 1e-15));
  EXPECT_NEAR(body.energy().total() - energy, body.sums().gravity, 1e-12 * body.energy().total());
}

// A ring of points about the z axis that can breathe: one coordinate, its radius R + q/sqrt(m).
Model::Pointer breathing_ring(double radius, double omega) {
  constexpr int kPoints = 12;
  testing::PointCloud ring;
  ring.basis.resize(3 * kPoints, 1);
  for (int k = 0; k < kPoints; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kPoints;
    const Vector3d outwards(std::cos(angle), std::sin(angle), 0.0);
    ring.masses.push_back(1.0 / kPoints);
    ring.places.push_back(radius * outwards);
    ring.basis.block<3, 1>(3 * k, 0) = outwards;
  }
  const testing::StrainModel strain =
      testing::random_strain_model(VectorXd::Constant(1, omega), 0.0, 1);
  return *Model::from_data(testing::basis_of(ring, strain, true));
}

TEST(FreeBody, SpinningRingStretchesAsItShouldAndStaysSo) {
  constexpr double kRadius = 0.3, kOmega = 40.0, kSpin = 15.0;
  ContactBody body = make_framed(breathing_ring(kRadius, kOmega), FrameKind::kFree, {.step = 3e-3});
  // m spin^2 (R + q) = omega^2 q with m = 1 kg.
  const double stretch = kSpin * kSpin * kRadius / (kOmega * kOmega - kSpin * kSpin);
  ASSERT_TRUE(body.set_state(VectorXd::Constant(1, stretch), VectorXd::Zero(1)));
  ASSERT_TRUE(body.set_motion(Vector3d::Zero(), {0.0, 0.0, kSpin}));
  steps_of(body, 2000);
  EXPECT_NEAR(body.state().q[0], stretch, 1e-12 * stretch);
  EXPECT_NEAR(body.rigid_state().spin.z(), kSpin, 1e-12 * kSpin);
}

TEST(FreeBody, SpinningRingBreathesWithTheStiffnessOfItsAngularMomentum) {
  constexpr double kRadius = 0.3, kOmega = 40.0, kSpin = 15.0;
  ContactBody body = make_framed(breathing_ring(kRadius, kOmega), FrameKind::kFree, {.step = 5e-4});
  const double stretch = kSpin * kSpin * kRadius / (kOmega * kOmega - kSpin * kSpin);
  ASSERT_TRUE(body.set_state(VectorXd::Constant(1, stretch), VectorXd::Constant(1, 1e-5)));
  ASSERT_TRUE(body.set_motion(Vector3d::Zero(), {0.0, 0.0, kSpin}));
  // V + L^2/(2 m rho^2) has the second derivative omega^2 + 3 spin^2.
  const double period = 2.0 * std::numbers::pi / std::sqrt(kOmega * kOmega + 3.0 * kSpin * kSpin);
  double last = 0.0, before = 1.0;
  int passages = 0;
  while (passages < 20) {
    ASSERT_TRUE(body.step().converged);
    const double p = body.state().p[0];
    if (before < 0.0 && p >= 0.0) {
      ++passages;
      last = body.time() - body.options().step * p / (p - before);
    }
    before = p;
  }
  EXPECT_NEAR(last / (passages - 0.25) / period, 1.0, 2e-4);
}

TEST(FreeBody, DampingTakesEnergyAndNoMomentum) {
  for (const char* method : {"avf", "ep2", "ep4"}) {
    ContactBody body =
        tumbling_body({.step = 3e-3, .alpha = 0.4, .beta = 2e-3, .tolerance = 1e-10}, method);
    const Vector3d linear = body.momentum().linear, angular = body.momentum().angular;
    const double start = body.energy().total();
    double last = start;
    for (int k = 0; k < 2000; ++k) {
      ASSERT_TRUE(body.step().converged);
      const double now = body.energy().total();
      ASSERT_LE(now, last * (1.0 + 1e-13)) << method << k;
      last = now;
    }
    EXPECT_LE((body.momentum().linear - linear).norm(), 1e-13 * linear.norm()) << method;
    EXPECT_LE((body.momentum().angular - angular).norm(), 1e-12 * angular.norm()) << method;
    EXPECT_LT(last, 0.99 * start) << method;
    EXPECT_NEAR(start - last, body.sums().dissipated, 1e-11 * start) << method;
  }
}

TEST(FreeBody, GoesBackTheWayItCame) {
  for (const char* method : {"avf", "ep2", "ep4"}) {
    ContactBody body =
        tumbling_body({.step = 3e-3, .tolerance = 1e-13, .max_iterations = 60}, method);
    const State start = body.state();
    const RigidState rigid = body.rigid_state();
    steps_of(body, 300);
    EXPECT_GT((body.state().q - start.q).norm(), 0.1 * start.q.norm());
    ASSERT_TRUE(body.set_state(body.state().q, -body.state().p));
    ASSERT_TRUE(body.set_motion(-body.rigid_state().velocity, -body.rigid_state().spin));
    steps_of(body, 300);
    EXPECT_LE((body.state().q - start.q).norm(), 1e-8 * start.q.norm()) << method;
    EXPECT_LE((body.rigid_state().centre - rigid.centre).norm(), 1e-12) << method;
    EXPECT_LE(body.rigid_state().rotation.angularDistance(rigid.rotation), 1e-8) << method;
    EXPECT_LE((body.rigid_state().spin + rigid.spin).norm(), 1e-8 * rigid.spin.norm()) << method;
  }
}

TEST(FreeBody, KeepsMomentaAndEnergyOverALongFlight) {
#ifdef TREMOLO_LONG_TESTS
  constexpr int kSteps = 1000000;
#else
  constexpr int kSteps = 100000;
#endif
  ContactBody body = tumbling_body({.step = 3e-3});
  const Vector3d linear = body.momentum().linear, angular = body.momentum().angular;
  const double energy = body.energy().total();
  double turned = 0.0, drifted = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    ASSERT_TRUE(body.step().converged);
    turned = std::max(turned, (body.momentum().angular - angular).norm() / angular.norm());
    drifted = std::max(drifted, std::abs(body.energy().total() / energy - 1.0));
  }
  std::printf("%d steps: angular momentum %.1e, energy %.1e\n", kSteps, turned, drifted);
  EXPECT_EQ(body.momentum().linear, linear);
  EXPECT_LE(turned, 1e-12);
  EXPECT_LE(drifted, 1e-9);
}

// Newton's laws of the cloud's points, for all virtual motions (c, a rotation in the body's axes,
// q), by the classical method of Runge and Kutta: has no code in common with the tested method.
struct CloudState {
  Vector3d centre, velocity, spin;
  Eigen::Quaterniond turn;
  VectorXd q, v;
};

CloudState cloud_slope(const testing::PointCloud& cloud, const testing::StrainModel& strain,
                       const Vector3d& middle, const CloudState& s) {
  const Eigen::Index r = s.q.size();
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(6 + r, 6 + r);
  VectorXd right = VectorXd::Zero(6 + r);
  for (std::size_t k = 0; k < cloud.masses.size(); ++k) {
    const Eigen::MatrixXd phi = cloud.basis.middleRows(3 * static_cast<Eigen::Index>(k), 3);
    const Vector3d y = cloud.places[k] - middle + phi * s.q, u = phi * s.v;
    Eigen::MatrixXd columns(3, 6 + r);  // of the point's acceleration, body axes
    columns << Matrix3d::Identity(), -cross_matrix(y), phi;
    const Vector3d rest = s.spin.cross(s.spin.cross(y)) + 2.0 * s.spin.cross(u);
    mass += cloud.masses[k] * columns.transpose() * columns;
    right -= cloud.masses[k] * columns.transpose() * rest;
  }
  right.tail(r) -= testing::strain_force(strain, s.q);
  const VectorXd rates = mass.ldlt().solve(right);
  Eigen::Quaterniond turning =
      s.turn * Eigen::Quaterniond(0.0, 0.5 * s.spin.x(), 0.5 * s.spin.y(), 0.5 * s.spin.z());
  return {s.velocity,   s.turn * Vector3d(rates.head<3>()), rates.segment<3>(3), turning, s.v,
          rates.tail(r)};
}

CloudState cloud_moved(const CloudState& s, const CloudState& d, double h) {
  CloudState to = s;
  to.centre += h * d.centre;
  to.velocity += h * d.velocity;
  to.spin += h * d.spin;
  to.turn.coeffs() += h * d.turn.coeffs();
  to.q += h * d.q;
  to.v += h * d.v;
  return to;
}

TEST(FreeBody, FollowsNewtonsLawsOfItsPointsInSecondOrder) {
  constexpr double kTime = 0.24;
  const testing::StrainModel strain =
      testing::random_strain_model(testing::spread_omega(4, 12.0, 60.0), 0.2, 3);
  const testing::PointCloud cloud = testing::random_cloud(4, true, 3);
  const Model::Pointer model = *Model::from_data(testing::basis_of(cloud, strain, true));
  const Vector3d middle = model->inertia()->first_moment / model->inertia()->mass;
  CloudState exact{middle,
                   {1.0, 0.0, 0.5},
                   {3.0, -5.0, 9.0},
                   Eigen::Quaterniond::Identity(),
                   testing::random_vector(4, 0.03, 5),
                   testing::random_vector(4, 0.5, 6)};
  const CloudState start = exact;
  constexpr int kFine = 4000;
  for (int k = 0; k < kFine; ++k) {
    const double h = kTime / kFine;
    const CloudState k1 = cloud_slope(cloud, strain, middle, exact);
    const CloudState k2 = cloud_slope(cloud, strain, middle, cloud_moved(exact, k1, 0.5 * h));
    const CloudState k3 = cloud_slope(cloud, strain, middle, cloud_moved(exact, k2, 0.5 * h));
    const CloudState k4 = cloud_slope(cloud, strain, middle, cloud_moved(exact, k3, h));
    for (const auto& [slope, share] :
         {std::pair(&k1, 1.0), std::pair(&k2, 2.0), std::pair(&k3, 2.0), std::pair(&k4, 1.0)})
      exact = cloud_moved(exact, *slope, share * h / 6.0);
    exact.turn.normalize();
  }
  for (const char* method : {"avf", "ep2", "ep4"}) {
    std::vector<double> errors;
    for (const int steps : {120, 240, 480}) {
      ContactBody body =
          make_framed(model, FrameKind::kFree,
                      {.step = kTime / steps, .tolerance = 1e-12, .max_iterations = 60}, method);
      ASSERT_TRUE(body.set_state(start.q, start.v));
      ASSERT_TRUE(body.set_motion(start.velocity, start.spin));
      steps_of(body, steps);
      errors.push_back((body.state().q - exact.q).norm() / exact.q.norm() +
                       body.rigid_state().rotation.angularDistance(exact.turn));
      EXPECT_LE((body.rigid_state().centre - exact.centre).norm(), 1e-12);
    }
    std::printf("%s: errors %.2e %.2e %.2e\n", method, errors[0], errors[1], errors[2]);
    EXPECT_LE(errors[2], 2e-3) << method;
    EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2.0, 0.25) << method;
  }
}

TEST(FreeBody, ForcesMoveAndSpinItByTheirImpulse) {
  ContactBody body = tumbling_body({.step = 3e-3});
  const Vector3d force(2.0, -1.0, 3.0), linear = body.momentum().linear;
  const double energy = body.energy().total();
  ASSERT_TRUE(body.apply_force(5, force, 40));
  ASSERT_TRUE(body.add_default_load({.kind = SignalKind::kSquare}));
  ASSERT_TRUE(body.set_gravity({0.0, 0.0, -9.81}));
  steps_of(body, 200);  // 0.6 s; the load's square lasts 0.3 s
  const DefaultLoad& load = body.model().default_load();
  const Vector3d weight(0.0, 0.0, -9.81 * body.model().inertia()->mass);
  const Vector3d impulse = 0.12 * force + 0.3 * load.forces[0] + 0.6 * weight;
  EXPECT_LE((body.momentum().linear - linear - impulse).norm(), 1e-12 * impulse.norm());
  const double change = body.energy().total() - energy;
  EXPECT_NEAR(change, body.sums().work, 1e-12 * body.energy().total());
}

TEST(FreeBody, StepThatFailsLeavesEverythingAsItWas) {
  ContactBody body = tumbling_body({.step = 3e-3});
  steps_of(body, 3);
  const State before = body.state();
  const RigidState rigid = body.rigid_state();
  const double work = body.sums().work;
  ASSERT_TRUE(body.apply_force(5, {1e150, 0.0, 0.0}));
  EXPECT_FALSE(body.step().converged);
  EXPECT_EQ(body.state().q, before.q);
  EXPECT_EQ(body.state().p, before.p);
  EXPECT_EQ(body.rigid_state().centre, rigid.centre);
  EXPECT_EQ(body.rigid_state().spin, rigid.spin);
  EXPECT_EQ(body.rigid_state().momentum, rigid.momentum);
  EXPECT_EQ(body.rigid_state().rotation.coeffs(), rigid.rotation.coeffs());
  EXPECT_EQ(body.sums().work, work);
  EXPECT_EQ(body.counts().steps, 3);
  body.clear_forces();
  EXPECT_TRUE(body.step().converged);
}

TEST(FreeBody, RefusesWhatItCannotBe) {
  const auto refused = [](const Model::Pointer& model, const char* method) {
    const Result<ContactBody> body = ContactBody::create(model, method, {}, FrameKind::kFree);
    EXPECT_FALSE(body) << method;
    return body ? std::string() : body.error().message;
  };
  const Model::Pointer free = frame_model(3, true, 12.0, 160.0);
  for (const std::string_view name : integrator_names()) {
    if (name == "avf" || name == "ep2" || name == "ep4") continue;
    EXPECT_NE(refused(free, std::string(name).c_str()).find("avf, ep2, ep4"), std::string::npos);
  }
  const std::string held = refused(frame_model(3, false, 12.0, 160.0), "ep4");
  EXPECT_NE(held.find("--fix none"), std::string::npos) << held;
  const testing::StrainModel strain =
      testing::random_strain_model(testing::spread_omega(3, 12.0, 90.0), 0.1, 1);
  BasisData old = testing::basis_of(testing::random_cloud(3, true, 3), strain, true);
  old.inertia.reset();
  const std::string without = refused(*Model::from_data(old), "ep4");
  EXPECT_NE(without.find("inertia integrals"), std::string::npos) << without;
  ContactBody body = make_framed(free, FrameKind::kFree, {});
  EXPECT_FALSE(body.set_pose({Vector3d::Zero(), Eigen::Quaterniond(1.0, 0.1, 0.0, 0.0)}));
  EXPECT_FALSE(body.set_pose({Vector3d(NAN, 0.0, 0.0), Eigen::Quaterniond::Identity()}));
  EXPECT_FALSE(body.set_motion({NAN, 0.0, 0.0}, Vector3d::Zero()));
  EXPECT_FALSE(body.move_to({}));
  EXPECT_FALSE(body.add_load({Signal{.kind = SignalKind::kSquare}, VectorXd::Zero(3)}));
}

// Damping by strain rates takes nothing from the whole rotation: the angular momentum stays, and
// the energy falls to its least value, steady spin about the axis of largest inertia.
TEST(FreeBody, ADampedSpinEndsAboutTheAxisOfLargestInertia) {
  const Model::Pointer model = testing::frame_model(6, true, 30.0, 400.0, 0.2);
  const InertiaIntegrals& inertia = *model->inertia();
  const Vector3d centre = inertia.first_moment / inertia.mass;
  const Eigen::Matrix3d P = inertia.second_moment - inertia.mass * centre * centre.transpose();
  const Eigen::Matrix3d J = P.trace() * Eigen::Matrix3d::Identity() - P;
  const Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(J).eigenvalues();
  for (const char* method : {"avf", "ep2", "ep4"}) {
    ContactBody body =
        testing::make_framed(model, FrameKind::kFree, {.step = 2e-3, .beta = 5e-2}, method);
    ASSERT_TRUE(body.set_motion(Vector3d::Zero(), 15.0 * Vector3d(1.0, 0.5, -0.7)));
    const Vector3d before = body.momentum().angular;
    const double start = body.energy().total();
    double last = start;
    for (int k = 0; k < 15000; ++k) {
      ASSERT_TRUE(body.step().converged);
      const double now = body.energy().total();
      ASSERT_LE(now, last * (1.0 + 1e-12)) << method << ", " << k;
      last = now;
    }
    EXPECT_LE((body.momentum().angular - before).norm(), 1e-12 * before.norm()) << method;
    EXPECT_NEAR(last + body.sums().dissipated, start, 1e-11 * start) << method;
    const Vector3d spin = body.rigid_state().spin;
    const Vector3d momentum = body.pose().rotation.conjugate() * body.momentum().angular;
    // After 30 s the wobble has shrunk to a hundredth; its energy is of second order.
    EXPECT_LE(spin.cross(momentum).norm(), 0.03 * spin.norm() * momentum.norm()) << method;
    EXPECT_LT(last, before.squaredNorm() / (2.0 * moments[1])) << method;
  }
}

}  // namespace
}  // namespace tremolo
