// The projection of vectors onto what linear edges can make, against the dense normal equations.
#include "runtime/bodies/tets/solve/mass_projection.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using namespace testing;

// E of one axis: a column for each free control point. Held ones have none.
Eigen::MatrixXd free_to_all(const TetSystem& system) {
  const TetModel& model = system.model();
  Eigen::MatrixXd e = Eigen::MatrixXd::Zero(model.nodes(), 0);
  for (std::size_t i = 0; i < model.nodes(); ++i) {
    if (system.active()[i] == 0) continue;
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(3 * e.rows());
    unit[3 * i] = 1.0;
    system.follow_ends(unit);
    e.conservativeResize(Eigen::NoChange, e.cols() + 1);
    for (Eigen::Index k = 0; k < e.rows(); ++k) e(k, e.cols() - 1) = unit[3 * k];
  }
  return e;
}

Eigen::MatrixXd mass_matrix(const TetModel& model) {
  const Eigen::Index count = model.nodes();
  Eigen::MatrixXd m(count, count);
  Eigen::VectorXd column(3 * count);
  for (Eigen::Index j = 0; j < count; ++j) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(3 * count);
    unit[3 * j] = 1.0;
    model.mass_times(unit, column);
    for (Eigen::Index i = 0; i < count; ++i) m(i, j) = column[3 * i];
  }
  return m;
}

// The largest difference from the normal equations' own over the largest that linear edges left.
double projection_error(const TetSystem& system, const Eigen::VectorXd& before,
                        const Eigen::VectorXd& after) {
  const Eigen::MatrixXd e = free_to_all(system), m = mass_matrix(system.model());
  const Eigen::LDLT<Eigen::MatrixXd> normal(e.transpose() * m * e);
  Eigen::VectorXd ends = before;
  system.follow_ends(ends);
  const double scale = (before - ends).cwiseAbs().maxCoeff();
  double worst = 0.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd left(e.rows()), found(e.rows());
    for (Eigen::Index i = 0; i < e.rows(); ++i) {
      left[i] = before[3 * i + axis] - ends[3 * i + axis];
      found[i] = after[3 * i + axis] - ends[3 * i + axis];
    }
    const Eigen::VectorXd wanted = e * normal.solve(e.transpose() * (m * left));
    worst = std::max(worst, (found - wanted).cwiseAbs().maxCoeff() / scale);
  }
  return worst;
}

TEST(MassProjection, IsTheSolutionOfTheNormalEquationsForAllVectorsAtOnce) {
  TetRandom random(11);
  for (const bool held : {false, true}) {
    const TetModelPointer model = tet_bar({3, 2, 1}, {0.3, 0.15, 0.1}, held);
    TetSystem system(model, RotationLaw::kLeastEnergy);
    MassProjection projection(*model);
    for (int trial = 0; trial < 3; ++trial) {
      system.set_degrees(random_degrees(random, model->edges()));
      // Vectors of very different size: lanes do not disturb each other.
      const std::array<double, 4> sizes = {1e-12, 1.0, 1e3, 1e-3};
      std::array<Eigen::VectorXd, 4> vectors, before;
      for (std::size_t v = 0; v < 4; ++v) {
        vectors[v] = random_state(random, model->rest().size(), sizes[v]);
        if (held)
          for (std::size_t i = 0; i < model->nodes(); ++i)
            if (model->held()[i] != 0) vectors[v].segment<3>(3 * i).setZero();
        before[v] = vectors[v];
      }
      const std::array<Eigen::VectorXd*, 4> pointers = {&vectors[0], &vectors[1], &vectors[2],
                                                        &vectors[3]};
      const int steps = projection.project(system, pointers, !held);
      EXPECT_GT(steps, 2);
      EXPECT_LT(steps, 45);
      for (std::size_t v = 0; v < 4; ++v) {
        // Ten times the tolerance of conjugate gradients, whose norm weighs entries by the mass.
        EXPECT_LT(projection_error(system, before[v], vectors[v]), 1e-5) << held << v;
        if (held) continue;
        const Eigen::Vector3d sum = system.momentum(before[v]);
        EXPECT_LT((system.momentum(vectors[v]) - sum).norm(), 1e-13 * model->mass() * sizes[v]);
      }
    }
  }
}

TEST(MassProjection, WhatLinearEdgesCanMakeStays) {
  TetRandom random(12);
  const TetModelPointer model = tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  TetSystem system(model, RotationLaw::kLeastEnergy);
  MassProjection projection(*model);
  system.set_degrees(random_degrees(random, model->edges()));
  Eigen::VectorXd y = random_state(random, model->rest().size(), 1.0);
  system.follow_ends(y);
  const Eigen::VectorXd before = y;
  const std::array<Eigen::VectorXd*, 1> pointers = {&y};
  EXPECT_EQ(projection.project(system, pointers, true), 0);
  EXPECT_EQ(y, before);
}

}  // namespace
}  // namespace tremolo
