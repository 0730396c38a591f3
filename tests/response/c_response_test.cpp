// Periodic motion through the C interface; the parts in C are in c_response_test.c.
#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "common/damping_ratios.h"
#include "formats/basis/basis_writer.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/body.h"
#include "runtime/load.h"
#include "runtime/model.h"
#include "runtime/response/probe.h"
#include "runtime/response/response.h"
#include "runtime/tremolo.h"
#include "tests/response/oscillators.h"
#include "tests/support/sample_basis.h"

extern "C" int tremolo_c_backbone_round(const tremolo_model* model, double omega, double gamma);
extern "C" int tremolo_c_response_refusals(const tremolo_model* model);
extern "C" int tremolo_c_load_refusals(const tremolo_model* model);

namespace tremolo {
namespace {

// One coordinate with V = omega^2 q^2/2 + gamma q^4/4.
BasisData duffing_basis(double omega, double gamma) {
  const testing::StrainModel linear{Eigen::VectorXd::Constant(1, omega),
                                    {Eigen::MatrixXd::Zero(1, 1)}};
  BasisData data = testing::sample_basis(linear);
  data.cubic = {0.0};
  data.quartic = {0.25 * gamma};
  data.strain_gram.clear();
  return data;
}

class CCurve : public ::testing::Test {
 protected:
  void load(const BasisData& data) {
    const std::vector<std::byte> bytes = *encode_basis(data);
    ASSERT_EQ(tremolo_model_load_memory(bytes.data(), bytes.size(), 0, &model_), TREMOLO_OK)
        << tremolo_last_error();
  }
  void TearDown() override {
    tremolo_curve_destroy(curve_);
    tremolo_model_release(model_);
  }
  tremolo_model* model_ = nullptr;
  tremolo_curve* curve_ = nullptr;
};

TEST_F(CCurve, ABackboneOfOneCoordinateIsThatOfTheEllipticIntegral) {
  load(duffing_basis(2.0, 3.0));
  EXPECT_EQ(tremolo_c_backbone_round(model_, 2.0, 3.0), 0)
      << "line of c_response_test.c; " << tremolo_last_error();
}

TEST_F(CCurve, WrongInputIsRefusedWithTheReason) {
  load(duffing_basis(2.0, 3.0));
  EXPECT_EQ(tremolo_c_response_refusals(model_), 0)
      << "line of c_response_test.c; " << tremolo_last_error();
  EXPECT_EQ(tremolo_c_load_refusals(model_), 0)
      << "line of c_response_test.c; " << tremolo_last_error();
}

TEST_F(CCurve, AResponseIsThatOfTheEngineWithItsFolds) {
  const BasisData data = duffing_basis(2.0, 3.0);
  load(data);
  const Model::Pointer model = *Model::from_data(data);
  // At resonance the amplitude is force/(2 zeta omega^2) = 0.5: hardening by 3/8 gamma A^2/omega^2.
  const Eigen::VectorXd unit = *reduce_force(*model, 3, {0.0, 0.0, 1.0});
  const double force = 2.0 * 0.02 * 4.0 * 0.5 / std::abs(unit[0]);
  const std::uint32_t vertex = 3;
  const double forces[3] = {0.0, 0.0, force};
  tremolo_curve_options options;
  tremolo_curve_options_init(&options);
  options.damping_ratio = "2%";
  options.load_vertices = &vertex;
  options.load_forces = forces;
  options.load_count = 1;
  options.largest_amplitude = 1e3;
  ASSERT_EQ(tremolo_response(model_, &options, 0.2, 0.6, &curve_), TREMOLO_OK)
      << tremolo_last_error();

  const VibratingSystem system =
      *vibrating_system(*model, 0.0, 0.0, Eigen::VectorXd::Constant(1, 2.0 * 0.02 * 2.0));
  ResponseRequest request{FourierSeries::Zero(1, 3), 2.0 * std::numbers::pi * 0.2,
                          2.0 * std::numbers::pi * 0.6};
  request.force(0, 2) = force * unit[0];
  CurveOptions engine;
  engine.largest_amplitude = 1e3;
  engine.amplitude = amplitude_of(*moving_most(*model, model->surface().vertex_ids, 0));
  const MotionCurve curve = *response_curve(system, request, engine);
  ASSERT_EQ(tremolo_curve_points(curve_), curve.points.size());
  bool stable = false, unstable = false;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    tremolo_curve_point point;
    ASSERT_EQ(tremolo_curve_point_at(curve_, i, &point), TREMOLO_OK);
    // The damping of "2%" is computed in another order: differences of rounding.
    EXPECT_NEAR(point.frequency_hz, curve.points[i].omega / (2.0 * std::numbers::pi), 1e-9);
    EXPECT_NEAR(point.amplitude, curve.points[i].amplitude, 1e-9);
    EXPECT_EQ(point.stable, curve.points[i].stable ? 1 : 0);
    EXPECT_EQ(point.harmonics, curve.points[i].harmonics());
    (point.stable == 1 ? stable : unstable) = true;
  }
  EXPECT_TRUE(stable && unstable);
  ASSERT_EQ(tremolo_curve_bifurcations(curve_), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    tremolo_bifurcation found;
    ASSERT_EQ(tremolo_curve_bifurcation_at(curve_, i, &found), TREMOLO_OK);
    EXPECT_EQ(found.kind, TREMOLO_FOLD);
    // A fold's multiplier is +1; it is sought over the frequency, of which it is a square root.
    EXPECT_NEAR(found.multiplier[0], 1.0, 1e-3);
    EXPECT_EQ(found.point.frequency_hz,
              curve.bifurcations[i].point.omega / (2.0 * std::numbers::pi));
  }
  EXPECT_EQ(tremolo_curve_reached(curve_), TREMOLO_CURVE_DONE);
}

TEST_F(CCurve, ACurveThatEndsEarlyKeepsItsPointsAndSaysWhy) {
  load(duffing_basis(2.0, 3.0));
  const std::uint32_t vertex = 3;
  const double forces[3] = {0.0, 0.0, 1.0};
  tremolo_curve_options options;
  tremolo_curve_options_init(&options);
  options.load_vertices = &vertex;
  options.load_forces = forces;
  options.load_count = 1;
  options.most_points = 7;
  ASSERT_EQ(tremolo_response(model_, &options, 0.2, 0.6, &curve_), TREMOLO_OK)
      << tremolo_last_error();
  EXPECT_EQ(tremolo_curve_points(curve_), 7U);
  EXPECT_EQ(tremolo_curve_reached(curve_), TREMOLO_CURVE_LONG);
  EXPECT_NE(std::strstr(tremolo_curve_reason(curve_), "most_points"), nullptr);
  tremolo_curve_point point;
  ASSERT_EQ(tremolo_curve_point_at(curve_, 6, &point), TREMOLO_OK);
  EXPECT_EQ(point.stable, -1);  // without damping
}

// The oscillator x'' + 2 zeta w x' + w^2 x + gamma x^3 with a load at vertex 3, from C.
struct COscillator {
  double omega = 2.0, gamma = 3.0, zeta = 0.02;
  std::uint32_t vertex = 3;
  double forces[3] = {0.0, 0.0, 1.0};
  double reduced = 0.0;  // of the forces
  tremolo_curve_options options = {};

  COscillator() {
    const Model::Pointer model = *Model::from_data(duffing_basis(omega, gamma));
    reduced = (*reduce_force(*model, 3, {0.0, 0.0, 1.0}))[0];
    tremolo_curve_options_init(&options);
    options.damping_ratio = "2%";
    options.load_vertices = &vertex;
    options.load_forces = forces;
    options.load_count = 1;
    options.largest_amplitude = 1e3;
  }
  double rate() const { return 2.0 * zeta * omega; }
  void harmonics(int count) { options.harmonics = options.most_harmonics = count; }
  // Of a point's motion: c_0, a_1, b_1, ...
  std::vector<double> motion(const tremolo_curve* curve, std::size_t index) const {
    std::vector<double> out(static_cast<std::size_t>(2 * options.harmonics + 1));
    EXPECT_EQ(tremolo_curve_motion(curve, index, out.data(), out.size()), TREMOLO_OK);
    return out;
  }
};

tremolo_curve_point point_of(const tremolo_curve* curve, std::size_t index) {
  tremolo_curve_point point = {};
  EXPECT_EQ(tremolo_curve_point_at(curve, index, &point), TREMOLO_OK);
  return point;
}

TEST_F(CCurve, HarmonicsOfALoadHaveTheTransferFunctionOfTheLinearBody) {
  COscillator made;
  load(duffing_basis(made.omega, 0.0));
  made.harmonics(3);
  made.options.load_scale = 0.1;
  const double turn = 2.0 * std::numbers::pi;
  const tremolo_load_harmonic course[] = {{1, 0, 0.7, 30.0}, {3, 0, -0.4, 70.0}, {1, 0, 0.3, 30.0}};
  made.options.load_harmonics = course;
  made.options.load_harmonic_count = 3;
  ASSERT_EQ(tremolo_response(model_, &made.options, 0.2, 0.6, &curve_), TREMOLO_OK)
      << tremolo_last_error();
  for (std::size_t i = 0; i < tremolo_curve_points(curve_); ++i) {
    const std::vector<double> motion = made.motion(curve_, i);
    const tremolo_curve_point point = point_of(curve_, i);
    EXPECT_EQ(point.load_scale, 0.1);
    for (const auto& [k, scale, degrees] : {std::tuple(1, 1.0, 30.0), {3, -0.4, 70.0}}) {
      // The imaginary part of z exp(i k omega t).
      const double speed = k * turn * point.frequency_hz;
      const std::complex<double> z =
          0.1 * made.reduced * std::polar(1.0, degrees * turn / 360.0) * scale /
          std::complex<double>(made.omega * made.omega - speed * speed, made.rate() * speed);
      const auto at = static_cast<std::size_t>(2 * k - 1);
      EXPECT_NEAR(motion[at], z.imag(), 1e-8 * std::abs(z)) << k;
      EXPECT_NEAR(motion[at + 1], z.real(), 1e-8 * std::abs(z)) << k;
    }
  }
}

TEST_F(CCurve, ADampedBackboneOfOneHarmonicIsInClosedForm) {
  COscillator made;
  load(duffing_basis(made.omega, made.gamma));
  made.harmonics(1);
  made.options.load_scale = -0.5;
  ASSERT_EQ(tremolo_damped_backbone(model_, &made.options, 0.5, &curve_), TREMOLO_OK)
      << tremolo_last_error();
  EXPECT_EQ(tremolo_curve_reached(curve_), TREMOLO_CURVE_DONE);
  ASSERT_GT(tremolo_curve_points(curve_), 10U);
  for (std::size_t i = 0; i < tremolo_curve_points(curve_); ++i) {
    const std::vector<double> motion = made.motion(curve_, i);
    const tremolo_curve_point point = point_of(curve_, i);
    const double speed = 2.0 * std::numbers::pi * point.frequency_hz, b = motion[2];
    const double exact = made.omega * made.omega + 0.75 * made.gamma * b * b;
    EXPECT_NEAR(speed * speed, exact, 1e-8 * exact);
    // x = b sin under F cos: the force balances the damping.
    EXPECT_NEAR(point.load_scale * made.reduced, made.rate() * speed * b,
                1e-8 * std::abs(made.rate() * speed * b));
  }
  EXPECT_NEAR(point_of(curve_, tremolo_curve_points(curve_) - 1).amplitude, 0.5, 1e-9);
}

TEST_F(CCurve, FoldsOverTheLoadAreThoseOfTheAmplitudesQuadraticAndMeetInItsCusp) {
  COscillator made;
  load(duffing_basis(made.omega, made.gamma));
  made.harmonics(1);
  const double scale = made.rate() * made.omega * 0.5 / std::abs(made.reduced);
  made.options.load_scale = scale;
  made.options.stability = 0;  // of one harmonic it changes near the folds, not at them
  tremolo_curve* response = nullptr;
  ASSERT_EQ(tremolo_response(model_, &made.options, 0.2, 0.6, &response), TREMOLO_OK);
  ASSERT_EQ(tremolo_curve_bifurcations(response), 2U);
  ASSERT_EQ(tremolo_fold_curve(response, 0, 0.01 * scale, &curve_), TREMOLO_OK)
      << tremolo_last_error();
  tremolo_curve_destroy(response);
  EXPECT_EQ(tremolo_curve_reached(curve_), TREMOLO_CURVE_DONE);
  const double c = 0.75 * made.gamma;
  // a = A^2: G(a) = a ((w0^2 - w^2 + c a)^2 + d^2 w^2) = F^2 and G'(a) = 0.
  for (std::size_t i = 0; i < tremolo_curve_points(curve_); ++i) {
    const std::vector<double> motion = made.motion(curve_, i);
    const tremolo_curve_point point = point_of(curve_, i);
    EXPECT_EQ(point.stable, -1);
    const double speed = 2.0 * std::numbers::pi * point.frequency_hz;
    const double a = motion[1] * motion[1] + motion[2] * motion[2];
    const double off = made.omega * made.omega - speed * speed + c * a;
    const double damping = std::pow(made.rate() * speed, 2);
    const double force = std::pow(point.load_scale * made.reduced, 2);
    EXPECT_NEAR(a * (off * off + damping), force, 1e-8 * force);
    EXPECT_NEAR(off * off + damping + 2.0 * a * c * off, 0.0, 1e-8 * std::pow(c * a, 2));
  }
  ASSERT_EQ(tremolo_curve_bifurcations(curve_), 1U);
  tremolo_bifurcation cusp;
  ASSERT_EQ(tremolo_curve_bifurcation_at(curve_, 0, &cusp), TREMOLO_OK);
  EXPECT_EQ(cusp.kind, TREMOLO_FOLD);
  // There G'' = 0 too: c a = 2 d w / sqrt 3 and w^2 = w0^2 + 3/2 c a.
  const double h = made.rate() * std::sqrt(3.0);
  const double speed = 0.5 * (h + std::sqrt(h * h + 4.0 * made.omega * made.omega));
  EXPECT_NEAR(2.0 * std::numbers::pi * cusp.point.frequency_hz, speed, 1e-8 * speed);
  const double a = 2.0 * made.rate() * speed / std::sqrt(3.0) / c;
  const double force = std::sqrt(a * (std::pow(c * a / 2.0, 2) + std::pow(made.rate() * speed, 2)));
  EXPECT_NEAR(cusp.point.load_scale * std::abs(made.reduced), force, 1e-8 * force);
}

// q2 is linear and forced, V has g q1^2 q2^2: near 1:1 the motion of q2 makes q1 unstable.
TEST_F(CCurve, ABranchBreaksTheSymmetryAndMeetsTheResponseAgain) {
  const Eigen::Vector2d omega(std::sqrt(0.8), 1.0);
  BasisData data =
      testing::sample_basis({omega, {Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()}});
  data.cubic.assign(4, 0.0);
  data.quartic = {0.02, 0.0, 0.2 / 6.0, 0.0, 0.0};
  data.strain_gram.clear();
  load(data);
  // A force that moves the second coordinate alone.
  const Model::Pointer model = *Model::from_data(data);
  const Eigen::MatrixXd rows = model->vertex(3)->rows;
  Eigen::Vector3d force =
      rows.col(1) - rows.col(0).dot(rows.col(1)) / rows.col(0).squaredNorm() * rows.col(0);
  force *= 0.1 / force.dot(rows.col(1));
  const std::uint32_t vertex = 3;
  tremolo_curve_options options;
  tremolo_curve_options_init(&options);
  options.harmonics = options.most_harmonics = 7;
  options.damping_ratio = "0.01118033988749895,0.05";
  options.load_vertices = &vertex;
  options.load_forces = force.data();
  options.load_count = 1;
  options.largest_amplitude = 1e3;
  tremolo_curve* response = nullptr;
  const double turn = 2.0 * std::numbers::pi;
  ASSERT_EQ(tremolo_response(model_, &options, 0.7 / turn, 1.4 / turn, &response), TREMOLO_OK);
  ASSERT_EQ(tremolo_curve_bifurcations(response), 2U);
  tremolo_bifurcation other;
  ASSERT_EQ(tremolo_curve_bifurcation_at(response, 1, &other), TREMOLO_OK);
  EXPECT_EQ(other.kind, TREMOLO_BRANCH);
  EXPECT_EQ(tremolo_fold_curve(response, 0, 2.0, &curve_), TREMOLO_USAGE);
  EXPECT_NE(std::strstr(tremolo_last_error(), "not a fold"), nullptr) << tremolo_last_error();
  for (const int direction : {1, -1}) {
    ASSERT_EQ(tremolo_branch_curve(response, 0, direction, &curve_), TREMOLO_OK)
        << tremolo_last_error();
    EXPECT_EQ(tremolo_curve_reached(curve_), TREMOLO_CURVE_DONE);
    const std::size_t count = tremolo_curve_points(curve_);
    double most = 0.0, last = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::MatrixXd motion(2, 15);
      ASSERT_EQ(tremolo_curve_motion(curve_, i, motion.data(), 30), TREMOLO_OK);
      last = motion.row(0).norm();
      most = std::max(most, last);
    }
    EXPECT_GT(most, 0.1);
    EXPECT_LT(last, 0.2 * most);
    EXPECT_NEAR(point_of(curve_, count - 1).frequency_hz, other.point.frequency_hz, 0.002 / turn);
    tremolo_curve_destroy(curve_);
    curve_ = nullptr;
  }
  EXPECT_EQ(tremolo_branch_curve(response, 0, 2, &curve_), TREMOLO_USAGE);
  tremolo_curve_destroy(response);
}

// A body that keeps its response to the default load shows U q + W f: in time steps too.
TEST_F(CCurve, TheAmplitudeHasTheStoredResponseAsTheBodyHas) {
  BasisData data = duffing_basis(2.0, 3.0);
  data.response.at = {kAtDefaultLoad};
  data.response.surface = BasisRows::Random(15, 3);
  data.response.surface.topRows(3).setZero();
  data.response.interior = BasisRows::Random(6, 3);
  load(data);
  const Model::Pointer model = *Model::from_data(data);
  const double unit = std::abs((*reduce_load(*model, model->default_load()))[0]);
  const double scale = 2.0 * 0.05 * 4.0 * 0.3 / unit;  // 0.3 at resonance
  tremolo_curve_options options;
  tremolo_curve_options_init(&options);
  options.damping_ratio = "5%";
  options.load_scale = scale;
  options.static_scale = 0.2 * scale;
  options.probe = 5;
  options.largest_amplitude = 1e3;
  ASSERT_EQ(tremolo_response(model_, &options, 0.2, 0.6, &curve_), TREMOLO_OK)
      << tremolo_last_error();
  const VertexRows rows = *model->vertex(5), own = *model->response(5);
  DefaultLoad forces = model->default_load();
  for (Eigen::Vector3d& force : forces.forces) force *= scale;
  DefaultLoad constant = forces;
  for (Eigen::Vector3d& force : constant.forces) force *= 0.2;
  for (const std::size_t index : {std::size_t{0}, tremolo_curve_points(curve_) - 1}) {
    tremolo_curve_point point;
    ASSERT_EQ(tremolo_curve_point_at(curve_, index, &point), TREMOLO_OK);
    constexpr int kSteps = 256;
    IntegratorOptions stepping;
    stepping.step = 1.0 / point.frequency_hz / kSteps;
    DampingRatios ratios;
    ratios.of_modes = {0.05};
    put_damping(ratios, stepping);
    Result<Body> made = Body::create(model, kDefaultIntegrator, stepping);
    ASSERT_TRUE(made);
    Body& body = *made;
    const Signal sine{.kind = SignalKind::kSine, .frequency = point.frequency_hz};
    ASSERT_TRUE(body.add_load(sine, forces));
    ASSERT_TRUE(body.add_load(Signal{.kind = SignalKind::kConstant}, constant));
    double largest = 0.0, without = 0.0;
    for (int n = 0; n < 40 * kSteps; ++n) {
      ASSERT_TRUE(body.step().converged);
      if (n < 39 * kSteps) continue;
      largest = std::max(largest, body.displacement(5)->norm());
      without = std::max(without, (rows.rows * body.state().q).norm());
    }
    // 256 steps a period see the largest displacement to their square, 1e-4, and the fifth
    // harmonic is 1e-3 of the motion.
    EXPECT_NEAR(point.amplitude, largest, 1e-3 * largest) << point.frequency_hz;
    EXPECT_GT(std::abs(without - largest), 0.05 * largest);
  }
}

}  // namespace
}  // namespace tremolo
