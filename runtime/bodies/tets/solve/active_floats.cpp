#include "runtime/bodies/tets/solve/active_floats.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/processor.h"

namespace tremolo {
namespace {

using std::size_t;

typedef float Quad __attribute__((vector_size(16), may_alias));
typedef double QuadDoubles __attribute__((vector_size(32)));

typedef float Sixteen __attribute__((vector_size(64), may_alias));

constexpr size_t kInverse = 12;  // three columns of four floats

[[gnu::always_inline]] inline Quad& quad_at(float* list, size_t node) {
  return *reinterpret_cast<Quad*>(list + 4 * node);
}
[[gnu::always_inline]] inline Quad quad_of(const float* list, size_t node) {
  return *reinterpret_cast<const Quad*>(list + 4 * node);
}
// stride: of the columns, in vectors of four.
[[gnu::always_inline]] inline Quad times_quad(const float* block, size_t stride, Quad x) {
  const Quad* column = reinterpret_cast<const Quad*>(block);
  return column[0] * x[0] + column[stride] * x[1] + column[2 * stride] * x[2];
}
[[gnu::always_inline]] inline Sixteen four_of(Quad a, Quad b, Quad c, Quad d) {
  using Eight = float __attribute__((vector_size(32)));
  const Eight low = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  const Eight high = __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}
// The vectors of four are (a0, b0, a1, b1) and (a2, b2, a3, b3).
[[gnu::always_inline]] inline Sixteen low_pairs(Sixteen a, Sixteen b) {
  return __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
}
[[gnu::always_inline]] inline Sixteen high_pairs(Sixteen a, Sixteen b) {
  return __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
}
// Each vector of four: the sums of a, of b and of c.
[[gnu::always_inline]] inline Sixteen sums_of_quads(Sixteen a, Sixteen b, Sixteen c) {
  const Sixteen zero = {};
  const Sixteen ab = low_pairs(a, b) + high_pairs(a, b);
  const Sixteen cz = low_pairs(c, zero) + high_pairs(c, zero);
  return __builtin_shufflevector(ab, cz, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29) +
         __builtin_shufflevector(ab, cz, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30,
                                 31);
}

void put_block(const Eigen::Matrix3d& block, size_t stride, float* at) {
  for (size_t j = 0; j < 3; ++j)
    for (size_t i = 0; i < 3; ++i)
      at[stride * j + i] =
          static_cast<float>(block(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
}

size_t whole_groups(size_t blocks) {
  return (blocks + kGroupBlocks - 1) / kGroupBlocks * kGroupBlocks;
}

struct FloatRows {
  size_t n;
  const std::uint32_t *first, *column;
  const float *diagonal, *rows;
  const float* p;
  float* q;
};

// q = A p and p.q, to which both triangles contribute equally. Rows are ascending: a block's
// transpose adds to a row that has been set.
TREMOLO_CLONES
double multiply_rows(const FloatRows& g) {
  QuadDoubles product = {};
  for (size_t i = 0; i < g.n; ++i) {
    const Quad own = quad_of(g.p, i);
    const Sixteen owns = four_of(own, own, own, own);
    Sixteen sum = {};
    for (size_t k = g.first[i]; k < g.first[i + 1]; k += kGroupBlocks) {
      const std::uint32_t* at = g.column + k;
      const Sixteen* block = reinterpret_cast<const Sixteen*>(g.rows + first_float(k));
      const Sixteen p = four_of(quad_of(g.p, at[0]), quad_of(g.p, at[1]), quad_of(g.p, at[2]),
                                quad_of(g.p, at[3]));
      sum += block[0] *
             __builtin_shufflevector(p, p, 0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12);
      sum += block[1] *
             __builtin_shufflevector(p, p, 1, 1, 1, 1, 5, 5, 5, 5, 9, 9, 9, 9, 13, 13, 13, 13);
      sum += block[2] *
             __builtin_shufflevector(p, p, 2, 2, 2, 2, 6, 6, 6, 6, 10, 10, 10, 10, 14, 14, 14, 14);
      const Sixteen turned = sums_of_quads(block[0] * owns, block[1] * owns, block[2] * owns);
      quad_at(g.q, at[0]) += __builtin_shufflevector(turned, turned, 0, 1, 2, 3);
      quad_at(g.q, at[1]) += __builtin_shufflevector(turned, turned, 4, 5, 6, 7);
      quad_at(g.q, at[2]) += __builtin_shufflevector(turned, turned, 8, 9, 10, 11);
      quad_at(g.q, at[3]) += __builtin_shufflevector(turned, turned, 12, 13, 14, 15);
    }
    const Quad lower = __builtin_shufflevector(sum, sum, 0, 1, 2, 3) +
                       __builtin_shufflevector(sum, sum, 4, 5, 6, 7);
    const Quad upper = __builtin_shufflevector(sum, sum, 8, 9, 10, 11) +
                       __builtin_shufflevector(sum, sum, 12, 13, 14, 15);
    const Quad diagonal = times_quad(g.diagonal + first_float(i), kGroupBlocks, own);
    const Quad below = lower + upper;
    quad_at(g.q, i) = diagonal + below;
    product += __builtin_convertvector(own * (diagonal + 2.0F * below), QuadDoubles);
  }
  return product[0] + product[1] + product[2];
}

TREMOLO_CLONES
double product_of(const float* a, const float* b, size_t n) {
  QuadDoubles sum = {};
  for (size_t i = 0; i < n; ++i)
    sum += __builtin_convertvector(quad_of(a, i) * quad_of(b, i), QuadDoubles);
  return sum[0] + sum[1] + sum[2];
}

struct FloatVectors {
  size_t n;
  const float *inverse, *p, *q;
  float *x, *r, *z;
  const SmoothFields* fields;
  float* image;  // Z^T r
};

TREMOLO_CLONES
void advance_rows(const FloatVectors& g, float length) {
  const Quad step = Quad{} + length;
  Quad image[kSmoothFields] = {};
  for (size_t i = 0; i < g.n; ++i) {
    quad_at(g.x, i) += step * quad_of(g.p, i);
    const Quad r = quad_of(g.r, i) - step * quad_of(g.q, i);
    quad_at(g.r, i) = r;
    quad_at(g.z, i) = times_quad(g.inverse + kInverse * i, 1, r);
    for (size_t k = 0; k < kSmoothFields; ++k) image[k] += g.fields[i][k] * r;
  }
  for (size_t k = 0; k < kSmoothFields; ++k) quad_at(g.image, k) = image[k];
}

// p = z + Z s + share p.
TREMOLO_CLONES
void turn_rows(float* p, const float* z, const SmoothFields* fields, const float* smooth,
               float share, size_t n) {
  const Quad part = Quad{} + share;
  Quad s[kSmoothFields];
  for (size_t k = 0; k < kSmoothFields; ++k) s[k] = quad_of(smooth, k);
  for (size_t i = 0; i < n; ++i) {
    Quad sum = quad_of(z, i) + part * quad_of(p, i);
    for (size_t k = 0; k < kSmoothFields; ++k) sum += fields[i][k] * s[k];
    quad_at(p, i) = sum;
  }
}

}  // namespace

ActiveFloats::ActiveFloats(const BlockPattern& pattern, std::shared_ptr<const SmoothSpace> smooth)
    : smooth_(std::move(smooth)) {
  const size_t nodes = pattern.size();
  size_t most = whole_groups(nodes);
  for (size_t i = 0; i < nodes; ++i)
    most += whole_groups(pattern.first()[i + 1] - pattern.first()[i] - 1);
  first_.reserve(nodes + 1);
  column_.reserve(most);
  at_.assign(pattern.blocks(), kNowhere);
  blocks_.assign(first_float(most), 0.0F);
  inverse_.assign(kInverse * nodes, 0.0F);
  for (AlignedFloats* list : {&x_, &r_, &z_, &p_, &q_}) list->assign(4 * nodes, 0.0F);
  fields_.reserve(nodes);
  smooth_part_.assign(std::size_t{4} * kSmoothFields, 0.0F);
}

void ActiveFloats::choose(const BlockPattern& pattern, std::span<const std::uint32_t> nodes,
                          std::span<const std::uint32_t> rank) {
  n_ = nodes.size();
  fields_.clear();
  for (const std::uint32_t node : nodes) fields_.push_back(smooth_->at[node]);
  const auto first = pattern.first();
  const auto columns = pattern.columns();
  const size_t diagonal = whole_groups(n_);
  std::fill(at_.begin(), at_.end(), kNowhere);
  first_.clear();
  column_.clear();
  for (const std::uint32_t node : nodes) {
    const std::uint32_t row = rank[node];
    first_.push_back(static_cast<std::uint32_t>(column_.size()));
    for (size_t k = first[node]; k + 1 < first[node + 1]; ++k) {
      if (rank[columns[k]] == kNoRank) continue;
      at_[k] = static_cast<std::uint32_t>(diagonal + column_.size());
      column_.push_back(rank[columns[k]]);
    }
    // Blocks of zeros; their images are added to the row itself before it is set.
    column_.resize(whole_groups(column_.size()), row);
    at_[pattern.diagonal(node)] = row;
  }
  first_.push_back(static_cast<std::uint32_t>(column_.size()));
}

FloatTarget ActiveFloats::begin() {
  std::fill_n(blocks_.begin(), first_float(whole_groups(n_) + column_.size()), 0.0F);
  return {blocks_.data(), at_.data()};
}

void ActiveFloats::take(const BlockMatrix& a) {
  begin();
  for (size_t k = 0; k < at_.size(); ++k)
    if (at_[k] != kNowhere)
      put_block(a.block(k), kColumnStride, blocks_.data() + first_float(at_[k]));
}

Eigen::Matrix3d ActiveFloats::diagonal(std::uint32_t node) const {
  using Block = Eigen::Map<const Eigen::Matrix3f, 0, Eigen::OuterStride<kColumnStride>>;
  return Block(blocks_.data() + first_float(node)).cast<double>();
}

double ActiveFloats::start(const std::vector<Eigen::Matrix3d>& inverse,
                           const SmoothMatrix& smooth_inverse,
                           const std::vector<Eigen::Vector3d>& r) {
  smooth_inverse_ = smooth_inverse.cast<float>();
  for (size_t i = 0; i < n_; ++i) {
    put_block(inverse[i], 4, inverse_.data() + kInverse * i);
    Eigen::Map<Eigen::Vector3f>(r_.data() + 4 * i) = r[i].cast<float>();
    quad_at(x_.data(), i) = quad_at(q_.data(), i) = quad_at(p_.data(), i) = Quad{};
  }
  const double product = advance(0.0).second;
  turn(0.0);
  return product;
}

double ActiveFloats::multiply() {
  return multiply_rows({n_, first_.data(), column_.data(), blocks_.data(),
                        blocks_.data() + first_float(whole_groups(n_)), p_.data(), q_.data()});
}

std::pair<double, double> ActiveFloats::advance(double length) {
  advance_rows({n_, inverse_.data(), p_.data(), q_.data(), x_.data(), r_.data(), z_.data(),
                fields_.data(), smooth_part_.data()},
               static_cast<float>(length));
  using Columns = Eigen::Map<Eigen::Matrix<float, 3, kSmoothFields>, 0, Eigen::OuterStride<4>>;
  Columns part(smooth_part_.data());
  Eigen::Matrix<float, 3, kSmoothFields> image = part;
  const Eigen::Matrix<float, kSmoothModes, 1> found = smooth_inverse_ * image.reshaped();
  part = found.reshaped(3, kSmoothFields);
  return {product_of(r_.data(), r_.data(), n_),
          product_of(r_.data(), z_.data(), n_) + static_cast<double>(image.reshaped().dot(found))};
}

void ActiveFloats::turn(double share) {
  turn_rows(p_.data(), z_.data(), fields_.data(), smooth_part_.data(), static_cast<float>(share),
            n_);
}

void ActiveFloats::add_image(std::uint32_t node, const Eigen::Vector3d& value) {
  Eigen::Map<Eigen::Vector3f>(q_.data() + size_t{4} * node) += value.cast<float>();
}

std::size_t ActiveFloats::bytes() const {
  return (blocks_.size() + inverse_.size() + 5 * x_.size()) * sizeof(float) +
         fields_.capacity() * sizeof(SmoothFields) + sizeof(smooth_inverse_) +
         (first_.capacity() + column_.capacity() + at_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace tremolo
