#include "precompute/coefficients.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/packed_index.h"
#include "common/parallel.h"
#include "precompute/blas_threads.h"

extern "C" {
// BLAS, Fortran interface: C <- alpha A^T A + beta C on one triangle.
// NOLINTNEXTLINE(readability-identifier-naming)
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* beta, double* c, const int* ldc);
}

namespace tremolo {
namespace {

using Mandel = Eigen::Matrix<double, 6, 1>;

// |mandel(E)|^2 = E:E.
Mandel mandel(const Eigen::Matrix3d& e) {
  const double root2 = std::sqrt(2.0);
  Mandel v;
  v << e(0, 0), e(1, 1), e(2, 2), root2 * e(1, 2), root2 * e(0, 2), root2 * e(0, 1);
  return v;
}

// The square root of the isotropic elasticity tensor: sqrt(2 mu) on deviators, sqrt(2 mu +
// 3 lambda) on the volumetric direction.
struct ElasticityRoot {
  double shear;
  double volumetric_excess;  // acts along (1,1,1,0,0,0)/3 times the trace

  explicit ElasticityRoot(const Material& material)
      : shear(std::sqrt(2.0 * lame_mu(material))),
        volumetric_excess(std::sqrt(2.0 * lame_mu(material) + 3.0 * lame_lambda(material)) -
                          shear) {}

  Mandel operator()(const Mandel& strain) const {
    Mandel result = shear * strain;
    result.head<3>().array() += volumetric_excess * strain.head<3>().sum() / 3.0;
    return result;
  }
};

// Six rows of B_e into `rows` (stride `stride` between columns).
void strain_rows(const Solid& solid, const BasisRows& basis, const ElasticityRoot& root,
                 std::size_t element, std::vector<Eigen::Matrix3d>& gradients, double* rows,
                 Eigen::Index stride) {
  const auto r = static_cast<std::size_t>(basis.cols());
  const StrainSample& sample = solid.samples[element];
  const Tetrahedron& tet = solid.mesh.tetrahedra[element];
  for (std::size_t i = 0; i < r; ++i) {
    gradients[i].setZero();
    for (int a = 0; a < 4; ++a)
      gradients[i] += basis.block<3, 1>(3 * Eigen::Index{tet[a]}, static_cast<Eigen::Index>(i)) *
                      sample.gradients.col(a).transpose();
  }
  const double weight = std::sqrt(sample.weight);
  const auto put = [&](std::size_t column, const Eigen::Matrix3d& strain) {
    Eigen::Map<Mandel>(rows + static_cast<Eigen::Index>(column) * stride) =
        weight * root(mandel(strain));
  };
  for (std::size_t j = 0; j < r; ++j) {
    put(j, 0.5 * (gradients[j] + gradients[j].transpose()));
    for (std::size_t i = 0; i <= j; ++i) {
      const Eigen::Matrix3d product = gradients[i].transpose() * gradients[j];
      put(r + pair_index(i, j),
          i == j ? Eigen::Matrix3d(0.5 * product) : 0.5 * (product + product.transpose()));
    }
  }
}

}  // namespace

Eigen::MatrixXd strain_gram(const Solid& solid, const BasisRows& basis, std::size_t first,
                            std::size_t last, unsigned threads) {
  constexpr std::size_t kLanes = 8;    // accumulators: fixed, so that the sum is
  constexpr std::size_t kBatch = 128;  // elements a SYRK: rows enough to be near peak
  const auto r = static_cast<std::size_t>(basis.cols());
  const auto columns = static_cast<int>(r + pair_count(r));
  const ElasticityRoot root(solid.material);
  const BlasThreads single(1);  // our threads are outside: BLAS's would fight them
  std::array<Eigen::MatrixXd, kLanes> sums;
  parallel_for(kLanes, threads, [&](std::size_t lane) {
    const std::size_t begin = first + (last - first) * lane / kLanes;
    const std::size_t end = first + (last - first) * (lane + 1) / kLanes;
    sums[lane].setZero(columns, columns);
    Eigen::MatrixXd rows(6 * kBatch, columns);
    std::vector<Eigen::Matrix3d> gradients(r);
    for (std::size_t e = begin; e < end; e += kBatch) {
      const std::size_t count = std::min(kBatch, end - e);
      for (std::size_t i = 0; i < count; ++i)
        strain_rows(solid, basis, root, e + i, gradients, rows.data() + 6 * i, rows.rows());
      const int depth = static_cast<int>(6 * count);
      const int stride = static_cast<int>(rows.rows());
      const double one = 1.0;
      dsyrk_("L", "T", &columns, &depth, &one, rows.data(), &stride, &one, sums[lane].data(),
             &columns);
    }
  });
  for (std::size_t lane = 1; lane < kLanes; ++lane) sums[0] += sums[lane];
  return std::move(sums[0]);
}

Coefficients coefficients_from_gram(const Eigen::MatrixXd& gram, int r) {
  const auto modes = static_cast<std::size_t>(r);
  const auto entry = [&gram](std::size_t a, std::size_t b) {
    return gram(static_cast<Eigen::Index>(std::max(a, b)),
                static_cast<Eigen::Index>(std::min(a, b)));
  };
  Coefficients c;
  c.quadratic = gram.topLeftCorner(r, r).selfadjointView<Eigen::Lower>();
  c.cubic.assign(triple_count(modes), 0.0);
  c.quartic.assign(quad_count(modes), 0.0);
  // 1/2 y^T G y: the linear-quadratic block appears twice, the quadratic block once off its
  // diagonal twice. What is summed here are coefficients of monomials.
  for (std::size_t j = 0; j < modes; ++j)
    for (std::size_t i = 0; i <= j; ++i) {
      const std::size_t row = modes + pair_index(i, j);
      for (std::size_t a = 0; a < modes; ++a) c.cubic[triple_index_any(a, i, j)] += entry(row, a);
      for (std::size_t l = 0; l < modes; ++l)
        for (std::size_t k = 0; k <= l; ++k)
          c.quartic[quad_index_any(i, j, k, l)] += 0.5 * entry(row, modes + pair_index(k, l));
    }
  // A tensor entry is its monomial's coefficient shared among the orderings.
  for (std::size_t k = 0; k < modes; ++k)
    for (std::size_t j = 0; j <= k; ++j)
      for (std::size_t i = 0; i <= j; ++i) {
        c.cubic[triple_index(i, j, k)] /= orderings(i, j, k);
        for (std::size_t l = k; l < modes; ++l)
          c.quartic[quad_index(i, j, k, l)] /= orderings(i, j, k, l);
      }
  return c;
}

}  // namespace tremolo
