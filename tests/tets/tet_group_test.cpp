// Bodies of tetrahedra against each other: the inverse of a bent body, forces from a potential,
// momenta, weight, friction, sleep.
#include "runtime/bodies/tets/motion/tet_group.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using testing::tet_bar;
using testing::TetRandom;

constexpr double kHeapG = 9.81;

// The signed distances of a box from the origin to `size`, used by its bodies for contact.
TetHullPointer box_hull(const TetModelPointer& model, const Eigen::Vector3d& size) {
  GridNodes nodes;
  nodes.spacing = size.minCoeff() / 12.0;
  nodes.origin.setConstant(-4.0 * nodes.spacing);
  for (int axis = 0; axis < 3; ++axis)
    nodes.counts[axis] = 9 + static_cast<std::uint32_t>(std::ceil(size[axis] / nodes.spacing));
  std::vector<float> values;
  for (std::size_t k = 0; k < nodes.counts[2]; ++k)
    for (std::size_t j = 0; j < nodes.counts[1]; ++j)
      for (std::size_t i = 0; i < nodes.counts[0]; ++i) {
        const Eigen::Vector3d out = (nodes.at(i, j, k) - 0.5 * size).cwiseAbs() - 0.5 * size;
        values.push_back(
            static_cast<float>(out.cwiseMax(0.0).norm() + std::min(0.0, out.maxCoeff())));
      }
  Result<DistanceGrid> grid = DistanceGrid::create(nodes, values);
  EXPECT_TRUE(grid) << grid.error().message;
  return std::make_shared<const TetHull>(model, boundary_points(*model), std::move(*grid));
}

// A state that bends and rotates all of a body smoothly, and then moves it.
Eigen::VectorXd bent_state(const TetModel& model, double turn, const Eigen::Vector3d& shift) {
  const Eigen::Matrix3d r =
      Eigen::AngleAxisd(turn, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Eigen::VectorXd x = model.rest();
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    const Eigen::Vector3d at = x.segment<3>(i);
    x.segment<3>(i) =
        r * (at + Eigen::Vector3d(0.4 * at.y() * at.z(), 1.5 * at.x() * at.x(), 0.3 * at.x())) +
        shift;
  }
  return x;
}

TetBody body_at(const TetModelPointer& model, const TetBodyOptions& options,
                const Eigen::VectorXd& x, const Eigen::Vector3d& velocity) {
  Result<TetBody> body = TetBody::create(model, options);
  EXPECT_TRUE(body) << body.error().message;
  EXPECT_TRUE(body->set_state(x, velocity.replicate(x.size() / 3, 1)));
  return std::move(*body);
}

Eigen::VectorXd shifted(const TetModel& model, const Eigen::Vector3d& by) {
  return model.rest() + by.replicate(model.rest().size() / 3, 1);
}

// Slabs of 0.2 x 0.2 x 0.1 m that fall onto the floor z = 0, one at each of the positions.
struct FallingSlabs {
  FallingSlabs(DegreeKind kind, const std::vector<Eigen::Vector3d>& places,
               const TetGroupOptions& settings) {
    options.method = TetMethod::kImplicitEuler;
    options.gravity = {0.0, 0.0, -kHeapG};
    options.beta = 5e-3;
    options.degree.kind = kind;
    begin(places, settings);
  }
  void begin(const std::vector<Eigen::Vector3d>& places, const TetGroupOptions& settings) {
    const TetHullPointer hull = box_hull(model, {0.2, 0.2, 0.1});
    std::vector<TetBody> bodies;
    std::vector<TetContact> contacts;
    for (const Eigen::Vector3d& place : places) {
      bodies.push_back(body_at(model, options, shifted(*model, place), Eigen::Vector3d::Zero()));
      contacts.emplace_back(hull, std::vector<TetObstacle>{{PlaneShape{}, {}, 0.3}});
    }
    reports.resize(places.size());
    group.emplace(std::move(bodies), std::move(contacts), std::vector<double>(places.size(), 0.3),
                  settings);
  }

  TetModelPointer model = tet_bar({2, 2, 1}, {0.2, 0.2, 0.1}, false);
  TetBodyOptions options;
  std::vector<TetStepReport> reports;
  std::optional<TetGroup> group;
};

TEST(TetTree, FindsAgainWhereAPointOfABentBodyWas) {
  const TetModelPointer model = tet_bar({4, 2, 2}, {0.4, 0.1, 0.1}, false);
  const TetTree tree(model);
  const Eigen::VectorXd x = bent_state(*model, 1.1, {0.3, -0.2, 0.7});
  std::vector<TetTree::Box> boxes(tree.size());
  tree.fit(x, boxes);
  TetRandom random(5);
  for (int n = 0; n < 200; ++n) {
    const std::size_t e = static_cast<std::size_t>(
        random.between(0.0, static_cast<double>(model->elements().size()) - 1e-9));
    std::array<double, 4> w{};
    double sum = 0.0;
    for (double& one : w) sum += one = random.between(0.01, 1.0);
    for (double& one : w) one /= sum;
    const auto values = polynomials_at(2, w);
    Eigen::Vector3d place = Eigen::Vector3d::Zero(), rest = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < kMostNodes; ++i) {
      const Eigen::Index at = 3 * Eigen::Index{model->elements()[e].nodes[i]};
      place += values[i] * x.segment<3>(at);
      rest += values[i] * model->rest().segment<3>(at);
    }
    const std::optional<TetPlace> found = tree.find(x, boxes, place);
    ASSERT_TRUE(found);
    EXPECT_LT((tree.rest_place(*found) - rest).norm(), 1e-12);
  }
  EXPECT_FALSE(tree.find(x, boxes, {5.0, 0.0, 0.0}));
}

// Known positions are not searched again, but forces follow the path of the step and the
// friction; when one of both has moved, what is found is as if nothing had been known.
TEST(TetContact, KnownPlacesGiveTheForcesOfAFreshSearch) {
  const Eigen::Vector3d size(0.3, 0.1, 0.1);
  const TetModelPointer model = tet_bar({3, 1, 1}, size, false);
  const TetHullPointer hull = box_hull(model, size);
  const std::vector<TetObstacle> floor = {{PlaneShape{}, {}, 0.4}};
  TetRandom random(31);
  std::array<Eigen::VectorXd, 2> x = {bent_state(*model, 0.2, {0.0, 0.0, -0.02}),
                                      bent_state(*model, 0.5, {0.05, 0.04, 0.06})};
  std::vector<TetContact> kept(2, TetContact(hull, floor));
  const auto forces = [&](std::vector<TetContact>& contacts, const Eigen::VectorXd& from,
                          double friction) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(from.size());
    for (std::size_t i = 0; i < 2; ++i) contacts[i].fit(x[i]);
    contacts[0].clear_partners();
    contacts[0].add_partner({1, 1, &contacts[1], &x[1], &from, friction});
    contacts[0].find(x[0], from);
    contacts[0].add_forces(f);
    return f;
  };
  Eigen::VectorXd before = Eigen::VectorXd::Zero(x[0].size());
  for (int turn = 0; turn < 6; ++turn) {
    const Eigen::VectorXd from = testing::random_state(random, x[0].size(), 1.0);
    if (turn == 2) x[0] = bent_state(*model, 0.3, {0.0, 0.0, -0.01});
    if (turn == 4) x[1] = bent_state(*model, 0.4, {0.05, 0.03, 0.06});
    std::vector<TetContact> fresh(2, TetContact(hull, floor));
    const Eigen::VectorXd f = forces(kept, from, 0.1 * turn);
    EXPECT_EQ(f, forces(fresh, from, 0.1 * turn)) << turn;
    EXPECT_GT((f - before).norm(), 1e-3 * f.norm()) << turn;
    before = f;
  }
}

// Two bodies slide on each other, and turn together: the force of friction, which they remember,
// turns with them.
TEST(TetContact, FrictionIsRememberedAlongTheBodies) {
  const Eigen::Vector3d size(0.3, 0.1, 0.1);
  const TetModelPointer model = tet_bar({3, 1, 1}, size, false);
  const TetHullPointer hull = box_hull(model, size);
  std::array<Eigen::VectorXd, 2> x = {bent_state(*model, 0.2, {0.0, 0.0, 0.0}),
                                      bent_state(*model, 0.5, {0.05, 0.04, 0.06})};
  std::vector<TetContact> contacts(2, TetContact(hull, {}));
  Eigen::VectorXd from = x[0];
  const auto find = [&](double friction) {
    for (std::size_t i = 0; i < 2; ++i) contacts[i].fit(x[i]);
    contacts[0].clear_partners();
    contacts[0].add_partner({1, 1, &contacts[1], &x[1], &x[1], friction});
    contacts[0].find(x[0], from);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(from.size());
    contacts[0].add_forces(f);
    return f;
  };
  const Eigen::VectorXd smooth = find(0.0);
  for (Eigen::Index i = 0; i < from.size(); i += 3) from[i] -= 1e-4;
  const Eigen::VectorXd rough = find(0.4);
  ASSERT_GT((rough - smooth).norm(), 1e-3 * smooth.norm());
  contacts[0].end_step(1.0);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.4, -0.7, 0.5).normalized()).toRotationMatrix();
  const auto turned = [&turn](const Eigen::VectorXd& all) {
    Eigen::VectorXd result(all.size());
    for (Eigen::Index i = 0; i < all.size(); i += 3)
      result.segment<3>(i) = turn * all.segment<3>(i);
    return result;
  };
  for (Eigen::VectorXd& one : x) one = turned(one);
  from = x[0];
  EXPECT_LT((find(0.4) - turned(rough)).norm(), 1e-9 * rough.norm());
  // Without the memory there is no friction at rest.
  contacts[0].restore_memory();
  EXPECT_LT((find(0.4) - turned(smooth)).norm(), 1e-9 * smooth.norm());
}

// Three slabs on each other on a slope of 0.9 of the angle of friction come to rest and stay.
TEST(TetGroup, AStackOnASlopeDoesNotCreep) {
  const double angle = 0.9 * std::atan(0.3);
  for (const double step : {1.0 / 60.0, 1.0 / 120.0}) {
    FallingSlabs slabs(DegreeKind::kAdaptive, {}, {});
    slabs.model = tet_bar({2, 2, 1}, {0.2, 0.2, 0.1}, false, {1e6, 0.45, 1000.0});
    slabs.options = {};
    slabs.options.step = step;
    slabs.options.unsolved = UnsolvedStep::kTakeContact;
    slabs.options.gravity = kHeapG * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    TetGroupOptions awake;
    awake.sleep_speed = 0.0;
    slabs.begin({{0.0, 0.0, 0.0}, {0.02, 0.01, 0.1005}, {-0.01, 0.03, 0.201}}, awake);
    const auto places = [&] {
      Eigen::Vector3d all = Eigen::Vector3d::Zero();
      for (int i = 0; i < 3; ++i) {
        const TetBody& body = slabs.group->body(static_cast<std::size_t>(i));
        all[i] = body.system().momentum(body.positions()).x() / body.model().mass();
      }
      return all;
    };
    const auto run = [&](double seconds) {
      for (int n = 0; n < static_cast<int>(std::lround(seconds / step)); ++n)
        EXPECT_TRUE(slabs.group->step(slabs.reports)) << n;
      return places();
    };
    const Eigen::Vector3d begin = places(), settled = run(8.0);
    EXPECT_LT((settled - begin).cwiseAbs().maxCoeff(), 0.01) << step;
    EXPECT_LT((run(12.0) - settled).cwiseAbs().maxCoeff(), 1e-6) << step;
  }
}

// Bodies that are put back to where they were before they touched do the same again, to the
// tolerance of a step.
TEST(TetGroup, ABodyThatIsPutBackForgetsItsFriction) {
  FallingSlabs slabs(DegreeKind::kQuadratic, {}, {});
  slabs.options.gravity = {1.0, 0.0, -kHeapG};
  slabs.begin({{0.0, 0.0, 0.0}, {0.02, 0.01, 0.1005}}, {});
  TetGroup& group = *slabs.group;
  const std::array<Eigen::VectorXd, 2> start = {group.body(0).positions(),
                                                group.body(1).positions()};
  const auto run = [&] {
    for (int n = 0; n < 20; ++n) EXPECT_TRUE(group.step(slabs.reports)) << n;
    return std::array<Eigen::VectorXd, 2>{group.body(0).positions(), group.body(1).positions()};
  };
  const std::array<Eigen::VectorXd, 2> first = run();
  EXPECT_TRUE(group.touched(1));
  for (std::size_t i = 0; i < 2; ++i)
    ASSERT_TRUE(group.set_state(i, start[i], Eigen::VectorXd::Zero(start[i].size())));
  const std::array<Eigen::VectorXd, 2> again = run();
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_LT((again[i] - first[i]).cwiseAbs().maxCoeff(), 1e-9) << i;
}

// Two bent bodies in each other: the force on all control points of both is the slope of the
// energy, and neither a force nor a torque is left over.
TEST(TetGroup, ForcesBetweenBodiesAreTheSlopeOfTheirEnergyAndKeepBothMomenta) {
  const Eigen::Vector3d size(0.3, 0.1, 0.1);
  const TetModelPointer model = tet_bar({3, 1, 1}, size, false);
  const TetHullPointer hull = box_hull(model, size);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model->rest().size());
  std::array<Eigen::VectorXd, 2> x = {bent_state(*model, 0.2, {0.0, 0.0, 0.0}),
                                      bent_state(*model, 0.5, {0.05, 0.04, 0.06})};
  std::vector<TetContact> contacts(2, TetContact(hull, {}));
  const auto find = [&](const std::array<Eigen::VectorXd, 2>& at) {
    double energy = 0.0;
    for (std::size_t i = 0; i < 2; ++i) contacts[i].fit(at[i]);
    for (std::uint32_t i = 0; i < 2; ++i) {
      contacts[i].clear_partners();
      contacts[i].add_partner({1 - i, 1 - i, &contacts[1 - i], &at[1 - i], &at[1 - i], 0.0});
      contacts[i].find(at[i], at[i]);
      energy += contacts[i].look().energy;
    }
    return energy;
  };
  ASSERT_GT(find(x), 1e-4);
  std::array<Eigen::VectorXd, 2> f = {zero, zero};
  for (std::size_t i = 0; i < 2; ++i) {
    contacts[i].add_forces(f[i]);
    contacts[i].add_partner_forces(0, f[1 - i]);
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  double scale = 0.0;
  for (std::size_t i = 0; i < 2; ++i)
    for (Eigen::Index k = 0; k < zero.size(); k += 3) {
      sum += f[i].segment<3>(k);
      torque += x[i].segment<3>(k).cross(f[i].segment<3>(k));
      scale += f[i].segment<3>(k).norm();
    }
  ASSERT_GT(scale, 1.0);
  EXPECT_LT(sum.norm(), 1e-13 * scale);
  EXPECT_LT(torque.norm(), 1e-12 * scale);
  TetRandom random(9);
  for (int trial = 0; trial < 4; ++trial) {
    const std::array<Eigen::VectorXd, 2> way = {testing::random_state(random, zero.size(), 1.0),
                                                testing::random_state(random, zero.size(), 1.0)};
    const double h = 1e-7;
    const double slope = (find({x[0] + h * way[0], x[1] + h * way[1]}) -
                          find({x[0] - h * way[0], x[1] - h * way[1]})) /
                         (2.0 * h);
    // Central differences of a potential whose second derivative jumps where a point begins to
    // touch.
    EXPECT_NEAR(-f[0].dot(way[0]) - f[1].dot(way[1]), slope, 1e-5 * scale) << trial;
  }
}

// Two free bars meet, off their middles and turning, and part: both momenta of the pair stay.
TEST(TetGroup, MomentumAndAngularMomentumOutliveACollision) {
  const Eigen::Vector3d size(0.3, 0.1, 0.1);
  const TetModelPointer model = tet_bar({3, 1, 1}, size, false);
  const TetHullPointer hull = box_hull(model, size);
  for (const TetMethod method : {TetMethod::kImplicitEuler, TetMethod::kBdf2}) {
    TetBodyOptions options;
    options.method = method;
    options.step = 2e-3;
    options.tolerance = 1e-11;
    options.linear_tolerance = 1e-6;
    options.max_iterations = 100;
    std::vector<TetBody> bodies;
    bodies.push_back(body_at(model, options, model->rest(), {0.5, 0.1, 0.0}));
    bodies.push_back(body_at(model, options, shifted(*model, {0.1, 0.02, 0.15}), {0.0, 0.0, -2.0}));
    const auto momentum = [](const TetGroup& group) -> Eigen::Vector3d {
      return group.body(0).momentum() + group.body(1).momentum();
    };
    TetGroup group(std::move(bodies), std::vector<TetContact>(2, TetContact(hull, {})), {0.5, 0.5},
                   {});
    const Eigen::Vector3d begin = momentum(group);
    const Eigen::Vector3d first = group.body(0).momentum();
    std::vector<TetStepReport> reports(2);
    std::size_t touched = 0;
    for (int n = 0; n < 60; ++n) {
      std::array<Eigen::VectorXd, 2> before = {group.body(0).velocities(),
                                               group.body(1).velocities()};
      ASSERT_TRUE(group.step(reports)) << n;
      ASSERT_FALSE(reports[0].linearised) << n;
      touched += group.contact(0).look().touching + group.contact(1).look().touching;
      if (method != TetMethod::kImplicitEuler) continue;
      // All forces act at the end of the step: their torque about the origin, h of it, is
      // sum x1 x M (v1 - v0). What is left of angular momentum to lose is the method's own.
      Eigen::Vector3d torque = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < 2; ++i)
        torque += group.body(i).system().angular_momentum(group.body(i).positions(),
                                                          group.body(i).velocities() - before[i]);
      EXPECT_LT(torque.norm(), 1e-10 * model->mass()) << n;
    }
    EXPECT_GT(touched, 20U);
    EXPECT_GT((group.body(0).momentum() - first).norm(), 0.2 * model->mass());
    EXPECT_LT((momentum(group) - begin).norm(), 1e-10 * model->mass());
  }
}

TEST(TetGroup, AStackComesToRestAndSleepsAndEachCarriesWhatIsAboveIt) {
  FallingSlabs slabs(DegreeKind::kAdaptive, {{0.0, 0.0, 0.0}, {0.01, 0.0, 0.11}, {0.02, 0.0, 0.22}},
                     {});
  TetGroup& group = *slabs.group;
  int steps = 0;
  for (; steps < 600 && group.sleeping() < 3; ++steps)
    ASSERT_TRUE(group.step(slabs.reports)) << steps;
  ASSERT_EQ(group.sleeping(), 3U);
  EXPECT_LT(group.energy_of_sleep(), 3.0 * 0.5 * slabs.model->mass() * 0.005 * 0.005);
  // The floor's force carries all three slabs, the force between the upper two carries one.
  for (const auto& [level, above] : {std::pair{0, 3.0}, {1, 2.0}, {2, 1.0}}) {
    double up = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      for (const TetTouch& touch : group.contact(i).touches()) {
        const std::size_t other =
            touch.partner == kNoPartner
                ? 99
                : (group.contact(i).partners()[touch.partner].contact == &group.contact(0)   ? 0
                   : group.contact(i).partners()[touch.partner].contact == &group.contact(1) ? 1
                                                                                             : 2);
        const bool below = i == static_cast<std::size_t>(level) &&
                           (other == 99 || other + 1 == static_cast<std::size_t>(level));
        const bool lifts = other == static_cast<std::size_t>(level) && i + 1 == other;
        if (below) up += touch.force.z();
        if (lifts) up -= touch.force.z();
      }
    // Slower than 5 mm/s for half a second, it still accelerates by some hundredths of g.
    EXPECT_NEAR(up, above * slabs.model->mass() * kHeapG,
                0.02 * above * slabs.model->mass() * kHeapG)
        << level;
  }
}

// p.A p has the part of a contact once, or the directions are not conjugate: then it takes more
// than four times as many as a body by itself on the floor, otherwise not twice as many.
TEST(TetGroup, BodiesThatPressOnEachOtherTakeAFewMoreDirections) {
  TetGroupOptions settings;
  settings.sleep_speed = 0.0;
  // Directions a correction, over all steps.
  const auto directions = [&](const std::vector<Eigen::Vector3d>& places) {
    FallingSlabs slabs(DegreeKind::kQuadratic, {}, settings);
    slabs.options.linear_tolerance = 1e-5;
    slabs.begin(places, settings);
    double sum = 0.0, corrections = 0.0;
    for (int n = 0; n < 40; ++n) {
      EXPECT_TRUE(slabs.group->step(slabs.reports)) << n;
      sum += slabs.reports[0].linear;
      corrections += slabs.reports[0].iterations;
    }
    return sum / corrections;
  };
  const Eigen::Vector3d floor = Eigen::Vector3d::Zero(), above(0.013, 0.007, 0.101);
  EXPECT_LT(directions({floor, above}), 3.0 * directions({floor}));
}

// Points of the upper one lie on corners of the lower one's elements, where forces jump.
TEST(TetGroup, SlabsThatLieFlatOnEachOtherAreSolvedAndCarried) {
  TetGroupOptions settings;
  settings.sleep_speed = 0.0;
  FallingSlabs slabs(DegreeKind::kLinear, {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.101}}, settings);
  TetGroup& group = *slabs.group;
  for (int n = 0; n < 60; ++n) {
    ASSERT_TRUE(group.step(slabs.reports)) << n;
    ASSERT_EQ(slabs.reports[0].parts, 1) << n;
    ASSERT_LE(slabs.reports[0].iterations, slabs.options.max_iterations) << n;
  }
  double floor = 0.0;
  for (std::size_t i = 0; i < 2; ++i)
    for (const TetTouch& touch : group.contact(i).touches())
      if (touch.partner == kNoPartner) floor += touch.force.z();
  // If a step ends at a jump, a thousandth of the pressing force is not balanced.
  EXPECT_NEAR(floor, 2.0 * slabs.model->mass() * kHeapG, 0.01 * slabs.model->mass() * kHeapG);
}

TEST(TetGroup, ASleepingStackWakesWhenItIsStruckAndSleepsAgain) {
  TetGroupOptions settings;
  settings.sleep_time = 0.1;
  FallingSlabs slabs(DegreeKind::kLinear, {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.101}, {0.0, 0.0, 0.6}},
                     settings);
  TetGroup& group = *slabs.group;
  bool slept = false, woke = false;
  for (int n = 0; n < 300 && group.sleeping() < 3; ++n) {
    ASSERT_TRUE(group.step(slabs.reports)) << n;
    slept = slept || (group.asleep(0) && group.asleep(1) && !group.asleep(2));
    woke = woke || (slept && !group.asleep(0) && !group.asleep(1));
  }
  EXPECT_TRUE(slept);
  EXPECT_TRUE(woke);
  EXPECT_EQ(group.sleeping(), 3U);
  // Nobody went through anybody.
  EXPECT_GT(group.body(2).positions()[2], 0.15);
}

// A slab on a fixed slab: on a slope of angle a it slides with g (sin a - mu cos a).
TEST(TetGroup, ABodySlidesOnAnotherAsCoulombSays) {
  const Eigen::Vector3d small(0.2, 0.2, 0.05), large(1.2, 0.4, 0.1);
  const TetModelPointer slab = tet_bar({2, 2, 1}, small, false);
  const TetMesh mesh = testing::box_mesh({6, 2, 1}, large);
  auto held = TetModel::create(mesh, {{{"gel", testing::kTetGel}}, {}},
                               testing::vertices_on_plane(mesh, 2, 0.0));
  ASSERT_TRUE(held);
  const double angle = 0.3;
  for (const double mu : {0.15, 0.6}) {
    TetBodyOptions options;
    options.method = TetMethod::kImplicitEuler;
    options.gravity = kHeapG * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    options.beta = 5e-3;
    options.degree.kind = DegreeKind::kLinear;
    std::vector<TetBody> bodies;
    bodies.push_back(body_at(*held, options, (*held)->rest(), Eigen::Vector3d::Zero()));
    bodies.push_back(
        body_at(slab, options, shifted(*slab, {0.1, 0.1, 0.1}), Eigen::Vector3d::Zero()));
    std::vector<TetContact> contacts;
    contacts.emplace_back(box_hull(*held, large), std::vector<TetObstacle>{});
    contacts.emplace_back(box_hull(slab, small), std::vector<TetObstacle>{});
    TetGroupOptions settings;
    settings.sleep_speed = 0.0;
    TetGroup group(std::move(bodies), std::move(contacts), {mu, mu}, settings);
    std::vector<TetStepReport> reports(2);
    for (int n = 0; n < 20; ++n) ASSERT_TRUE(group.step(reports));
    const double before = group.body(1).momentum().x();
    for (int n = 0; n < 18; ++n) ASSERT_TRUE(group.step(reports));
    const double found = (group.body(1).momentum().x() - before) / slab->mass() / 0.3;
    const double expected = std::max(0.0, kHeapG * (std::sin(angle) - mu * std::cos(angle)));
    // The field's normal on the bent slab below is not quite that of the slope.
    EXPECT_NEAR(found, expected, 0.04 * kHeapG) << mu;
  }
}

TEST(TetGroup, ThreadsDoNotChangeABit) {
  const Eigen::Vector3d size(0.2, 0.1, 0.1);
  const TetModelPointer model = tet_bar({2, 1, 1}, size, false);
  const TetHullPointer hull = box_hull(model, size);
  std::vector<Eigen::VectorXd> ends;
  for (const unsigned threads : {1U, 3U}) {
    TetBodyOptions options;
    options.method = TetMethod::kImplicitEuler;
    options.gravity = {0.0, 0.0, -kHeapG};
    options.degree.kind = DegreeKind::kAdaptive;
    std::vector<TetBody> bodies;
    std::vector<TetContact> contacts;
    for (int i = 0; i < 4; ++i) {
      bodies.push_back(body_at(model, options,
                               shifted(*model, {0.03 * i, 0.02 * (i % 2), 0.005 + 0.11 * i}),
                               Eigen::Vector3d(0.1 * i, 0.0, -0.2 * i)));
      contacts.emplace_back(hull, std::vector<TetObstacle>{{PlaneShape{}, {}, 0.3}});
    }
    TetGroupOptions settings;
    settings.threads = threads;
    TetGroup group(std::move(bodies), std::move(contacts), {0.3, 0.3, 0.3, 0.3}, settings);
    std::vector<TetStepReport> reports(4);
    for (int n = 0; n < 10; ++n) ASSERT_TRUE(group.step(reports)) << n;
    Eigen::VectorXd all(4 * model->rest().size());
    for (std::size_t i = 0; i < 4; ++i)
      all.segment(static_cast<Eigen::Index>(i) * model->rest().size(), model->rest().size()) =
          group.body(i).positions();
    ends.push_back(all);
  }
  EXPECT_EQ(ends[0], ends[1]);
}

}  // namespace
}  // namespace tremolo
