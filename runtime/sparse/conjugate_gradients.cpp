#include "runtime/sparse/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "common/clones.h"

namespace tremolo {
namespace {

using std::size_t;

typedef float Four __attribute__((vector_size(16), may_alias));
typedef float Eight __attribute__((vector_size(32), may_alias));
typedef double FourDoubles __attribute__((vector_size(32)));

constexpr size_t kBlock = 12;         // floats
constexpr size_t kPair = 2 * kBlock;  // two blocks, column by column side by side
constexpr size_t kPairColumn = 8;     // floats from a column of a pair to its next

// Floats resolve no more of a residual.
constexpr double kLeastInside = 1e-4;
// What conjugate gradients themselves say of a residual is true to floats' digits: it is not
// measured in doubles where no more than this share was asked for.
constexpr double kTrusted = 1e-3;

[[gnu::always_inline]] inline Four& four_at(float* list, size_t node) {
  return *reinterpret_cast<Four*>(list + 4 * node);
}

// A block times a vector.
[[gnu::always_inline]] inline Four block_times(const float* block, Four x) {
  const Four* column = reinterpret_cast<const Four*>(block);
  return column[0] * x[0] + column[1] * x[1] + column[2] * x[2];
}

// next: floats from a column to its next.
void store_block(const Eigen::Matrix3d& block, double scale, size_t next, float* at) {
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      at[next * static_cast<size_t>(j) + static_cast<size_t>(i)] =
          static_cast<float>(scale * block(i, j));
}

// A sum of products in doubles: one in floats loses digits as it grows.
[[gnu::always_inline]] inline void add_product(FourDoubles& sum, Four a, Four b) {
  sum += __builtin_convertvector(a * b, FourDoubles);
}
[[gnu::always_inline]] inline double total(const FourDoubles& sum) {
  return sum[0] + sum[1] + sum[2];
}

// What the loops below read and write; names as in the class.
struct CgView {
  size_t n;
  const std::uint32_t* first;
  const std::uint32_t* column;
  const float* blocks;
  const float* inverse;
  float *r, *z, *p, *q, *d;
};

// q = A p; returns p.q. Each column of a pair has a sum of its own, as one would wait for itself.
TREMOLO_CLONES
double multiply_direction(const CgView& g) {
  FourDoubles sum = {};
  for (size_t i = 0; i < g.n; ++i) {
    Eight first = {}, second = {}, third = {};
    for (size_t k = g.first[i]; k < g.first[i + 1]; ++k) {
      const Eight x = __builtin_shufflevector(
          four_at(g.p, g.column[2 * k]), four_at(g.p, g.column[2 * k + 1]), 0, 1, 2, 3, 4, 5, 6, 7);
      const Eight* columns = reinterpret_cast<const Eight*>(g.blocks + kPair * k);
      first += columns[0] * __builtin_shufflevector(x, x, 0, 0, 0, 0, 4, 4, 4, 4);
      second += columns[1] * __builtin_shufflevector(x, x, 1, 1, 1, 1, 5, 5, 5, 5);
      third += columns[2] * __builtin_shufflevector(x, x, 2, 2, 2, 2, 6, 6, 6, 6);
    }
    first += second + third;
    const Four product = __builtin_shufflevector(first, first, 0, 1, 2, 3) +
                         __builtin_shufflevector(first, first, 4, 5, 6, 7);
    four_at(g.q, i) = product;
    add_product(sum, four_at(g.p, i), product);
  }
  return total(sum);
}

// r.r and r.z.
struct CgSizes {
  double square = 0.0, product = 0.0;
};

// d += alpha p, r -= alpha q, z = the diagonal's inverse times r.
TREMOLO_CLONES
CgSizes advance_along(const CgView& g, float alpha) {
  FourDoubles square = {}, product = {};
  const Four step = Four{} + alpha;
  for (size_t i = 0; i < g.n; ++i) {
    four_at(g.d, i) += step * four_at(g.p, i);
    const Four r = four_at(g.r, i) - step * four_at(g.q, i);
    const Four z = block_times(g.inverse + kBlock * i, r);
    four_at(g.r, i) = r;
    four_at(g.z, i) = z;
    add_product(square, r, r);
    add_product(product, r, z);
  }
  return {total(square), total(product)};
}

// p = z + beta p.
TREMOLO_CLONES
void turn_direction(const CgView& g, float beta) {
  const Four share = Four{} + beta;
  for (size_t i = 0; i < g.n; ++i) four_at(g.p, i) = four_at(g.z, i) + share * four_at(g.p, i);
}

}  // namespace

ConjugateGradients::ConjugateGradients(const BlockPattern& pattern) : n_(pattern.size()) {
  const auto first = pattern.first();
  const auto columns = pattern.columns();
  std::vector<std::uint32_t> count(n_, 0);
  for (size_t i = 0; i < n_; ++i)
    for (size_t p = first[i]; p < first[i + 1]; ++p) {
      ++count[i];
      if (columns[p] != i) ++count[columns[p]];
    }
  first_.assign(n_ + 1, 0);
  for (size_t i = 0; i < n_; ++i) first_[i + 1] = first_[i] + (count[i] + 1) / 2;
  // The last one of an odd row is a block of zeros on the diagonal.
  column_.resize(2 * size_t{first_[n_]});
  for (size_t i = 0; i < n_; ++i)
    std::fill(column_.begin() + 2 * std::ptrdiff_t{first_[i]},
              column_.begin() + 2 * std::ptrdiff_t{first_[i + 1]}, static_cast<std::uint32_t>(i));
  place_.resize(pattern.blocks());
  turned_.resize(pattern.blocks());
  // Rows are filled in the order of their columns: first what is left of the diagonal.
  std::vector<std::uint32_t> next(n_);
  for (size_t i = 0; i < n_; ++i) next[i] = 2 * first_[i];
  for (size_t i = 0; i < n_; ++i)
    for (size_t p = first[i]; p < first[i + 1]; ++p) {
      const std::uint32_t j = columns[p];
      place_[p] = next[i]++;
      column_[place_[p]] = j;
      turned_[p] = place_[p];
      if (j == i) continue;
      turned_[p] = next[j]++;
      column_[turned_[p]] = static_cast<std::uint32_t>(i);
    }
  blocks_.assign(kBlock * column_.size(), 0.0F);
  inverse_.assign(kBlock * n_, 0.0F);
  for (AlignedFloats* list : {&r_, &z_, &p_, &q_, &d_}) list->assign(4 * n_, 0.0F);
  rest_ = image_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * n_));
}

// The matrix in floats. False where a diagonal block is not positive definite: the leading minors
// of one that is are.
bool ConjugateGradients::take(const BlockMatrix& a) {
  double largest = 0.0;
  for (size_t i = 0; i < n_; ++i) {
    const Eigen::Matrix3d& d = a.diagonal(i);
    const double determinant = d.determinant();
    if (!(d(0, 0) > 0.0 && d(0, 0) * d(1, 1) - d(1, 0) * d(0, 1) > 0.0 && determinant > 0.0 &&
          std::isfinite(determinant)))
      return false;
    largest = std::max(largest, d.diagonal().maxCoeff());
  }
  scale_ = 1.0 / largest;
  if (!(scale_ > 0.0 && std::isfinite(scale_))) return false;
  for (size_t i = 0; i < n_; ++i)
    store_block((scale_ * a.diagonal(i)).inverse(), 1.0, 4, inverse_.data() + kBlock * i);
  const auto slot = [this](std::uint32_t place) {
    return blocks_.data() + kPair * (place / 2) + 4 * (place % 2);
  };
  for (size_t p = 0; p < place_.size(); ++p) {
    store_block(a.block(p), scale_, kPairColumn, slot(place_[p]));
    if (turned_[p] != place_[p])
      store_block(a.block(p).transpose(), scale_, kPairColumn, slot(turned_[p]));
  }
  return true;
}

// d = A^-1 r nearly, until the residual is `tolerance` of what it was, from |r| = 1 on. Returns the
// residual; report.positive is false where the direction p_ has p.A p <= 0.
double ConjugateGradients::search(double tolerance, int most, CgReport& report) {
  const CgView view{n_,        first_.data(), column_.data(), blocks_.data(), inverse_.data(),
                    r_.data(), z_.data(),     p_.data(),      q_.data(),      d_.data()};
  for (AlignedFloats* list : {&d_, &p_, &q_}) std::fill(list->begin(), list->end(), 0.0F);
  double rz = advance_along(view, 0.0F).product, size = 1.0;
  turn_direction(view, 0.0F);
  while (size > tolerance && report.iterations < most) {
    ++report.iterations;
    const double curvature = multiply_direction(view);
    report.positive = curvature > 0.0;
    if (!report.positive) return size;
    const CgSizes next = advance_along(view, static_cast<float>(rz / curvature));
    size = std::sqrt(next.square);
    turn_direction(view, static_cast<float>(next.product / rz));
    rz = next.product;
  }
  return size;
}

// Whether p.A p > 0 in doubles: rounding in floats may say otherwise of a stiff matrix.
bool ConjugateGradients::is_positive(const BlockMatrix& a) {
  for (size_t i = 0; i < n_; ++i)
    for (size_t c = 0; c < 3; ++c)
      rest_[static_cast<Eigen::Index>(3 * i + c)] = static_cast<double>(p_[4 * i + c]);
  a.multiply(rest_, image_);
  return rest_.dot(image_) > 0.0;
}

CgReport ConjugateGradients::solve(const BlockMatrix& a, const Eigen::VectorXd& b,
                                   Eigen::VectorXd& x, double residual, int max_iterations) {
  CgReport report;
  if (!take(a)) {
    report.positive = false;
    return report;
  }
  for (double before = -1.0;; before = report.residual) {
    if (before < 0.0 && x.isZero(0.0)) {
      rest_ = b;
    } else {
      a.multiply(x, image_);
      rest_ = b - image_;
    }
    report.residual = rest_.norm();
    report.converged = report.residual <= residual;
    if (report.converged || report.iterations >= max_iterations) return report;
    // Rounding: another round would find nothing.
    if (!std::isfinite(report.residual) || (before >= 0.0 && report.residual > 0.5 * before))
      return report;
    for (size_t i = 0; i < n_; ++i)
      for (size_t c = 0; c < 3; ++c)
        r_[4 * i + c] =
            static_cast<float>(rest_[static_cast<Eigen::Index>(3 * i + c)] / report.residual);
    const double wanted = 0.9 * residual / report.residual;
    const double left = search(std::max(wanted, kLeastInside), max_iterations, report);
    const double back = scale_ * report.residual;
    for (size_t i = 0; i < n_; ++i)
      for (size_t c = 0; c < 3; ++c)
        x[static_cast<Eigen::Index>(3 * i + c)] += back * static_cast<double>(d_[4 * i + c]);
    if (!report.positive && !(report.positive = is_positive(a))) return report;
    if (wanted >= kTrusted && left <= wanted) {
      report.residual *= left;
      report.converged = true;
      return report;
    }
  }
}

}  // namespace tremolo
