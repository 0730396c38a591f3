#include "runtime/bodies/lanes/lane_segment.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "runtime/math/kernels/potential.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::random_vector;

template <class Real>
struct alignas(64) SegmentRow {
  Real value[kBodiesPerBlock<Real>];
};

template <class Real>
using SegmentRows = std::vector<SegmentRow<Real>>;

BasisData segment_basis(Index r) {
  return testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(r, 10.0, 1000.0), 0.3, 11));
}

// The mean of grad (C + Q) and its tangent in both passes, for bodies that differ in each lane.
template <class Real>
struct Passes {
  explicit Passes(const BasisData& basis, InstructionSet vectors)
      : r(static_cast<std::size_t>(basis.lambda.size())),
        lanes(make_lane_coefficients<Real>(r, basis.cubic, basis.quartic)),
        segment(make_segment_coefficients<Real>(lanes, basis.cubic, basis.quartic)),
        middle(r),
        half(r),
        mean(r),
        mean_alone(r),
        scratch(segment_scratch_rows(r)),
        tangent(pair_count(r)) {
    for (std::size_t lane = 0; lane < kBodiesPerBlock<Real>; ++lane) {
      const auto seed = static_cast<unsigned>(lane);
      q0.push_back(random_vector(static_cast<Index>(r), 0.3, 10 + seed));
      q1.push_back(q0.back() + random_vector(static_cast<Index>(r), 0.1, 90 + seed));
      for (std::size_t i = 0; i < r; ++i) {
        const auto row = static_cast<Index>(i);
        middle[i].value[lane] =
            static_cast<Real>(0.5 * (q0[lane][row] + q1[lane][row]) / lanes.coordinate_scale);
        half[i].value[lane] =
            static_cast<Real>(0.5 * (q1[lane][row] - q0[lane][row]) / lanes.coordinate_scale);
      }
    }
    evaluate_segment(segment, middle[0].value, half[0].value, scratch[0].value, mean[0].value,
                     tangent[0].value, vectors);
    evaluate_mean(segment, middle[0].value, half[0].value, scratch[0].value, mean_alone[0].value,
                  vectors);
  }

  std::size_t r;
  LaneCoefficients<Real> lanes;
  SegmentCoefficients<Real> segment;
  SegmentRows<Real> middle, half, mean, mean_alone, scratch, tangent;
  std::vector<VectorXd> q0, q1;
};

// Against the averaged gradient of one body, which has another kernel. The terms of a sum are of
// the size of the largest result; some r^3 of them are rounded.
template <class Real>
void expect_passes_agree(Index r, InstructionSet vectors) {
  const BasisData basis = segment_basis(r);
  const Passes<Real> passes(basis, vectors);
  const Potential potential =
      std::move(*Potential::create(basis.lambda, basis.cubic, basis.quartic));
  PotentialWorkspace workspace = potential.make_workspace(kUseAll);
  const double rounding = 300.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  const double force = passes.lanes.energy_scale / passes.lanes.coordinate_scale;
  for (std::size_t lane = 0; lane < kBodiesPerBlock<Real>; ++lane) {
    VectorXd G(r);
    MatrixXd K(r, r);
    potential.averaged_gradient(passes.q0[lane], passes.q1[lane], workspace, G, &K);
    const VectorXd middle = 0.5 * (passes.q0[lane] + passes.q1[lane]);
    G -= basis.lambda.cwiseProduct(middle);
    K.diagonal() -= basis.lambda;
    const double largest_G = G.cwiseAbs().maxCoeff(), largest_K = K.cwiseAbs().maxCoeff();
    for (Index j = 0; j < r; ++j) {
      const auto row = static_cast<std::size_t>(j);
      EXPECT_NEAR(force * static_cast<double>(passes.mean[row].value[lane]), G[j],
                  rounding * largest_G);
      EXPECT_NEAR(force * static_cast<double>(passes.mean_alone[row].value[lane]), G[j],
                  rounding * largest_G);
      for (Index i = 0; i <= j; ++i) {
        const std::size_t pair = pair_index(static_cast<std::size_t>(i), row);
        EXPECT_NEAR(force / passes.lanes.coordinate_scale *
                        static_cast<double>(passes.tangent[pair].value[lane]),
                    K(i, j), rounding * largest_K);
      }
    }
  }
}

std::vector<InstructionSet> sets_of_this_machine() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set :
       {InstructionSet::kPlain, InstructionSet::kAvx2, InstructionSet::kAvx512})
    if (set <= instruction_set()) sets.push_back(set);
  return sets;
}

TEST(LaneSegment, BothPassesGiveTheMeanAndTheTangentOfOneBody) {
  for (const InstructionSet set : sets_of_this_machine())
    for (const Index r : {1, 2, 3, 5, 9, 15, 20}) {
      expect_passes_agree<double>(r, set);
      expect_passes_agree<float>(r, set);
    }
}

}  // namespace
}  // namespace tremolo
