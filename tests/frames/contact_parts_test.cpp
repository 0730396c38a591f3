// The parts of contact between bodies, each by itself: the law of a pair, the distance from a bent
// body, the solver of blocks.
#include <algorithm>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/friction.h"
#include "runtime/contact/islands/block_solver.h"
#include "runtime/contact/solve/contact_points.h"

namespace tremolo {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class Numbers {
 public:
  double one(double size) { return size * spread_(engine_); }
  Vector3d vector(double size) { return {one(size), one(size), one(size)}; }
  VectorXd column(Eigen::Index n, double size) {
    return VectorXd::NullaryExpr(n, [&] { return one(size); });
  }
  MatrixXd matrix(Eigen::Index rows, Eigen::Index columns, double size) {
    return MatrixXd::NullaryExpr(rows, columns, [&] { return one(size); });
  }

 private:
  std::mt19937 engine_{7};
  std::uniform_real_distribution<double> spread_{-1.0, 1.0};
};

// h = 1 ms, margin 0.3 mm, as a ball of 6 cm has it.
constexpr double kStep = 1e-3;
ContactLaw pair_law() {
  return {.margin = 3e-4,
          .begins = 3e-4,
          .stiffness = 2e6,
          .restitution = 0.4,
          .friction = 0.3,
          .rebound_speed = 3e-3,
          .shear = 600.0,
          .shear_damping = 4.0};
}

// A linear law as well, from a tenth of the margin on.
ContactLaw linear_law() {
  ContactLaw law = pair_law();
  law.linear_from = 3e-5;
  return law;
}

// A step of a pair whose only point goes from d0 to d1.
ContactTime alone(const ContactLaw& law, double d0, double d1) {
  ContactTime time{kStep, {}};
  time.rate.add(make_gap(law, d0, law.energy(d0), d1).pressure, d1 - d0);
  return time;
}

// A slip in the plane of the fixed normal.
ContactHeld held_at(Numbers& numbers, double slip) {
  ContactHeld held{.normal = Vector3d(0.1, 0.2, 1.0) + numbers.vector(0.1), .limit = 0.01};
  const Vector3d unit = held.normal.normalized(), any = numbers.vector(slip);
  held.slip = any - unit.dot(any) * unit;
  return held;
}

// F.p - F_w.w, the work that the force does on the point less its work on the bending, is the fall
// of the energy less what restitution and friction take; whatever p, w and d1 are.
TEST(ContactParts, ThePairGivesWhatItStored) {
  Numbers numbers;
  int pushed = 0;
  for (int i = 0; i < 4000; ++i) {
    const ContactLaw law = i % 2 == 0 ? pair_law() : linear_law();
    const double d0 = numbers.one(4e-4), d1 = d0 + numbers.one(2e-4);
    ContactHeld held = held_at(numbers, 5e-5);
    // Now and then the point sticks to the obstacle that bends under it.
    const Vector3d bend = numbers.vector(2e-4);
    const ContactWay way{i % 3 == 0 ? bend : numbers.vector(2e-4), bend};
    const double slip = 0.5 * law.shear * held.slip.squaredNorm();
    const ContactForce contact = contact_force(law, make_gap(law, d0, law.energy(d0), d1), way,
                                               alone(law, d0, d1), i % 4 == 0 ? 1.0 : 0.0, held);
    const double work = contact.force.dot(way.path) - contact.bend_force.dot(way.bend);
    const double before = law.energy(d0) + slip;
    EXPECT_NEAR(work, before - contact.energy - contact.lost - contact.friction_loss,
                1e-12 * (before + contact.energy + contact.friction_loss))
        << i;
    EXPECT_GE(contact.lost, -1e-12 * before) << i;
    EXPECT_GE(contact.friction_loss, -1e-12 * before) << i;
    if (contact.pressure == 0.0) continue;
    ++pushed;
    // No correction is longer than the change of distance that the normal leaves unexplained.
    EXPECT_LT(contact.force.norm(), 60.0 * contact.pressure + 0.5) << i;
  }
  EXPECT_GT(pushed, 2000);
}

// Both with the limit of friction fixed and with one that follows the force. A case in a hundred
// may have a kink within the difference.
TEST(ContactParts, TheSlopesAreDerivatives) {
  Numbers numbers;
  int beyond = 0;
  for (int i = 0; i < 1000; ++i) {
    const ContactLaw law = i % 2 == 0 ? pair_law() : linear_law();
    const bool follows = i % 3 == 0;
    const double d0 = numbers.one(2e-4), d1 = d0 + numbers.one(1e-4);
    ContactHeld held = held_at(numbers, i % 5 == 0 ? 0.0 : 3e-5);
    const ContactWay way{numbers.vector(1e-4), numbers.vector(1e-5)};
    const double d_distance = numbers.one(1.0);
    const Vector3d d_path = numbers.vector(1.0), d_bend = numbers.vector(1.0);
    const auto at = [&](double t) {
      return contact_force(law, make_gap(law, d0, law.energy(d0), d1 + t * d_distance),
                           {way.path + t * d_path, way.bend + t * d_bend},
                           alone(law, d0, d1 + t * d_distance), follows ? 1.0 : 0.0, held);
    };
    const double t = 1e-10;
    const ContactForce before = at(-t), after = at(t), middle = at(0.0);
    if (!before.acts || !after.acts || !middle.acts) continue;
    const ContactTime time = alone(law, d0, d1);
    const ContactSlopes slopes =
        contact_slopes(law, make_gap(law, d0, law.energy(d0), d1), way, time, held, follows);
    const ContactSlope &point = slopes.point, &bend = slopes.bend;
    const double taken = slopes.taken_by_distance;
    const auto fall = [&](const ContactSlope& slope) {
      return Vector3d((slope.by_distance + slope.by_taken * taken) * d_distance +
                      slope.by_path * d_path + slope.by_bend * d_bend);
    };
    const double size = point.by_distance.norm() + point.by_path.norm();
    const double off =
        std::max(((before.force - after.force) / (2 * t) - fall(point)).norm(),
                 ((before.bend_force - after.bend_force) / (2 * t) - fall(bend)).norm());
    beyond += off < 2e-5 * size ? 0 : 1;
  }
  EXPECT_LE(beyond, 10);
}

// A ball that rolls: as much of it enters contact in front as leaves it behind. The entering part
// pushes no more than the leaving part, except for the fiftieth that depends on the point's own
// rate.
TEST(ContactParts, RestitutionIsOfThePair) {
  ContactLaw law = pair_law();
  law.friction = 0.0;
  const double up = -2e-4, down = 2e-4;
  ContactTime time{kStep, {}};
  for (const auto& [d0, d1] : {std::pair{down, up}, std::pair{up, down}})
    time.rate.add(make_gap(law, d0, law.energy(d0), d1).pressure, d1 - d0);
  EXPECT_NEAR(time.rate.given, 0.0, 1e-20);
  const auto push = [&](double d0, double d1) {
    ContactHeld held;
    return contact_force(law, make_gap(law, d0, law.energy(d0), d1), {Vector3d(0.0, 0.0, d1 - d0)},
                         time, 0.0, held);
  };
  const ContactForce in = push(down, up), out = push(up, down);
  const double taken = (1.0 - 0.16) / (1.0 + 0.16);  // of a pair that moves as a whole
  EXPECT_NEAR((in.force - out.force).norm() / in.pressure, 2.0 * 0.02 * taken, 1e-12);
  EXPECT_GT(in.lost + out.lost, 0.0);
}

// The links of two points are the derivatives of each other's forces by their distances.
TEST(ContactParts, ThePairsRateLinksItsPoints) {
  Numbers numbers;
  const ContactLaw law = pair_law();
  for (int i = 0; i < 200; ++i) {
    const double d0[] = {numbers.one(2e-4), numbers.one(2e-4)};
    const double d1[] = {d0[0] + numbers.one(1e-6), d0[1] + numbers.one(1e-6)};
    const ContactHeld held = held_at(numbers, 1e-5);
    const ContactWay way{numbers.vector(1e-6), numbers.vector(1e-6)};
    const auto at_end = [&](double change) {
      ContactTime time{kStep, {}};
      for (int k = 0; k < 2; ++k) {
        const double end = d1[k] + (k == 1 ? change : 0.0);
        time.rate.add(make_gap(law, d0[k], law.energy(d0[k]), end).pressure, end - d0[k]);
      }
      return time;
    };
    const auto force = [&](double change) {
      ContactHeld now = held;
      return contact_force(law, make_gap(law, d0[0], law.energy(d0[0]), d1[0]), way, at_end(change),
                           1.0, now);
    };
    const auto link = [&](int k) {
      return contact_slopes(law, make_gap(law, d0[k], law.energy(d0[k]), d1[k]), way, at_end(0.0),
                            held, false);
    };
    const double t = 1e-10;
    ContactHeld limited = held;
    const ContactForce middle = contact_force(law, make_gap(law, d0[0], law.energy(d0[0]), d1[0]),
                                              way, at_end(0.0), 1.0, limited);
    if (!middle.acts) continue;
    const ContactSlopes own = contact_slopes(law, make_gap(law, d0[0], law.energy(d0[0]), d1[0]),
                                             way, at_end(0.0), limited, true);
    const Vector3d fall = (force(-t).force - force(t).force) / (2 * t);
    EXPECT_LT((fall - own.point.by_taken * link(1).taken_by_distance).norm(),
              1e-4 * fall.norm() + 1e-6)
        << i;
  }
}

// Sliding for long, forth, across and back: never more than the limit, always taking.
TEST(ContactParts, FrictionStaysBelowItsLimitAndTakes) {
  Numbers numbers;
  const FrictionLaw law{600.0, 4000.0};
  Vector3d slip = Vector3d::Zero();
  double energy = 0.0, given = 0.0, lost = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double limit = 0.01 * (1.0 + numbers.one(1.0));
    Vector3d path = numbers.vector(i % 3 == 0 ? 1e-6 : 5e-5);
    path.z() = 0.0;
    const Friction friction = friction_force(law, limit, slip, path);
    EXPECT_LE(friction.force.norm(), limit * (1.0 + 1e-12)) << i;
    EXPECT_LE(law.stiffness * friction.slip.norm(), limit * (1.0 + 1e-12)) << i;
    EXPECT_GE(friction.lost, -1e-15 * limit) << i;
    slip = friction.slip;
    energy = friction.energy;
    given -= friction.force.dot(path);
    lost += friction.lost;
  }
  EXPECT_NEAR(given, energy + lost, 1e-12 * given);
}

// A long step of a point that was at rest has the mean of the force along a straight path, L less
// half of L times the elastic part of the path: the closed form of a spring and a slider.
TEST(ContactParts, FrictionIsTheMeanAlongAStraightPath) {
  const FrictionLaw law{600.0, 0.0};
  const double limit = 0.03, elastic = limit / law.stiffness;
  for (const double path : {0.3, 0.9, 1.0, 1.5, 40.0}) {
    const Friction friction =
        friction_force(law, limit, Vector3d::Zero(), path * elastic * Vector3d::UnitX());
    const double mean = path < 1.0 ? 0.5 * path : 1.0 - 0.5 / path;
    EXPECT_NEAR(friction.force.x(), -mean * limit, 1e-12 * limit) << path;
    EXPECT_NEAR(friction.slip.x(), std::min(path, 1.0) * elastic, 1e-12 * elastic) << path;
  }
}

// A damped point that is moved to a position in many small steps or in one ends with the same
// memory.
TEST(ContactParts, TheMemoryOfFrictionIsThatOfThePath) {
  const FrictionLaw law{600.0, 0.0};
  const double limit = 0.03, elastic = limit / law.stiffness;
  const Vector3d path(3.0 * elastic, 0.0, 0.0);
  Vector3d slip = Vector3d::Zero();
  double lost = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Friction friction = friction_force(law, limit, slip, 1e-3 * path);
    slip = friction.slip;
    lost += friction.lost;
  }
  const Friction once = friction_force(law, limit, Vector3d::Zero(), path);
  EXPECT_LT((slip - once.slip).norm(), 1e-12 * elastic);
  EXPECT_NEAR(lost, once.lost, 1e-12 * limit * elastic);
}

// Points of a sphere whose coordinates bend it.
ContactPoints sphere_points(Numbers& numbers, std::size_t count, Eigen::Index r) {
  ContactPoints points;
  for (std::size_t i = 0; i < count; ++i) points.rest.push_back(numbers.vector(1.0).normalized());
  const Eigen::Index n = count;
  points.rows = numbers.matrix(r, 3 * n, 0.2);
  points.field = ScatteredPoints(points.rest, 0.01);
  const Eigen::Index stride = points.field.stride();
  points.axis_rows.setZero(3 * stride, r);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      points.axis_rows.row(axis * stride + i) = points.rows.col(3 * i + axis).transpose();
  return points;
}

TEST(ContactParts, ABentDistanceHasItsDerivatives) {
  Numbers numbers;
  constexpr Eigen::Index kModes = 5;
  const Collider shape = SphereShape{1.0};
  BentScratch scratch;
  for (const std::size_t count : {7, 30, 101}) {
    const ContactPoints points = sphere_points(numbers, count, kModes);
    for (int i = 0; i < 20; ++i) {
      const VectorXd q = numbers.column(kModes, 0.3), dq = numbers.column(kModes, 1.0);
      const Vector3d y = 1.1 * numbers.vector(1.0).normalized(), dy = numbers.vector(1.0);
      VectorXd u;
      points.displacement(q, u);
      const BentShape bent{&shape, &points, &u};
      // The mean by the weights, summed as it is written.
      Vector3d sum = Vector3d::Zero();
      double weight = 0.0;
      for (std::size_t k = 0; k < count; ++k) {
        const double near = 1.0 / ((y - points.rest[k]).squaredNorm() + 0.01);
        sum += near * near * (points.place(k, q) - points.rest[k]);
        weight += near * near;
      }
      EXPECT_LT((field_at(points.field, u, y) - sum / weight).norm(), 1e-14);

      const double t = 1e-6;
      const auto at = [&](double by_place, double by_q) {
        VectorXd moved;
        points.displacement(q + by_q * dq, moved);
        return bent_distance({&shape, &points, &moved}, y + by_place * dy);
      };
      VectorXd change;
      const Vector3d gradient = bent_change(bent, y, scratch, change);
      EXPECT_NEAR((at(t, 0) - at(-t, 0)) / (2 * t), gradient.dot(dy), 1e-8);
      EXPECT_NEAR((at(0, t) - at(0, -t)) / (2 * t), change.dot(dq), 1e-8);
      EXPECT_LT((bent_gradient(bent, y) - gradient).norm(), 1e-15);
      // The point's rows give the same change.
      Eigen::MatrixX3d rows;
      bent_rows(bent, y, scratch, rows);
      EXPECT_NEAR(-gradient.dot(rows.transpose() * dq), change.dot(dq), 1e-12);
    }
  }
}

// Bodies with sizes of their own, linked as given; against a dense decomposition.
void expect_solution(std::size_t bodies, const std::vector<std::pair<int, int>>& pairs,
                     double coupling, int most_iterations) {
  Numbers numbers;
  std::vector<Eigen::Index> first = {0};
  for (std::size_t i = 0; i < bodies; ++i)
    first.push_back(first.back() + 3 + static_cast<Eigen::Index>(i % 4));
  const Eigen::Index n = first.back();
  MatrixXd all = MatrixXd::Zero(n, n);
  std::vector<MatrixXd> blocks(bodies);
  std::vector<const MatrixXd*> diagonal;
  for (std::size_t i = 0; i < bodies; ++i) {
    const Eigen::Index size = first[i + 1] - first[i];
    // Larger than what is used of it.
    blocks[i] = numbers.matrix(size + 2, size + 2, 1.0);
    blocks[i].diagonal().array() += 8.0;
    all.block(first[i], first[i], size, size) = blocks[i].topLeftCorner(size, size);
    diagonal.push_back(&blocks[i]);
  }
  std::vector<std::pair<MatrixXd, MatrixXd>> both(pairs.size());
  std::vector<BlockLink> links;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const std::size_t a = pairs[k].first;
    const std::size_t b = pairs[k].second;
    const Eigen::Index rows = first[a + 1] - first[a], columns = first[b + 1] - first[b];
    both[k] = {numbers.matrix(rows, columns, coupling), numbers.matrix(columns, rows, coupling)};
    all.block(first[a], first[b], rows, columns) = both[k].first;
    all.block(first[b], first[a], columns, rows) = both[k].second;
    links.push_back({a, b, &both[k].first, &both[k].second});
  }
  // Rows of very different units.
  VectorXd scale = VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; i += 2) scale[i] = 1e-6;
  const VectorXd b = numbers.column(n, 1.0);
  VectorXd x(n);
  BlockSolver solver;
  ASSERT_TRUE(solver.solve({first, diagonal, links, &scale}, b, x));
  EXPECT_LE(solver.iterations(), most_iterations);
  EXPECT_LT((scale.asDiagonal() * (all * x - b)).norm(), 2e-8 * (scale.asDiagonal() * b).norm());
}

TEST(ContactParts, BlocksInAChainAreDecomposedExactly) {
  expect_solution(1, {}, 0.0, 1);
  expect_solution(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}}, 1.0, 1);
  // A star, and two trees.
  expect_solution(6, {{0, 1}, {0, 2}, {0, 3}, {0, 4}, {0, 5}}, 0.5, 1);
  expect_solution(7, {{2, 6}, {2, 4}, {1, 5}, {0, 5}, {3, 5}}, 1.0, 1);
}

TEST(ContactParts, BlocksInCirclesAreSolvedFor) {
  std::vector<std::pair<int, int>> grid;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) {
      if (i < 4) grid.emplace_back(5 * i + j, 5 * i + 5 + j);
      if (j < 4) grid.emplace_back(5 * i + j, 5 * i + j + 1);
    }
  expect_solution(25, grid, 0.5, 30);
  // So far from the preconditioner that the sparse decomposition has to do it.
  expect_solution(25, grid, 40.0, BlockSolver::kMostIterations + 1);
}

TEST(ContactParts, ASingularBlockIsNoSolution) {
  const std::vector<Eigen::Index> first = {0, 2};
  const MatrixXd zero = MatrixXd::Zero(2, 2);
  const std::vector<const MatrixXd*> diagonal = {&zero};
  const VectorXd scale = VectorXd::Ones(2), b = VectorXd::Ones(2);
  VectorXd x(2);
  BlockSolver solver;
  EXPECT_FALSE(solver.solve({first, diagonal, {}, &scale}, b, x));
}

}  // namespace
}  // namespace tremolo
