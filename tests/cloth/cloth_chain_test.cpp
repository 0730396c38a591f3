// Chains and strips whose answers are known: the elastic catenary and the compound pendulum.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/step/nodal_integrator.h"
#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kFall = 9.81;        // m/s^2
constexpr double kSpan = 1.0;         // m, between the ends, on one level
constexpr double kUnstretched = 1.3;  // m
constexpr double kWeight = 4.0;       // N/m of unstretched length

// Irvine's elastic catenary (1981, eq. 1.28 to 1.30) between two points on one level: x and z at
// the unstretched length s, with the horizontal force H that makes its span kSpan.
class ElasticCatenary {
 public:
  explicit ElasticCatenary(double stiffness) : stiffness_(stiffness) {
    double low = 1e-6, high = 1e6;
    for (int k = 0; k < 200; ++k) {
      h_ = std::sqrt(low * high);
      (at(kUnstretched).x() < kSpan ? low : high) = h_;
    }
  }
  double horizontal() const { return h_; }
  Vector2d at(double s) const {
    const double v = 0.5 * kWeight * kUnstretched, rest = v - kWeight * s;
    const double x =
        h_ * s / stiffness_ + h_ / kWeight * (std::asinh(v / h_) - std::asinh(rest / h_));
    const double z = (rest * rest - v * v) / (2.0 * kWeight * stiffness_) +
                     (std::hypot(h_, rest) - std::hypot(h_, v)) / kWeight;
    return {x, z};
  }

 private:
  double stiffness_;  // EA, N
  double h_ = 0.0;    // N
};

// The inextensible one: z of the chain of kUnstretched at x, by the parameter a = H/w.
double cosh_depth(double x) {
  double low = 1e-3, high = 1e3;
  for (int k = 0; k < 200; ++k) {
    const double a = std::sqrt(low * high);
    (2.0 * a * std::sinh(0.5 * kSpan / a) > kUnstretched ? low : high) = a;
  }
  return low * (std::cosh((x - 0.5 * kSpan) / low) - std::cosh(0.5 * kSpan / low));
}

struct HungChain {
  ClothParts parts;
  VectorXd x;
};

// The chain at rest under its own weight: its ends are fixed, each mass is that of a spring.
HungChain hung_chain(std::size_t springs, double stiffness) {
  const double rest = kUnstretched / static_cast<double>(springs);
  HungChain chain{testing::sample_chain(springs, {kSpan / static_cast<double>(springs), 0.0, 0.0},
                                        rest, kWeight * rest / kFall, {stiffness / rest, 2.0}),
                  {}};
  // It begins hanging, as what lies straight is pressed together and may buckle upwards.
  for (std::size_t i = 0; i <= springs; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(springs);
    chain.parts.x[3 * i + 2] = -1.6 * u * (1.0 - u);
  }
  Result<ClothModel> model = ClothModel::create(chain.parts);
  EXPECT_TRUE(model);
  model->set_gravity({0.0, 0.0, -kFall});
  EXPECT_TRUE(model->pin(std::array<std::size_t, 2>{0, springs}, MotionPath{}, 1e300));
  NodalOptions options{.step = 0.1, .tolerance = 1e-13};
  const auto integrator = make_nodal_integrator("implicit-euler", *model, options);
  EXPECT_TRUE(integrator);
  NodalState state{model->parts().x, VectorXd::Zero(model->parts().x.size()), 0.0};
  for (int k = 0; k < 2000; ++k) EXPECT_TRUE((*integrator)->step(state).made);
  EXPECT_LE(state.v.lpNorm<Eigen::Infinity>(), 1e-11);
  chain.x = state.x;
  return chain;
}

// The force of spring i, N, that its first particle feels.
Vector3d spring_pull(const HungChain& chain, std::size_t i) {
  const Eigen::Index at = 3 * i;
  const Vector3d way = chain.x.segment<3>(at + 3) - chain.x.segment<3>(at);
  const ClothSprings& springs = chain.parts.structural;
  return springs.law.stiffness * (way.norm() - springs.rest[i]) * way.normalized();
}

TEST(ClothChains, PullSidewaysAllTheSameAndCarryTheWeightMassByMass) {
  constexpr std::size_t kSprings = 24;
  const HungChain chain = hung_chain(kSprings, 60.0);
  const double each = kWeight * kUnstretched / kSprings;
  const Vector3d first = spring_pull(chain, 0);
  // Newton's residual, 1e-13 of a load of 1 N, and rounding of lengths times stiffness.
  for (std::size_t i = 1; i < kSprings; ++i) {
    EXPECT_NEAR(spring_pull(chain, i).x(), first.x(), 1e-11) << i;
    EXPECT_NEAR(spring_pull(chain, i).z() - spring_pull(chain, i - 1).z(), each, 1e-11) << i;
    EXPECT_NEAR(spring_pull(chain, i).y(), 0.0, 1e-12) << i;
  }
}

double catenary_error(std::size_t springs, const ElasticCatenary& exact, double stiffness) {
  const HungChain chain = hung_chain(springs, stiffness);
  double largest = 0.0;
  for (std::size_t i = 0; i <= springs; ++i) {
    const Vector2d known =
        exact.at(kUnstretched * static_cast<double>(i) / static_cast<double>(springs));
    const Eigen::Index at = 3 * i;
    largest = std::max(
        {largest, std::abs(chain.x[at] - known.x()), std::abs(chain.x[at + 2] - known.y())});
  }
  return largest;
}

TEST(ClothChains, ReachTheElasticCatenaryWithOrderTwo) {
  constexpr double kStiffness = 60.0;  // N: it stretches by a few hundredths
  const ElasticCatenary exact(kStiffness);
  EXPECT_NEAR(exact.at(kUnstretched).x(), kSpan, 1e-13);
  double before = 0.0;
  for (const std::size_t springs : {12U, 24U, 48U}) {
    const double error = catenary_error(springs, exact, kStiffness);
    if (before > 0.0) {
      EXPECT_NEAR(std::log2(before / error), 2.0, 0.03) << springs;
    }
    before = error;
  }
  // The chain hangs 0.37 m deep.
  EXPECT_LE(before, 2e-4);
}

TEST(ClothChains, AreTheCoshOnlyWhereNothingStretches) {
  // The elastic catenary differs from the cosh as 1/EA.
  double before = 0.0;
  for (const double stiffness : {1e2, 1e3, 1e4}) {
    const ElasticCatenary elastic(stiffness);
    const Vector2d middle = elastic.at(0.5 * kUnstretched);
    const double off = std::abs(middle.y() - cosh_depth(middle.x()));
    if (before > 0.0) {
      EXPECT_NEAR(before / off, 10.0, 0.5) << stiffness;
    }
    before = off;
  }
  // A chain that stretches by a few hundredths is much nearer to its own catenary than to the cosh.
  const ElasticCatenary soft(60.0);
  const HungChain chain = hung_chain(48, 60.0);
  const Vector3d middle = chain.x.segment<3>(3 * 24);
  EXPECT_GT(std::abs(middle.z() - cosh_depth(middle.x())),
            50.0 * std::abs(middle.z() - soft.at(0.5 * kUnstretched).y()));
}

// A strip fixed at the middle of its upper edge, at rest at an angle.
struct Strip {
  ClothModel model;
  VectorXd start;
  std::size_t pivot = 0;
};

constexpr double kFirstAngle = 0.6;  // rad
constexpr double kSwingStep = 5e-4;  // s

Strip tilted_strip(double stiffness) {
  SceneCloth cloth;
  cloth.grid.columns = 3;
  cloth.grid.rows = 11;
  cloth.grid.width = 0.1;
  cloth.grid.height = 0.5;
  cloth.grid.corner = {-0.05, 0.0, -0.5};
  cloth.grid.along = Vector3d::UnitX();
  cloth.grid.across = Vector3d::UnitZ();
  cloth.density = 0.3;
  cloth.drag = 0.0;
  const double damping = 2e-5 * stiffness;
  cloth.structural = cloth.shear = cloth.bend = {stiffness, damping};
  Strip strip{testing::sample_model(cloth), {}, 3 * 10 + 1};
  strip.model.set_gravity({0.0, 0.0, -kFall});
  EXPECT_TRUE(strip.model.pin(std::array<std::size_t, 1>{strip.pivot}, MotionPath{}, 1e300));
  strip.start = strip.model.parts().x;
  const Eigen::AngleAxisd turn(kFirstAngle, Vector3d::UnitY());
  for (Eigen::Index i = 0; i < strip.start.size(); i += 3)
    strip.start.segment<3>(i) = turn * Vector3d(strip.start.segment<3>(i));
  return strip;
}

// The period of the rigid body of the same masses: 2 pi sqrt(J/(m g d)) over the
// arithmetic-geometric mean of 1 and cos(angle/2), exact at any angle.
double compound_period(const Strip& strip) {
  const VectorXd& x = strip.model.parts().x;
  double moment = 0.0, inertia = 0.0;
  for (Eigen::Index i = 0; i < strip.model.mass().size(); ++i) {
    moment -= strip.model.mass()[i] * x[3 * i + 2];
    inertia += strip.model.mass()[i] * x.segment<3>(3 * i).squaredNorm();
  }
  double a = 1.0, b = std::cos(0.5 * kFirstAngle);
  for (int k = 0; k < 10; ++k) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2.0 * M_PI * std::sqrt(inertia / (moment * kFall)) / a;
}

// Between two passages of the mass centre under the pivot in one direction.
double swung_period(const Strip& strip) {
  const NodalOptions options{.step = kSwingStep, .tolerance = 1e-10};
  const auto integrator = make_nodal_integrator("energy", strip.model, options);
  EXPECT_TRUE(integrator);
  NodalState state{strip.start, VectorXd::Zero(strip.start.size()), 0.0};
  const auto aside = [&] {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < strip.model.mass().size(); ++i)
      sum += strip.model.mass()[i] * state.x[3 * i];
    return sum;
  };
  std::vector<double> passages;
  double before = aside();
  while (passages.size() < 2 && state.time < 5.0) {
    const double begun = state.time;
    EXPECT_TRUE((*integrator)->step(state).made);
    const double now = aside();
    if (before < 0.0 && now >= 0.0)
      passages.push_back(begun + options.step * before / (before - now));
    before = now;
  }
  return passages.size() < 2 ? 0.0 : passages[1] - passages[0];
}

TEST(ClothChains, AStripThatDoesNotStretchSwingsAsTheCompoundPendulum) {
  double before = 0.0;
  for (const double stiffness : {2e3, 2e4, 2e5}) {
    const Strip strip = tilted_strip(stiffness);
    const double exact = compound_period(strip);
    // The method's own lag, (h omega)^2/12, is known; the rest is what the strip stretches.
    const double lag = std::pow(2.0 * M_PI / exact * kSwingStep, 2) / 12.0;
    const double off = swung_period(strip) / exact - 1.0 - lag;
    EXPECT_GT(off, 0.0) << stiffness;
    if (before > 0.0) {
      EXPECT_NEAR(before / off, 10.0, 1.0) << stiffness;
    }
    before = off;
  }
  EXPECT_LE(before, 1.2e-6);
}

}  // namespace
}  // namespace tremolo
