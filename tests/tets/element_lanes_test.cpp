// Shapes of elements in lanes against those found one by one.
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/bodies/tets/elements/tet_element.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using testing::random_state;
using testing::tet_bar;
using testing::TetRandom;

// The first elements of a bar in a state; their shapes begin with a rotation.
struct LaneCase {
  TetModelPointer model = tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  Eigen::VectorXd x;
  std::array<TetShape, kElementLanes> shapes;
  std::array<LaneElement, kElementLanes> group;

  LaneCase(const Eigen::Matrix3d& turn, const Eigen::Matrix3d& begin, double noise) {
    TetRandom random(3);
    x = model->rest();
    for (Eigen::Index i = 0; i < x.size(); i += 3) x.segment<3>(i) = turn * x.segment<3>(i);
    x += random_state(random, x.size(), noise);
    for (std::size_t k = 0; k < kElementLanes; ++k) {
      const TetModelElement& element = model->elements()[k];
      shapes[k].rotation = begin;
      group[k] = {&element.element, &model->elasticity(element), {}, &shapes[k]};
      for (std::size_t i = 0; i < kMostNodes; ++i)
        group[k].nodes[i] = x.data() + 3 * std::size_t{element.nodes[i]};
    }
  }

  TetShape alone(std::size_t k) const {
    const TetModelElement& element = model->elements()[k];
    NodeVectors local(3, kMostNodes);
    for (int i = 0; i < kMostNodes; ++i)
      local.col(i) = Eigen::Map<const Eigen::Vector3d>(group[k].nodes[i]);
    return tet_shape(element.element, model->elasticity(element), RotationLaw::kLeastEnergy, local);
  }
};

Eigen::Matrix3d turn_by(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d(2, -1, 3).normalized()).toRotationMatrix();
}

TEST(ElementLanes, FindTheShapeThatIsFoundAloneFromWhereverItIsNear) {
  const Eigen::Matrix3d turn = turn_by(2.0);
  for (const double off : {0.0, 0.05, 0.3})
    for (const double noise : {0.0, 1e-3, 4e-3})
      for (const std::size_t count : {std::size_t{8}, std::size_t{3}}) {
        LaneCase c(turn, turn_by(2.0 + off), noise);
        ASSERT_EQ(shapes_in_lanes(c.group.data(), count), 0U) << off << " " << noise;
        for (std::size_t k = 0; k < count; ++k) {
          const TetShape wanted = c.alone(k);
          const TetShape& found = c.shapes[k];
          EXPECT_TRUE(found.converged);
          EXPECT_EQ(found.order, wanted.order);
          EXPECT_EQ(found.samples, wanted.samples);
          EXPECT_LT((found.rotation - wanted.rotation).norm(), 1e-13);
          EXPECT_LT((found.mean - wanted.mean).norm(), 1e-13);
          for (std::size_t s = 0; s < 4; ++s) {
            EXPECT_LT((found.seen[s] - wanted.seen[s]).norm(), 1e-13);
            // Pa; Young's modulus is 1e5.
            EXPECT_LT((found.stress[s] - wanted.stress[s]).norm(), 1e-7);
          }
          EXPECT_LT((found.couple - wanted.couple).norm(),
                    1e-13 * c.model->elements()[k].element.couple);
          const TetModelElement& element = c.model->elements()[k];
          const TurnDerivatives d =
              turn_derivatives(element.element, c.model->elasticity(element), wanted);
          ASSERT_TRUE(found.has_turn);
          EXPECT_LT((found.hessian - d.hessian).norm(), 1e-12 * d.hessian.norm());
          EXPECT_LT((found.turned - d.turned).norm(), 1e-12 * d.turned.norm());
        }
        for (std::size_t k = count; k < kElementLanes; ++k)
          EXPECT_EQ(c.shapes[k].rotation, turn_by(2.0 + off));
      }
}

TEST(ElementLanes, WhatIsFarFromRestIsLeftAsItWas) {
  // Turned by half a circle from where it begins, and strained by more than its size.
  for (const auto& [angle, noise] : {std::pair{3.1, 1e-3}, {0.0, 0.08}}) {
    LaneCase c(turn_by(angle), Eigen::Matrix3d::Identity(), noise);
    EXPECT_EQ(shapes_in_lanes(c.group.data(), kElementLanes), 255U) << angle;
    for (const TetShape& shape : c.shapes)
      EXPECT_EQ(shape.rotation, Eigen::Matrix3d::Identity().eval());
  }
  // One that is not a number does not disturb its neighbours.
  LaneCase c(Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), 1e-3);
  const std::vector<double> lost(3, std::nan(""));
  c.group[4].nodes[7] = lost.data();
  EXPECT_EQ(shapes_in_lanes(c.group.data(), kElementLanes), 16U);
}

}  // namespace
}  // namespace tremolo
