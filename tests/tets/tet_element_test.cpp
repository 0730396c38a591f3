// One corotated element against its definition, against the stiffness at rest and StVK's limit, and
// in states that no mesh should be in.
#include "runtime/bodies/tets/elements/tet_element.h"

#include <algorithm>
#include <tuple>

#include <gtest/gtest.h>

#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/bodies/tets/elements/float_blocks.h"
#include "tests/support/meshes/random_tet.h"

namespace tremolo {
namespace {

using testing::RandomTet;
using testing::rest_points;
using testing::stiffness_times;
using testing::TetRandom;

const Material kTetRubber{1e5, 0.45, 1000.0};

Material tet_wood() {
  OrthotropicElasticity wood;
  wood.young = {1.1e5, 0.9e5, 1.6e5};
  wood.poisson = {0.3, 0.25, 0.2};
  wood.shear = {0.4e5, 0.5e5, 0.3e5};
  wood.axes = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Material material;
  material.orthotropic = wood;
  return material;
}

// Order and material: 0 isotropic, 1 orthotropic.
class TetElements : public ::testing::TestWithParam<std::tuple<int, int>> {
 protected:
  int order() const { return std::get<0>(GetParam()); }
  Material material() const { return std::get<1>(GetParam()) == 0 ? kTetRubber : tet_wood(); }
};
INSTANTIATE_TEST_SUITE_P(All, TetElements,
                         ::testing::Combine(::testing::Values(1, 2), ::testing::Values(0, 1)));

double energy_at(const RandomTet& tet, RotationLaw law, const NodeVectors& x) {
  return tet_energy(tet.element, tet_shape(tet.element, tet.elasticity, law, x));
}

NodeVectors force_at(const RandomTet& tet, RotationLaw law, const NodeVectors& x) {
  return tet_force(tet.element, tet_shape(tet.element, tet.elasticity, law, x));
}

TEST_P(TetElements, AnyRigidMotionCostsNoForceAndNoEnergy) {
  TetRandom random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const RandomTet tet = random.tet(material());
    const NodeVectors rest = rest_points(tet.corners, order());
    const NodeVectors moved = (random.rotation() * rest).colwise() + random.vector(5.0);
    const NodeVectors bent = random.moved(rest, 0.2);
    for (const RotationLaw law : {RotationLaw::kLeastEnergy, RotationLaw::kCorners}) {
      const double scale = force_at(tet, law, bent).norm();
      EXPECT_LE(force_at(tet, law, moved).norm(), 1e-12 * scale);
      EXPECT_LE(energy_at(tet, law, moved), 1e-20 * energy_at(tet, law, bent));
    }
  }
}

using FloatColumn = Eigen::Map<const Eigen::Vector3f>;

// The columns of the exact tangent in single precision are those in double precision, rotated.
TEST_P(TetElements, PartsInFloatsAreThoseInDoubles) {
  TetRandom random(17);
  for (const double velocity : {0.0, 0.3})
    for (int trial = 0; trial < 20; ++trial) {
      const RandomTet tet = random.tet(material());
      const NodeVectors rest = rest_points(tet.corners, order());
      const NodeVectors x = random.moved(NodeVectors(random.rotation() * rest), 0.1);
      const TetShape shape = tet_shape(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, x);
      const TangentFactors factors{1.0, velocity, TangentKind::kExact};
      const TangentParts wanted = tangent_parts(tet.element, tet.elasticity, shape, factors);
      FloatParts found;
      find_float_parts(tet.element, tet.elasticity, shape, factors, found);
      EXPECT_EQ(found.damped, velocity != 0.0);
      EXPECT_FLOAT_EQ(found.couple, static_cast<float>(wanted.couple));
      for (std::size_t first = 0; first < (found.damped ? kRanks : 3); first += 3) {
        const auto& columns = first == 0 ? wanted.slopes : wanted.turned;
        const Eigen::Matrix3d& middle = first == 0 ? wanted.of_slopes : wanted.of_turned;
        double largest = 0.0;
        for (const NodeVectors& column : columns)
          largest = std::max(largest, column.cwiseAbs().maxCoeff());
        for (Eigen::Index i = 0; i < x.cols(); ++i) {
          Eigen::Matrix3d left;
          for (std::size_t m = 0; m < 3; ++m) left.col(m) = shape.rotation * columns[m].col(i);
          const Eigen::Matrix3d right = left * middle;
          for (std::size_t m = 0; m < 3; ++m) {
            const std::size_t at = 4 * (kRanks * static_cast<std::size_t>(i) + first + m);
            // Some tens of roundings of floats.
            EXPECT_LT((FloatColumn(found.left + at).cast<double>() - left.col(m)).norm(),
                      3e-6 * largest);
            EXPECT_LT((FloatColumn(found.right + at).cast<double>() - right.col(m)).norm(),
                      3e-6 * largest * middle.norm());
          }
        }
      }
      for (Eigen::Index i = 0; i < x.cols(); ++i)
        EXPECT_LT((FloatColumn(found.gradient + 4 * i).cast<double>() -
                   shape.rotation * wanted.gradients.col(i))
                      .norm(),
                  1e-6 * wanted.gradients.norm());
    }
}

TEST_P(TetElements, ForceIsTheGradientOfTheEnergy) {
  TetRandom random(2);
  for (int trial = 0; trial < 30; ++trial) {
    const RandomTet tet = random.tet(material());
    const NodeVectors rest = rest_points(tet.corners, order());
    const NodeVectors x = random.moved(NodeVectors(random.rotation() * rest), 0.12);
    const NodeVectors force = force_at(tet, RotationLaw::kLeastEnergy, x);
    NodeVectors direction = random.moved(NodeVectors::Zero(3, x.cols()), 1.0);
    // Central differences of fourth order: at 1e-3 m their error is 1e-12 of the energy's fifth
    // derivative, rounding's 1e-13.
    const double h = 1e-3;
    const auto at = [&](double s) {
      return energy_at(tet, RotationLaw::kLeastEnergy, NodeVectors(x + s * direction));
    };
    const double slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    EXPECT_NEAR(slope, force.cwiseProduct(direction).sum(), 1e-8 * force.norm());
  }
}

TEST_P(TetElements, ForceAndDampingHaveNeitherSumNorTorque) {
  TetRandom random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const RandomTet tet = random.tet(material());
    const NodeVectors x =
        random.moved(NodeVectors(random.rotation() * rest_points(tet.corners, order())), 0.15);
    const NodeVectors v = random.moved(NodeVectors::Zero(3, x.cols()), 2.0);
    const TetShape shape = tet_shape(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, x);
    ASSERT_TRUE(shape.converged);
    for (const NodeVectors& f :
         {tet_force(tet.element, shape),
          tet_damping_force(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, shape, v)}) {
      EXPECT_LE(f.rowwise().sum().norm(), 1e-12 * f.norm());
      EXPECT_LE(testing::torque_of(x, f).norm(), 1e-12 * testing::torque_scale(x, f));
    }
  }
}

TEST_P(TetElements, TheCornersLawHasATorqueWhenAnElementIsQuadratic) {
  TetRandom random(4);
  double worst = 0.0;
  for (int trial = 0; trial < 50; ++trial) {
    const RandomTet tet = random.tet(material());
    const NodeVectors x = random.moved(rest_points(tet.corners, order()), 0.1);
    const NodeVectors f = force_at(tet, RotationLaw::kCorners, x);
    worst = std::max(worst, testing::torque_of(x, f).norm() / testing::torque_scale(x, f));
  }
  // Linear and isotropic it is the usual element. Quadratic ones have some percent.
  if (order() == 1 && std::get<1>(GetParam()) == 0) {
    EXPECT_LE(worst, 1e-12);
  } else {
    EXPECT_GE(worst, 0.005);
  }
}

TEST_P(TetElements, ForceIsTheTurnedStiffnessAndTheCouple) {
  TetRandom random(5);
  const RandomTet tet = random.tet(material());
  const NodeVectors rest = rest_points(tet.corners, order());
  const NodeVectors x = random.moved(NodeVectors(random.rotation() * rest), 0.1);
  const ElementStiffness k = rest_stiffness(tet.element.geometry, tet.elasticity, order());
  for (const RotationLaw law : {RotationLaw::kLeastEnergy, RotationLaw::kCorners}) {
    const TetShape shape = tet_shape(tet.element, tet.elasticity, law, x);
    const NodeVectors seen = shape.rotation.transpose() * x;
    NodeVectors expected = stiffness_times(k, seen - rest);
    // The couple acts on node I as -c x g_I, g_I the mean gradient of its polynomial.
    const NodeGradients g = node_gradients(tet.element.geometry, order(), SamplePoint{});
    expected -= cross_matrix(shape.couple) * g;
    expected = shape.rotation * expected;
    EXPECT_LE((tet_force(tet.element, shape) - expected).norm(), 1e-13 * expected.norm());
  }
}

TEST_P(TetElements, ExactTangentIsTheForcesDerivative) {
  TetRandom random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const RandomTet tet = random.tet(material());
    const NodeVectors x =
        random.moved(NodeVectors(random.rotation() * rest_points(tet.corners, order())), 0.1);
    NodeBlocks stiffness, blocks;
    pack_stiffness(rest_stiffness(tet.element.geometry, tet.elasticity, order()), stiffness);
    const TetShape shape = tet_shape(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, x);
    tet_tangent(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, shape, stiffness,
                {1.0, 0.0, TangentKind::kExact}, blocks);
    const NodeVectors direction = random.moved(NodeVectors::Zero(3, x.cols()), 1.0);
    NodeVectors product = NodeVectors::Zero(3, x.cols());
    for (Eigen::Index i = 0; i < x.cols(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        const Eigen::Matrix3d& block = blocks[node_block(i, j)];
        product.col(i) += block * direction.col(j);
        if (j < i) product.col(j) += block.transpose() * direction.col(i);
      }
    const double h = 1e-3;
    const auto at = [&](double s) {
      return force_at(tet, RotationLaw::kLeastEnergy, NodeVectors(x + s * direction));
    };
    const NodeVectors slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    // The differences' own error, as above; the force is less smooth than the energy.
    EXPECT_LE((slope - product).norm(), 1e-7 * product.norm());
  }
}

TEST_P(TetElements, TangentsAtRestAreTheStiffness) {
  TetRandom random(7);
  const RandomTet tet = random.tet(material());
  const NodeVectors rest = rest_points(tet.corners, order());
  NodeBlocks stiffness, blocks;
  const std::size_t count =
      pack_stiffness(rest_stiffness(tet.element.geometry, tet.elasticity, order()), stiffness);
  for (const TangentKind kind : {TangentKind::kFrozen, TangentKind::kExact}) {
    const TetShape shape = tet_shape(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, rest);
    // Damping's derivative by the velocity is beta K there, too.
    tet_tangent(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, shape, stiffness,
                {1.0, 0.5, kind}, blocks);
    for (std::size_t k = 0; k < count; ++k)
      EXPECT_LE((blocks[k] - 1.5 * stiffness[k]).norm(), 1e-13 * stiffness[0].norm());
  }
}

TEST_P(TetElements, DampingsTangentIsItsDerivativeByTheVelocity) {
  TetRandom random(8);
  const RandomTet tet = random.tet(material());
  const NodeVectors x =
      random.moved(NodeVectors(random.rotation() * rest_points(tet.corners, order())), 0.15);
  const NodeVectors v = random.moved(NodeVectors::Zero(3, x.cols()), 2.0);
  NodeBlocks stiffness, blocks;
  pack_stiffness(rest_stiffness(tet.element.geometry, tet.elasticity, order()), stiffness);
  const TetShape shape = tet_shape(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, x);
  tet_tangent(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, shape, stiffness,
              {0.0, 1.0, TangentKind::kExact}, blocks);
  NodeVectors product = NodeVectors::Zero(3, x.cols());
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      product.col(i) += blocks[node_block(i, j)] * v.col(j);
      if (j < i) product.col(j) += blocks[node_block(i, j)].transpose() * v.col(i);
    }
  const NodeVectors force =
      tet_damping_force(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, shape, v);
  EXPECT_LE((product - force).norm(), 1e-12 * force.norm());
  EXPECT_GE(force.cwiseProduct(v).sum(), 0.0);
  // The same shape, rotated as a rigid body, is not damped.
  NodeVectors spin = x;
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    spin.col(i) = Eigen::Vector3d(1, -2, 3).cross(Eigen::Vector3d(x.col(i)));
  EXPECT_LE(
      tet_damping_force(tet.element, tet.elasticity, RotationLaw::kLeastEnergy, shape, spin).norm(),
      1e-12 * force.norm());
}

TEST_P(TetElements, SmallStrainIsStVenantKirchhoffInTheLimit) {
  TetRandom random(9);
  const RandomTet tet = random.tet(material());
  const NodeVectors rest = rest_points(tet.corners, order());
  const NodeVectors u = random.moved(NodeVectors::Zero(3, rest.cols()), 1.0);
  const Eigen::Matrix3d turn = random.rotation();
  // StVK: F S(E) at eleven points, which integrate it exactly.
  const auto stvk = [&](const NodeVectors& x) {
    const GradientField field =
        gradient_field(tet.element.geometry, order(), [&](int i) { return x.col(i); });
    PiolaField piola(order());
    for (const SamplePoint& point : sample_points(order(), 4)) {
      const Eigen::Matrix3d f = field(point);
      const Eigen::Matrix3d green = 0.5 * (f.transpose() * f - Eigen::Matrix3d::Identity());
      piola.add(point,
                point.share * tet.element.geometry.volume * f * stress(tet.elasticity, green));
    }
    return NodeVectors(piola.forces(tet.element.geometry));
  };
  double before = 0.0;
  for (const double size : {1e-2, 5e-3, 2.5e-3}) {
    const NodeVectors x = turn * (rest + size * u);
    const NodeVectors expected = stvk(x);
    const double off =
        (force_at(tet, RotationLaw::kLeastEnergy, x) - expected).norm() / expected.norm();
    // They differ by a fraction of the order of the strain.
    EXPECT_LE(off, 20.0 * size);
    if (before > 0.0) {
      EXPECT_NEAR(before / off, 2.0, 0.3);
    }
    before = off;
  }
}

TEST(TetElement, AStraightQuadraticElementIsTheLinearOne) {
  TetRandom random(10);
  for (int trial = 0; trial < 20; ++trial) {
    const RandomTet tet = random.tet(kTetRubber);
    NodeVectors x(3, 4);
    for (int a = 0; a < 4; ++a) x.col(a) = tet.corners[a] + random.vector(0.3);
    std::array<Eigen::Vector3d, 4> corners;
    for (int a = 0; a < 4; ++a) corners[a] = x.col(a);
    const NodeVectors raised = rest_points(corners, 2);
    const double linear = energy_at(tet, RotationLaw::kLeastEnergy, x);
    EXPECT_NEAR(energy_at(tet, RotationLaw::kLeastEnergy, raised), linear, 1e-12 * linear);
    const NodeVectors force = force_at(tet, RotationLaw::kLeastEnergy, raised);
    NodeVectors folded = force.leftCols<4>();
    for (int e = 0; e < 6; ++e)
      for (const int a : kTetEdges[e]) folded.col(a) += 0.5 * force.col(4 + e);
    const NodeVectors expected = force_at(tet, RotationLaw::kLeastEnergy, x);
    EXPECT_LE((folded - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST_P(TetElements, FlatInvertedAndCollapsedElementsHaveFiniteForcesThatMendThem) {
  TetRandom random(11);
  const RandomTet tet = random.tet(material());
  const NodeVectors rest = rest_points(tet.corners, order());
  Eigen::Matrix3d mirror = Eigen::Vector3d(1, 1, -1).asDiagonal();
  Eigen::Matrix3d flat = Eigen::Vector3d(1, 1, 0).asDiagonal();
  Eigen::Matrix3d line = Eigen::Vector3d(1, 0, 0).asDiagonal();
  for (const Eigen::Matrix3d& map :
       {mirror, flat, line, Eigen::Matrix3d(Eigen::Matrix3d::Zero()),
        Eigen::Matrix3d(-Eigen::Matrix3d::Identity()), Eigen::Matrix3d(1e6 * mirror)}) {
    NodeVectors x = map * rest;
    for (const RotationLaw law : {RotationLaw::kLeastEnergy, RotationLaw::kCorners}) {
      TetShape shape = tet_shape(tet.element, tet.elasticity, law, x);
      EXPECT_TRUE(tet_force(tet.element, shape).allFinite());
      EXPECT_TRUE(tet_damping_force(tet.element, tet.elasticity, law, shape, x).allFinite());
      EXPECT_NEAR(shape.rotation.determinant(), 1.0, 1e-12);
      NodeBlocks stiffness, blocks;
      const std::size_t count =
          pack_stiffness(rest_stiffness(tet.element.geometry, tet.elasticity, order()), stiffness);
      tet_tangent(tet.element, tet.elasticity, law, shape, stiffness,
                  {1.0, 1.0, TangentKind::kExact}, blocks);
      for (std::size_t k = 0; k < count; ++k) EXPECT_TRUE(blocks[k].allFinite());
    }
    // Steepest descent, slower than the stiffest direction: the element returns to rest.
    x = random.moved(NodeVectors(std::min(1.0, 3.0 / (1.0 + map.norm())) * map * rest), 1e-3);
    const ElementStiffness k = rest_stiffness(tet.element.geometry, tet.elasticity, order());
    const double step = 0.5 / k.norm();
    for (int n = 0; n < 20000; ++n) x -= step * force_at(tet, RotationLaw::kLeastEnergy, x);
    EXPECT_LE(energy_at(tet, RotationLaw::kLeastEnergy, x), 1e-6 * tet.element.couple);
    const Eigen::Matrix3d f = x.leftCols<4>() * tet.element.geometry.gradients.transpose();
    EXPECT_GT(f.determinant(), 0.0);
  }
}

}  // namespace
}  // namespace tremolo
