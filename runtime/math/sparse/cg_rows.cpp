#include <algorithm>
#include <cstdint>
#include <vector>

#include <Eigen/LU>

#include "common/processor.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/sparse/conjugate_gradients.h"

namespace tremolo {
namespace {

using std::size_t;

typedef float Four __attribute__((vector_size(16), may_alias));
typedef float Eight __attribute__((vector_size(32), may_alias));
typedef double FourDoubles __attribute__((vector_size(32)));

constexpr size_t kBlock = 12;         // floats
constexpr size_t kPair = 2 * kBlock;  // two blocks, column by column side by side
constexpr size_t kPairColumn = 8;     // floats from a column of a pair to its next

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

// Input and output of the loops below; names as in the class.
struct CgView {
  size_t n;
  const std::uint32_t* first;
  const std::uint32_t* column;
  const float* blocks;
  const float* inverse;
  float *r, *z, *p, *q, *d;
};

// q = A p; returns p.q. Each column of a pair has a sum of its own, because one sum would wait for
// itself.
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

class CgRows : public CgStorage {
 public:
  explicit CgRows(const BlockPattern& pattern);
  void take(const BlockMatrix& a, double scale) override;
  void start(const Eigen::VectorXd& b, double scale) override;
  double multiply() override { return multiply_direction(view()); }
  CgSizes advance(float alpha) override { return advance_along(view(), alpha); }
  void turn(float beta) override { turn_direction(view(), beta); }
  void add_found(double scale, Eigen::VectorXd& x) const override;
  void copy_direction(Eigen::VectorXd& x) const override;

 private:
  CgView view() {
    return {n_,        first_.data(), column_.data(), blocks_.data(), inverse_.data(),
            r_.data(), z_.data(),     p_.data(),      q_.data(),      d_.data()};
  }

  size_t n_ = 0;
  // Rows of the whole matrix, in pairs of blocks; position of each stored block and of its
  // transpose.
  std::vector<std::uint32_t> first_, column_, place_, turned_;
  // Blocks, three columns of four floats each, those of a pair side by side; the diagonal's
  // inverses, each by itself.
  AlignedFloats blocks_, inverse_;
  // Four floats a node: r, r preconditioned, the direction, A p, d.
  AlignedFloats r_, z_, p_, q_, d_;
};

CgRows::CgRows(const BlockPattern& pattern) : n_(pattern.size()) {
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
  // Rows are filled in the order of their columns: first the blocks left of the diagonal.
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
}

void CgRows::take(const BlockMatrix& a, double scale) {
  for (size_t i = 0; i < n_; ++i)
    store_block((scale * a.diagonal(i)).inverse(), 1.0, 4, inverse_.data() + kBlock * i);
  const auto slot = [this](std::uint32_t place) {
    return blocks_.data() + kPair * (place / 2) + 4 * (place % 2);
  };
  for (size_t p = 0; p < place_.size(); ++p) {
    store_block(a.block(p), scale, kPairColumn, slot(place_[p]));
    if (turned_[p] != place_[p])
      store_block(a.block(p).transpose(), scale, kPairColumn, slot(turned_[p]));
  }
}

void CgRows::start(const Eigen::VectorXd& b, double scale) {
  for (size_t i = 0; i < n_; ++i)
    for (size_t c = 0; c < 3; ++c) r_[4 * i + c] = static_cast<float>(b[3 * i + c] * scale);
  for (AlignedFloats* list : {&d_, &p_, &q_}) std::fill(list->begin(), list->end(), 0.0F);
}

void CgRows::add_found(double scale, Eigen::VectorXd& x) const {
  for (size_t i = 0; i < n_; ++i)
    for (size_t c = 0; c < 3; ++c) x[3 * i + c] += scale * static_cast<double>(d_[4 * i + c]);
}

void CgRows::copy_direction(Eigen::VectorXd& x) const {
  for (size_t i = 0; i < n_; ++i)
    for (size_t c = 0; c < 3; ++c) x[3 * i + c] = static_cast<double>(p_[4 * i + c]);
}

}  // namespace

std::unique_ptr<CgStorage> make_cg_rows(const BlockPattern& pattern) {
  return std::make_unique<CgRows>(pattern);
}

}  // namespace tremolo
