#include "runtime/bodies/reduced/frames/frame_inertia.h"

#include "common/packed_index.h"
#include "runtime/math/dense/small_matrices.h"

namespace tremolo {
namespace {

using Eigen::Index;

Eigen::Matrix3d matrix_at(const Eigen::MatrixXd& nine_rows, Index column) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      nine_rows.col(column).data());
}

// The axial vector of a matrix: epsilon_mkl M_kl.
Eigen::Vector3d axial(const Eigen::Matrix3d& m) {
  return {m(1, 2) - m(2, 1), m(2, 0) - m(0, 2), m(0, 1) - m(1, 0)};
}

}  // namespace

FrameInertia::FrameInertia(const InertiaIntegrals& integrals, const Eigen::Vector3d& about)
    : mass(integrals.mass),
      centre(about),
      first_moment(integrals.first_moment - integrals.mass * about),
      s(integrals.linear.topRows<3>()) {
  const Index r = integrals.linear.cols();
  const Eigen::Vector3d& moment = integrals.first_moment;
  P0 = integrals.second_moment - moment * centre.transpose() - centre * moment.transpose() +
       mass * centre * centre.transpose();
  a.resize(3, r);
  P_linear.resize(r, 6);
  pairs.setZero(tall_rows(9 * r), r);
  const Eigen::MatrixXd A = integrals.linear.bottomRows<9>();
  for (Index j = 0; j < r; ++j) {
    const Eigen::Matrix3d A_j = matrix_at(A, j) - centre * s.col(j).transpose();
    a.col(j) = axial(A_j);
    for (Index e = 0; e < 6; ++e) {
      const auto& [k, l] = kSymmetricEntries[e];
      P_linear(j, e) = A_j(k, l) + A_j(l, k);
    }
    for (Index i = 0; i <= j; ++i) {
      const auto pair = pair_index(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
      const Eigen::Matrix3d B = matrix_at(integrals.B, static_cast<Index>(pair));
      const Eigen::Vector3d c = axial(B);
      for (Index m = 0; m < 3; ++m) {
        pairs(m * r + i, j) = c[m];
        pairs(m * r + j, i) = -c[m];
      }
      for (Index e = 0; e < 6; ++e) {
        const auto& [k, l] = kSymmetricEntries[e];
        pairs((3 + e) * r + i, j) = pairs((3 + e) * r + j, i) = 0.5 * (B(k, l) + B(l, k));
      }
    }
  }
}

InertiaAt::InertiaAt(Index modes) : products(tall_rows(9 * modes)), C(3, modes) {
  products.setZero();
  C.setZero();
  J.setIdentity();
}

void InertiaAt::compute(const FrameInertia& inertia, const Eigen::VectorXd& q) {
  const Index r = q.size();
  multiply_tall(inertia.pairs, 9 * r, q, products);
  // (c_m q)_i = sum_j c_ij q_j, so C_j = sum_i q_i c_ij is its negative.
  for (Index m = 0; m < 3; ++m) C.row(m) = -products.segment(m * r, r).transpose();
  Eigen::Matrix3d P = inertia.P0;
  for (Index e = 0; e < 6; ++e) {
    const auto& [k, l] = kSymmetricEntries[e];
    P(k, l) += q.dot(inertia.P_linear.col(e) + products.segment((3 + e) * r, r));
    P(l, k) = P(k, l);
  }
  J = -P;
  J.diagonal().array() += P.trace();
}

}  // namespace tremolo
