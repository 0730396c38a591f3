// Periodic motion through the C interface; the parts in C are in c_response_test.c.
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/load.h"
#include "runtime/model.h"
#include "runtime/response/probe.h"
#include "runtime/response/response.h"
#include "runtime/tremolo.h"
#include "tests/response/oscillators.h"
#include "tests/support/sample_basis.h"

extern "C" int tremolo_c_backbone_round(const tremolo_model* model, double omega, double gamma);
extern "C" int tremolo_c_response_refusals(const tremolo_model* model);

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

}  // namespace
}  // namespace tremolo
