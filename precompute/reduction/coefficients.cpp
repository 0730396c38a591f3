#include "precompute/reduction/coefficients.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/packed_index.h"
#include "common/parallel.h"
#include "precompute/fem/element_group.h"
#include "precompute/system/blas_threads.h"

extern "C" {
// BLAS, Fortran interface: C <- alpha A^T A + beta C on one triangle.
// NOLINTNEXTLINE(readability-identifier-naming)
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* beta, double* c, const int* ldc);
}

namespace tremolo {
namespace {

// The square root of an isotropic elasticity tensor: sqrt(2 mu) on deviators, sqrt(2 mu + 3 lambda)
// on the volumetric direction. On a strain in Mandel's notation (|v|^2 = E:E) it is shear * (v +
// spread * tr(E) (1,1,1,0,0,0)).
struct ElasticityRoot {
  double shear;
  double spread;

  explicit ElasticityRoot(const Elasticity& elasticity)
      : shear(std::sqrt(2.0 * elasticity.mu)),
        spread((std::sqrt(2.0 * elasticity.mu + 3.0 * elasticity.lambda) / shear - 1.0) / 3.0) {}
};

// Up to eight consecutive elements with the displacement gradient of each basis column, first its
// coefficients, then its value in one sample point; unused lanes are zero. root_volume: square root
// of the volume. scale: square root of the sample's weight, times shear if the material is uniform
// and isotropic. root: square root of each element's tensor, if it is not.
struct alignas(8 * kLanes) ElementGroup {
  std::vector<LaneGradient> coefficients;  // gradients_of_order() for each of r
  std::vector<LaneGradient> gradients;     // r
  Lanes root_volume;
  Lanes scale;
  Lanes root[6][6] = {};
};

void load_group(const Solid& solid, const BasisRows& basis, std::size_t first, std::size_t count,
                ElementGroup& group) {
  int elements[kLanes];
  group.root_volume = Lanes{};
  for (std::size_t lane = 0; lane < count; ++lane) {
    elements[lane] = static_cast<int>(first + lane);
    group.root_volume[lane] = std::sqrt(solid.elements[first + lane].volume);
  }
  load_gradients(solid, basis, elements, count, group.coefficients);
  if (solid.uniform()) return;
  for (std::size_t lane = 0; lane < count; ++lane) {
    const Matrix6& root = solid.elasticity(first + lane).root;
    for (int k = 0; k < 6; ++k)
      for (int l = k; l < 6; ++l) group.root[k][l][lane] = root(k, l);
  }
}

// Takes the gradients in one sample point.
TREMOLO_CLONES void load_point(int order, const SamplePoint& point, double shear,
                               ElementGroup& group) {
  group.scale = group.root_volume * (std::sqrt(std::abs(point.share)) * shear);
  const LaneGradient* coefficients = group.coefficients.data();
  for (std::size_t j = 0; j < group.gradients.size(); ++j) {
    if (order == 1)
      group.gradients[j] = coefficients[j];
    else
      gradient_at<2>(coefficients + 4 * j, point, group.gradients[j].at);
  }
}

// Computes the strains of all columns and calls put(column, xx, yy, zz, 2 yz, 2 xz, 2 xy).
template <class Put>
[[gnu::always_inline]] inline void strain_rows_with(const ElementGroup& group, const Put& put) {
  const std::size_t r = group.gradients.size();
  for (std::size_t j = 0; j < r; ++j) {
    Lanes h[9];
    for (std::size_t c = 0; c < 9; ++c) h[c] = group.scale * group.gradients[j].at[c];
    put(j, h[0], h[4], h[8], h[5] + h[7], h[2] + h[6], h[1] + h[3]);
    const std::size_t column = r + pair_index(0, j);
    for (std::size_t i = 0; i <= j; ++i) {
      if (i == j)
        for (Lanes& entry : h) entry *= 0.5;
      const Lanes* g = group.gradients[i].at;
      put(column + i, g[0] * h[0] + g[3] * h[3] + g[6] * h[6],
          g[1] * h[1] + g[4] * h[4] + g[7] * h[7], g[2] * h[2] + g[5] * h[5] + g[8] * h[8],
          (g[1] * h[2] + g[4] * h[5] + g[7] * h[8]) + (g[2] * h[1] + g[5] * h[4] + g[8] * h[7]),
          (g[0] * h[2] + g[3] * h[5] + g[6] * h[8]) + (g[2] * h[0] + g[5] * h[3] + g[8] * h[6]),
          (g[0] * h[1] + g[3] * h[4] + g[6] * h[7]) + (g[1] * h[0] + g[4] * h[3] + g[7] * h[6]));
    }
  }
}

// Writes six rows of B_e for each element of the group: 48 rows of all columns, `stride` apart,
// ordered by strain component, then by element.
TREMOLO_CLONES void strain_rows(const ElementGroup& group, const ElasticityRoot& root, double* rows,
                                std::size_t stride) {
  const double half_root2 = std::sqrt(0.5);
  const auto put = [&](std::size_t column, const Lanes& xx, const Lanes& yy, const Lanes& zz,
                       const Lanes& yz, const Lanes& xz, const Lanes& xy)
      __attribute__((always_inline)) {
    const Lanes mean = root.spread * (xx + yy + zz);
    auto* out = reinterpret_cast<Lanes*>(rows + column * stride);
    out[0] = xx + mean;
    out[1] = yy + mean;
    out[2] = zz + mean;
    out[3] = half_root2 * yz;  // Mandel: sqrt(2) times half of the argument
    out[4] = half_root2 * xz;
    out[5] = half_root2 * xy;
  };
  strain_rows_with(group, put);
}

TREMOLO_CLONES void general_strain_rows(const ElementGroup& group, double* rows,
                                        std::size_t stride) {
  const double half_root2 = std::sqrt(0.5);
  const auto put = [&](std::size_t column, const Lanes& xx, const Lanes& yy, const Lanes& zz,
                       const Lanes& yz, const Lanes& xz, const Lanes& xy)
      __attribute__((always_inline)) {
    const Lanes strain[6] = {xx, yy, zz, half_root2 * yz, half_root2 * xz, half_root2 * xy};
    auto* out = reinterpret_cast<Lanes*>(rows + column * stride);
    for (int k = 0; k < 6; ++k) {
      Lanes sum = group.root[k][k] * strain[k];
      for (int l = k + 1; l < 6; ++l) sum += group.root[k][l] * strain[l];
      out[k] = sum;
    }
  };
  strain_rows_with(group, put);
}

constexpr std::size_t kGroups = 8;  // samples of groups for each SYRK: their rows fit in the cache
// A stride that is a power of two would map columns to the same cache sets.
constexpr std::size_t kStride = 6 * kLanes * kGroups + kLanes;

// Rows of B that wait to be added to a Gram matrix, or, of samples with a negative share, to be
// subtracted from it.
class WaitingRows {
 public:
  WaitingRows(Eigen::MatrixXd& gram, double sign)
      : gram_(gram), sign_(sign), rows_(kStride / kLanes * static_cast<std::size_t>(gram.cols())) {}

  double* next() { return values() + 6 * kLanes * count_; }
  void keep() {
    if (++count_ == kGroups) flush();
  }
  void flush() {
    if (count_ == 0) return;
    const int columns = static_cast<int>(gram_.cols());
    const int depth = static_cast<int>(6 * kLanes * count_);
    const int stride = static_cast<int>(kStride);
    const double one = 1.0;
    dsyrk_("L", "T", &columns, &depth, &sign_, values(), &stride, &one, gram_.data(), &columns);
    count_ = 0;
  }

 private:
  double* values() { return reinterpret_cast<double*>(rows_.data()); }

  Eigen::MatrixXd& gram_;
  double sign_;
  std::vector<LaneBlock> rows_;
  std::size_t count_ = 0;
};

}  // namespace

Eigen::MatrixXd strain_gram(const Solid& solid, const BasisRows& basis, std::size_t first,
                            std::size_t last, unsigned threads) {
  constexpr std::size_t kParts =
      8;  // accumulators; a fixed number, so that the sum is reproducible
  const std::size_t r = basis.cols();
  const Eigen::Index columns = r + pair_count(r);
  const bool uniform = solid.uniform();
  const ElasticityRoot root(solid.elasticities.front());
  const BlasThreads single(1);  // we use threads outside of BLAS
  std::array<Eigen::MatrixXd, kParts> sums;
  parallel_for(kParts, threads, [&](std::size_t part) {
    const std::size_t begin = first + (last - first) * part / kParts;
    const std::size_t end = first + (last - first) * (part + 1) / kParts;
    sums[part].setZero(columns, columns);
    WaitingRows added(sums[part], 1.0), subtracted(sums[part], -1.0);
    ElementGroup group;
    group.coefficients.resize(r * gradients_of_order(solid.order()));
    group.gradients.resize(r);
    for (std::size_t e = begin; e < end; e += kLanes) {
      load_group(solid, basis, e, std::min(kLanes, end - e), group);
      for (const SamplePoint& point : sample_points(solid.order(), 4)) {
        load_point(solid.order(), point, uniform ? root.shear : 1.0, group);
        WaitingRows& rows = point.share > 0 ? added : subtracted;
        if (uniform)
          strain_rows(group, root, rows.next(), kStride);
        else
          general_strain_rows(group, rows.next(), kStride);
        rows.keep();
      }
    }
    added.flush();
    subtracted.flush();
  });
  for (std::size_t part = 1; part < kParts; ++part) sums[0] += sums[part];
  return std::move(sums[0]);
}

std::vector<double> packed_strain_gram(const Eigen::MatrixXd& gram, int r) {
  const std::size_t modes = r;
  std::vector<Eigen::Index> column(strain_terms(modes));  // of each term in `gram`
  for (std::size_t j = 0; j < modes; ++j) {
    column[strain_index(j)] = static_cast<Eigen::Index>(j);
    for (std::size_t i = 0; i <= j; ++i)
      column[strain_index(i, j)] = static_cast<Eigen::Index>(modes + pair_index(i, j));
  }
  std::vector<double> packed;
  packed.reserve(pair_count(column.size()));
  for (std::size_t b = 0; b < column.size(); ++b)
    for (std::size_t a = 0; a <= b; ++a)
      packed.push_back(gram(std::max(column[a], column[b]), std::min(column[a], column[b])));
  return packed;
}

Coefficients coefficients_from_gram(const Eigen::MatrixXd& gram, int r) {
  const std::size_t modes = r;
  const auto entry = [&gram](std::size_t a, std::size_t b) {
    return gram(static_cast<Eigen::Index>(std::max(a, b)),
                static_cast<Eigen::Index>(std::min(a, b)));
  };
  Coefficients c;
  c.quadratic = gram.topLeftCorner(r, r).selfadjointView<Eigen::Lower>();
  c.cubic.assign(triple_count(modes), 0.0);
  c.quartic.assign(quad_count(modes), 0.0);
  // 1/2 y^T G y: the linear-quadratic block appears twice, the quadratic block once with each
  // off-diagonal entry twice. The sums below are coefficients of monomials.
  for (std::size_t j = 0; j < modes; ++j)
    for (std::size_t i = 0; i <= j; ++i) {
      const std::size_t row = modes + pair_index(i, j);
      for (std::size_t a = 0; a < modes; ++a) c.cubic[triple_index_any(a, i, j)] += entry(row, a);
      for (std::size_t l = 0; l < modes; ++l)
        for (std::size_t k = 0; k <= l; ++k)
          c.quartic[quad_index_any(i, j, k, l)] += 0.5 * entry(row, modes + pair_index(k, l));
    }
  // A tensor entry is the coefficient of its monomial, divided by the number of orderings.
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
