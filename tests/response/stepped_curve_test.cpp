// The stable points of a response curve by time stepping.
#include "runtime/response/stepped_curve.h"

#include <cmath>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/load.h"
#include "runtime/response/probe.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

// A body of one coordinate, whose curve has two folds: x'' + 2 zeta w x' + w^2 x + gamma x^3.
struct Hardening {
  Model::Pointer model;
  SteppedLoad load;
  MotionCurve curve;
};

Hardening hardening(double from, double to) {
  const testing::StrainModel linear{Eigen::VectorXd::Constant(1, 2.0),
                                    {Eigen::MatrixXd::Zero(1, 1)}};
  BasisData data = testing::sample_basis(linear);
  data.cubic = {0.0};
  data.quartic = {0.25 * 3.0};
  data.strain_gram.clear();
  Hardening made;
  made.model = *Model::from_data(data);
  DampingRatios ratios;
  ratios.of_modes = {0.05};
  const VibratingSystem system =
      *vibrating_system(*made.model, 0.0, 0.0, modal_rates(ratios, made.model->lambda()));
  const Probe probe = *moving_most(*made.model, made.model->surface().vertex_ids, 0);
  // At resonance the amplitude is force/(2 zeta w^2) = 0.8.
  ResponseRequest request{FourierSeries::Zero(1, 3), from, to};
  request.force(0, 2) = 2.0 * 0.05 * 4.0 * 0.8;
  CurveOptions options;
  options.amplitude = amplitude_of(probe);
  options.largest_amplitude = 1e3;
  made.curve = *response_curve(system, request, options);
  made.load = {made.model, {}, request.force.col(2), Eigen::VectorXd::Zero(1), probe.rows};
  put_damping(ratios, made.load.damping);
  return made;
}

TEST(SteppedCurve, SweepsReachEveryStablePointOnBothSidesOfTheFolds) {
  const Hardening up = hardening(1.2, 4.5);
  ASSERT_EQ(up.curve.end, CurveEnd::kDone);
  ASSERT_EQ(up.curve.bifurcations.size(), 2U);
  int stable = 0;
  for (const CurvePoint& point : up.curve.points) stable += point.stable ? 1 : 0;
  ASSERT_LT(stable, static_cast<int>(up.curve.points.size()));
  const Result<SteppedCurve> stepped = step_curve(up.load, up.curve, 1.0);
  ASSERT_TRUE(stepped) << stepped.error().message;
  EXPECT_EQ(stepped->points, stable);
  // Next to a fold, which the steps have elsewhere, a point may be lost.
  EXPECT_LE(stepped->elsewhere, 2);
  // Settled to 1e-4, by steps that are good for 1e-4; five harmonics and more hold all but 1e-3 of
  // the motion, which the amplitude has a part of.
  EXPECT_LE(stepped->difference, 1e-3);
  // A transient of 5 % damping decays by e^-0.31 a period: to 1e-4 of a change of some per cent it
  // takes more than ten.
  EXPECT_GT(stepped->periods, 10.0 * stable);
  EXPECT_GE(stepped->steps, 16);
}

TEST(SteppedCurve, AMotionThatIsNotTheCurvesIsCounted) {
  Hardening up = hardening(1.2, 4.5);
  up.load.periodic *= 1.2;
  const Result<SteppedCurve> stepped = step_curve(up.load, up.curve, 1.0);
  ASSERT_TRUE(stepped) << stepped.error().message;
  EXPECT_GT(stepped->elsewhere, stepped->points / 2);
}

TEST(SteppedCurve, ACurveWithoutAStablePointIsRefused) {
  Hardening up = hardening(1.2, 4.5);
  for (CurvePoint& point : up.curve.points) point.stable = false;
  const Result<SteppedCurve> stepped = step_curve(up.load, up.curve, 1.0);
  ASSERT_FALSE(stepped);
  EXPECT_NE(stepped.error().message.find("no stable point"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
