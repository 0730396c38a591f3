// A matrix added up in single precision against the one in double precision.
#include <gtest/gtest.h>

#include "runtime/bodies/tets/solve/active_floats.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using namespace testing;

using FloatView = Eigen::Map<const Eigen::Matrix3f, 0, Eigen::OuterStride<kColumnStride>>;

Material gel_with_a_grain() {
  OrthotropicElasticity grain;
  grain.young = {1.1e5, 0.9e5, 1.6e5};
  grain.poisson = {0.3, 0.25, 0.2};
  grain.shear = {0.4e5, 0.5e5, 0.3e5};
  Material material = testing::kTetGel;
  material.orthotropic = grain;
  return material;
}

class FloatBlocks : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(IsotropicAndNot, FloatBlocks, ::testing::Bool());

TEST_P(FloatBlocks, TheMatrixIsThatOfDoubles) {
  TetRandom random(21);
  const TetModelPointer model = tet_bar({3, 2, 1}, {0.3, 0.15, 0.1}, true,
                                        GetParam() ? testing::kTetGel : gel_with_a_grain());
  TetSystem system(model, RotationLaw::kLeastEnergy);
  BlockMatrix matrix(model->pattern());
  ActiveFloats floats(*model->pattern(), model->smooth());
  for (const TangentKind kind : {TangentKind::kFrozen, TangentKind::kExact})
    for (const double linear : {0.0, 0.5, 1.0}) {
      std::vector<std::uint8_t> degrees(model->edges());
      for (std::uint8_t& degree : degrees) degree = random.between(0.0, 1.0) < linear ? 1 : 2;
      system.set_degrees(degrees);
      Eigen::VectorXd x = model->rest() + random_state(random, model->rest().size(), 4e-3);
      system.follow_ends(x);
      system.evaluate(x);
      const TetMatrixFactors factors{300.0, {1.0, 0.2, kind}};
      system.assemble(factors, matrix);
      std::vector<std::uint32_t> nodes, rank(model->nodes(), ActiveFloats::kNoRank);
      for (std::uint32_t i = 0; i < model->nodes(); ++i)
        if (system.active()[i] != 0) {
          rank[i] = static_cast<std::uint32_t>(nodes.size());
          nodes.push_back(i);
        }
      floats.choose(*model->pattern(), nodes, rank);
      // Twice: the second begins from zero again.
      FloatTarget target;
      for (int turn = 0; turn < 2; ++turn) {
        target = floats.begin();
        system.assemble(factors, target);
      }
      double largest = 0.0;
      for (const std::uint32_t i : nodes)
        largest = std::max(largest, matrix.diagonal(i).cwiseAbs().maxCoeff());
      std::size_t compared = 0;
      for (std::size_t i = 0; i < model->nodes(); ++i)
        for (std::size_t k = model->pattern()->first()[i]; k < model->pattern()->first()[i + 1];
             ++k) {
          const std::size_t j = model->pattern()->columns()[k];
          const bool wanted = system.active()[i] != 0 && system.active()[j] != 0;
          ASSERT_EQ(target.at[k] != kNowhere, wanted);
          if (!wanted) continue;
          ++compared;
          const Eigen::Matrix3f own = FloatView(target.blocks + first_float(target.at[k]));
          // Sums of some twenty roundings of floats.
          EXPECT_LT((own.cast<double>() - matrix.block(k)).cwiseAbs().maxCoeff(), 1e-6 * largest);
        }
      EXPECT_GT(compared, nodes.size());
      for (std::uint32_t i = 0; i < nodes.size(); ++i)
        EXPECT_LT((floats.diagonal(i) - matrix.diagonal(nodes[i])).cwiseAbs().maxCoeff(),
                  1e-6 * largest);
    }
}

}  // namespace
}  // namespace tremolo
