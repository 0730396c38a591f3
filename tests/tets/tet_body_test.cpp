// Bodies of corotated tetrahedra in motion: closed forms, momenta, energy, degrees that change,
// steps that are too long.
#include "runtime/bodies/tets/motion/tet_body.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using testing::kTetGel;
using testing::random_degrees;
using testing::random_state;
using testing::tet_bar;
using testing::TetRandom;

TetBody body_of(const TetModelPointer& model, const TetBodyOptions& options) {
  Result<TetBody> body = TetBody::create(model, options);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

// Control values of a displacement along x: u(X) at vertices, the polar form on edges.
template <class Function>
Eigen::VectorXd control_values(const TetModel& model, const Function& u) {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(model.rest().size());
  const auto at = [&](std::size_t node) { return u(model.mesh().vertices[node].x()); };
  for (std::size_t v = 0; v < model.vertices(); ++v) values[3 * v] = at(v);
  for (std::size_t e = 0; e < model.edges(); ++e) {
    const MeshEdge& edge = model.edge(e);
    values[3 * Eigen::Index{edge.point}] =
        2.0 * at(static_cast<std::size_t>(edge.point)) -
        0.5 * (at(static_cast<std::size_t>(edge.a)) + at(static_cast<std::size_t>(edge.b)));
  }
  return values;
}

TEST(TetBody, LongitudinalVibrationHasTheFrequencyOfARod) {
  // nu = 0: the rod's sin(pi x / 2L) with omega = pi/2L sqrt(E/rho) solves the solid exactly.
  Material material = kTetGel;
  material.poisson = 0.0;
  const double length = 0.4;
  const TetModelPointer model = tet_bar({6, 1, 1}, {length, 0.05, 0.05}, true, material);
  const double k = std::numbers::pi / (2.0 * length);
  const double omega = k * std::sqrt(material.young / material.density);
  const Eigen::VectorXd mode = control_values(*model, [k](double x) { return std::sin(k * x); });
  for (const auto& [kind, bound] :
       {std::pair{DegreeKind::kQuadratic, 1e-5}, std::pair{DegreeKind::kLinear, 6e-3}}) {
    TetBodyOptions options;
    options.method = TetMethod::kMidpoint;
    options.step = 2e-3;
    options.tolerance = 1e-12;
    options.linear_tolerance = 1e-8;
    options.degree.kind = kind;
    TetBody body = body_of(model, options);
    ASSERT_TRUE(body.set_state(model->rest() + 1e-7 * mode, Eigen::VectorXd::Zero(mode.size())));
    // q_n+1 + q_n-1 = 2 cos(w h) q_n for the discrete w, where midpoint has tan(w h/2) = omega h/2.
    Eigen::VectorXd weight(mode.size());
    model->mass_times(mode, weight);
    std::array<double, 3> q{};
    double above = 0.0, below = 0.0;
    for (int n = 0; n < 40; ++n) {
      q = {q[1], q[2], weight.dot(body.positions() - model->rest())};
      if (n >= 2) {
        above += (q[0] + q[2]) * q[1];
        below += 2.0 * q[1] * q[1];
      }
      ASSERT_TRUE(body.step().converged);
    }
    const double found = 2.0 / options.step * std::tan(0.5 * std::acos(above / below));
    // Quadratic: of fourth order in k times the edge, (0.26)^4/720; linear: of second, and stiffer.
    EXPECT_NEAR(found / omega, 1.0, bound);
    if (kind == DegreeKind::kLinear) {
      EXPECT_GT(found / omega, 1.0 + 1e-3);
    }
  }
}

// The sag of a bar of cells one thick, over that of a beam, and what its last step took.
struct Sag {
  double share = 0.0;
  TetStepReport last;
};
Sag sag_of_bar(int cells, double length, double side) {
  // Timoshenko: w = q L^4 / 8EI + q L^2 / (2 kappa G A), kappa = 5/6 at nu = 0. So little that it
  // is linear.
  Material material = kTetGel;
  material.poisson = 0.0;
  const double g = 1e-4;
  const TetModelPointer model = tet_bar({cells, 1, 1}, {length, side, side}, true, material);
  TetBodyOptions options;
  options.method = TetMethod::kImplicitEuler;
  options.step = 100.0;  // inertia does not matter: statics
  options.gravity = {0, 0, -g};
  options.tolerance = 1e-10;
  TetBody body = body_of(model, options);
  Sag sag;
  for (int n = 0; n < 3; ++n) {
    sag.last = body.step();
    EXPECT_TRUE(sag.last.converged);
  }
  const double load = material.density * side * side * g;
  const double inertia = std::pow(side, 4) / 12.0;
  const double expected =
      load * std::pow(length, 4) / (8.0 * material.young * inertia) +
      load * length * length / (2.0 * 5.0 / 6.0 * 0.5 * material.young * side * side);
  double tip = 0.0;
  int count = 0;
  for (std::size_t v = 0; v < model->vertices(); ++v)
    if (model->mesh().vertices[v].x() > length - 1e-9) {
      const Eigen::Index at = 3 * v + 2;
      tip -= body.positions()[at] - model->rest()[at];
      ++count;
    }
  sag.share = tip / count / expected;
  return sag;
}

TEST(TetBody, ASagOfASlenderBarIsThatOfABeam) {
  const Sag sag = sag_of_bar(10, 0.5, 0.05);
  // One cell over the height and cubic bending: quadratics of this mesh are some percent stiff.
  EXPECT_NEAR(sag.share, 1.0, 0.02);
}

// Conjugate gradients would take a thousand directions: the last step takes none.
TEST(TetBody, AVerySlenderBarIsFactoredAndSagsAsABeam) {
  const Sag sag = sag_of_bar(50, 1.0, 0.02);
  EXPECT_NEAR(sag.share, 1.0, 0.02);
  EXPECT_GT(sag.last.iterations, 0);
  EXPECT_EQ(sag.last.linear, 0);
}

// A free bar, bent and thrown, turning.
struct Thrown {
  TetModelPointer model = tet_bar({4, 1, 1}, {0.4, 0.1, 0.1}, false);
  Eigen::VectorXd x, v;

  explicit Thrown(double bend = 0.05) {
    x = model->rest();
    v = Eigen::VectorXd::Zero(x.size());
    for (Eigen::Index i = 0; i < x.size(); i += 3) {
      const Eigen::Vector3d at = x.segment<3>(i);
      v.segment<3>(i) = Eigen::Vector3d(1, 2, 3) +
                        Eigen::Vector3d(3, 5, -4).cross(at - Eigen::Vector3d(0.2, 0.05, 0.05));
      v[i + 2] += bend * 200.0 * (at.x() - 0.2) * (at.x() - 0.2);
    }
  }
};

TEST(TetBody, AFreeBodyKeepsItsMomentaAndMidpointItsEnergyOverALongTime) {
  const Thrown thrown;
  TetBodyOptions options;
  options.method = TetMethod::kMidpoint;
  options.step = 2e-3;
  options.tolerance = 1e-9;
  TetBody body = body_of(thrown.model, options);
  ASSERT_TRUE(body.set_state(thrown.x, thrown.v));
  const Eigen::Vector3d p = body.momentum(), l = body.angular_momentum();
  const double energy = body.kinetic_energy() + body.elastic_energy();
  double worst = 0.0;
  for (int n = 0; n < 2000; ++n) {
    ASSERT_TRUE(body.step().converged);
    if (n % 50 == 0)
      worst = std::max(worst, std::abs(body.kinetic_energy() + body.elastic_energy() - energy));
  }
  // The torque after the last correction is some roundings; 2000 steps add up.
  EXPECT_LE((body.momentum() - p).norm(), 1e-12 * p.norm());
  EXPECT_LE((body.angular_momentum() - l).norm(), 1e-10 * l.norm());
  // Midpoint conserves what is quadratic; of this energy it keeps a neighbour: no drift.
  EXPECT_LE(worst, 0.02 * energy);
}

TEST(TetBody, SpinIsLostByTheCornersLaw) {
  const Thrown thrown;
  TetBodyOptions options;
  options.method = TetMethod::kMidpoint;
  options.step = 2e-3;
  options.law = RotationLaw::kCorners;
  TetBody body = body_of(thrown.model, options);
  ASSERT_TRUE(body.set_state(thrown.x, thrown.v));
  const Eigen::Vector3d l = body.angular_momentum();
  // The balance of the step's own residual is exact all the same: what is lost is the law's.
  double worst = 0.0;
  for (int n = 0; n < 500; ++n) {
    ASSERT_TRUE(body.step().converged);
    worst = std::max(worst, (body.angular_momentum() - l).norm() / l.norm());
  }
  EXPECT_GE(worst, 1e-3);
}

TEST(TetBody, EveryMethodConvergesToTheSameMotionInItsOrder) {
  const auto end_of = [](TetMethod method, double step) {
    const Thrown thrown(0.02);
    TetBodyOptions options;
    options.method = method;
    options.step = step;
    options.tolerance = 1e-11;
    options.linear_tolerance = 1e-8;
    options.alpha = 0.1;
    options.beta = 1e-3;
    options.gravity = {0, 0, -9.81};
    TetBody body = body_of(thrown.model, options);
    EXPECT_TRUE(body.set_state(thrown.x, thrown.v));
    const int steps = static_cast<int>(std::lround(0.04 / step));
    for (int n = 0; n < steps; ++n) EXPECT_TRUE(body.step().converged);
    return body.positions();
  };
  const Eigen::VectorXd truth = end_of(TetMethod::kMidpoint, 1e-4);
  for (const auto& [method, order] :
       {std::pair{TetMethod::kImplicitEuler, 1}, std::pair{TetMethod::kMidpoint, 2},
        std::pair{TetMethod::kNewmark, 2}, std::pair{TetMethod::kBdf2, 2}}) {
    const double coarse = (end_of(method, 2e-3) - truth).norm();
    const double fine = (end_of(method, 1e-3) - truth).norm();
    // Half the step; a quarter of an order's play since the smallest periods are near the step.
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.35) << tet_method_name(method);
  }
}

TEST(TetBody, MomentaStayWhenEdgesChangeTheirDegree) {
  TetRandom random(5);
  const Thrown thrown;
  TetBodyOptions options;
  TetBody body = body_of(thrown.model, options);
  for (int trial = 0; trial < 10; ++trial) {
    // From a bent state, off the mean everywhere.
    body.set_degrees(std::vector<std::uint8_t>(thrown.model->edges(), 2));
    ASSERT_TRUE(body.set_state(thrown.x + random_state(random, thrown.x.size(), 0.004),
                               thrown.v + random_state(random, thrown.x.size(), 1.0)));
    const Eigen::Vector3d p = body.momentum(), l = body.angular_momentum();
    const double kinetic = body.kinetic_energy();
    const double energy = kinetic + body.elastic_energy();
    const double taken = body.set_degrees(random_degrees(random, thrown.model->edges()));
    EXPECT_LE((body.momentum() - p).norm(), 1e-12 * p.norm());
    EXPECT_LE((body.angular_momentum() - l).norm(), 1e-10 * l.norm());
    EXPECT_NEAR(energy - body.kinetic_energy() - body.elastic_energy(), taken, 1e-12 * energy);
    // The rotation that restores the angular momentum costs the little that it was off.
    EXPECT_LE(body.kinetic_energy(), kinetic * 1.001);
    // And back: nothing moves.
    const Eigen::VectorXd x = body.positions(), v = body.velocities();
    EXPECT_EQ(body.set_degrees(std::vector<std::uint8_t>(thrown.model->edges(), 2)), 0.0);
    EXPECT_EQ(body.positions(), x);
    EXPECT_EQ(body.velocities(), v);
  }
}

TEST(TetBody, AtTheMeanASwitchKeepsTheShapeAndNeverAddsKineticEnergy) {
  TetRandom random(6);
  const Thrown thrown;
  TetBody body = body_of(thrown.model, {});
  const Eigen::VectorXd v = thrown.v + random_state(random, thrown.x.size(), 2.0);
  ASSERT_TRUE(body.set_state(thrown.x, v));
  const double kinetic = body.kinetic_energy();
  const Eigen::Vector3d l = body.angular_momentum();
  body.set_degrees(std::vector<std::uint8_t>(thrown.model->edges(), 1));
  EXPECT_LE((body.positions() - thrown.x).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_LE(body.kinetic_energy(), kinetic);
  EXPECT_LE((body.angular_momentum() - l).norm(), 1e-13 * l.norm());
}

TEST(TetBody, AdaptiveDegreesFollowWhereABarBends) {
  const TetModelPointer model = tet_bar({10, 1, 1}, {1.0, 0.1, 0.1}, true);
  TetBodyOptions options;
  options.step = 5e-3;
  options.gravity = {0, 0, -2.0};
  options.beta = 0.01;
  options.degree.kind = DegreeKind::kAdaptive;
  TetBody body = body_of(model, options);
  EXPECT_EQ(body.system().quadratic_share(), 0.0);
  double share = 0.0, jump = 0.0;
  std::size_t switched = 0;
  for (int n = 0; n < 200; ++n) {
    const TetStepReport report = body.step();
    ASSERT_TRUE(report.converged);
    share = std::max(share, body.system().quadratic_share());
    jump = std::max(jump, report.jump);
    switched += report.switched;
  }
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.95);
  // An edge becomes linear below 0.0004 of its length: its middle moves by less than half of that.
  EXPECT_GT(switched, 20U);
  EXPECT_GT(jump, 0.0);
  EXPECT_LE(jump, 1e-3);
}

// The sag of a bar under its weight, and the period of a small free vibration, with these degrees.
struct Softness {
  double sag = 0.0, period = 0.0;
};
Softness softness(double young, const DegreeOptions& degree) {
  const TetModelPointer model = tet_bar({8, 2, 2}, {0.4, 0.1, 0.1}, true, {young, 0.4, 1000.0});
  Eigen::Index tip = 0;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(3 * model->vertices()); i += 3)
    if ((model->rest().segment<3>(i) - Eigen::Vector3d(0.4, 0, 0)).norm() < 1e-9) tip = i + 2;
  TetBodyOptions options;
  options.degree = degree;
  options.gravity = {0, 0, -9.81};
  options.alpha = 3.0;
  options.beta = 0.02;
  TetBody hanging = body_of(model, options);
  for (int n = 0; n < 240; ++n) EXPECT_TRUE(hanging.step().converged);
  Softness found;
  found.sag = model->rest()[tip] - hanging.positions()[tip];
  // The beam's first circular frequency gives the step, a sixtieth of a period.
  const double omega = 1.015 * 0.1 / 0.16 * std::sqrt(young / 1000.0);
  TetBodyOptions free;
  free.degree = degree;
  free.method = TetMethod::kMidpoint;
  free.step = 2.0 * std::numbers::pi / omega / 60.0;
  TetBody body = body_of(model, free);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(model->rest().size());
  for (Eigen::Index i = 0; i < v.size(); i += 3) {
    const double along = model->rest()[i] / 0.4;
    if (model->held()[i / 3] == 0) v[i + 2] = 1e-4 * 0.4 * omega * along * along;
  }
  EXPECT_TRUE(body.set_state(model->rest(), v));
  double first = 0.0, last = 0.0, before = 0.0;
  int crossings = 0;
  for (int n = 1; n <= 400; ++n) {
    EXPECT_TRUE(body.step().converged);
    const double z = body.positions()[tip] - model->rest()[tip];
    if (before < 0.0 && z >= 0.0) {
      last = free.step * (n - z / (z - before));
      if (crossings++ == 0) first = last;
    }
    before = z;
  }
  found.period = (last - first) / (crossings - 1);
  return found;
}

TEST(TetBody, AdaptiveEdgesAreAsSoftAsQuadraticOnesHoweverLittleTheyBend) {
  DegreeOptions quadratic, adaptive, seen;
  adaptive.kind = seen.kind = DegreeKind::kAdaptive;
  seen.error = 0.0;
  seen.upper = 1e-3;
  seen.lower = 4e-4;
  for (const double young : {5e6, 2e7}) {
    const Softness all = softness(young, quadratic);
    const Softness some = softness(young, adaptive);
    // `error`, 5 %, bounds what is missing from the energy; less than half of it is.
    EXPECT_NEAR(some.sag / all.sag, 1.0, 0.025) << young;
    EXPECT_NEAR(some.period / all.period, 1.0, 0.025) << young;
    // A threshold in the edge's length sees nothing bend: the linear mesh is left.
    EXPECT_LT(softness(young, seen).sag / all.sag, 0.8) << young;
  }
}

TEST(TetBody, InvertedAndFlatElementsComeBackToRest) {
  const TetModelPointer model = tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  for (const double squeeze : {0.0, -0.5, -1.0}) {
    TetBodyOptions options;
    options.method = TetMethod::kImplicitEuler;
    options.step = 5e-3;
    TetBody body = body_of(model, options);
    TetRandom random(7);
    Eigen::VectorXd x = model->rest() + random_state(random, model->rest().size(), 1e-3);
    for (Eigen::Index i = 0; i < x.size(); i += 3) x[i + 2] *= squeeze;
    ASSERT_TRUE(body.set_state(x, Eigen::VectorXd::Zero(x.size())));
    const double energy = body.elastic_energy();
    // Turned over: all of them; noise decides where it is flat.
    if (squeeze < 0.0) {
      EXPECT_EQ(body.system().inverted(), model->elements().size());
    } else {
      EXPECT_GT(body.system().inverted(), 0U);
    }
    int cut = 0;
    for (int n = 0; n < 400; ++n) {
      const TetStepReport report = body.step();
      ASSERT_TRUE(report.converged);
      cut += report.parts > 1 ? 1 : 0;
    }
    EXPECT_LE(cut, 20);
    ASSERT_TRUE(body.positions().allFinite());
    // From wholly inside out the bar unfolds except for a tangle at rest: a hundredth of the energy
    // stays. All other shapes are forgotten.
    EXPECT_LE(body.elastic_energy(), (squeeze > -1.0 ? 1e-6 : 0.05) * energy) << squeeze;
    // In the tangle no corner is inside out, either: only its energy reveals it.
    EXPECT_EQ(body.system().inverted(), 0U);
  }
}

TEST(TetBody, AStepOfASecondIsMadeOrFailsAndLeavesTheStateAsItWas) {
  const Thrown thrown;
  for (const double bend : {0.05, 5.0}) {
    TetBodyOptions options;
    options.step = 1.0;
    options.gravity = {0, 0, -9.81};
    TetBody body = body_of(thrown.model, options);
    ASSERT_TRUE(body.set_state(thrown.x, bend * thrown.v));
    for (int n = 0; n < 5; ++n) {
      const Eigen::VectorXd before = body.positions();
      const TetStepReport report = body.step();
      ASSERT_TRUE(body.positions().allFinite());
      if (!report.converged) {
        EXPECT_EQ(body.positions(), before);
      }
    }
  }
}

TEST(TetBody, WrongOptionsAreNamed) {
  const TetModelPointer model = tet_bar({1, 1, 1}, {1, 1, 1}, false);
  TetBodyOptions options;
  options.degree.lower = 0.1;
  options.degree.upper = 0.01;
  const auto refused = TetBody::create(model, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("lower <= upper"), std::string::npos);
  options.degree = {};
  options.degree.error = -0.1;
  EXPECT_FALSE(TetBody::create(model, options));
  options.degree.kind = DegreeKind::kAdaptive;
  options.degree.error = 0.0;  // and no threshold: nothing decides
  EXPECT_FALSE(TetBody::create(model, options));
  options.degree = {};
  options.drag = -1.0;
  EXPECT_FALSE(TetBody::create(model, options));
  options.drag = 0.0;
  options.step = 0.0;
  EXPECT_FALSE(TetBody::create(model, options));
  options.step = std::nan("");
  EXPECT_FALSE(TetBody::create(model, options));
}

}  // namespace
}  // namespace tremolo
