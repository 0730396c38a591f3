#include "runtime/tets/solve/active_floats.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/clones.h"

namespace tremolo {
namespace {

using std::size_t;

typedef float Quad __attribute__((vector_size(16), may_alias));
typedef double QuadDoubles __attribute__((vector_size(32)));

constexpr size_t kQuads = kFloatBlock;

[[gnu::always_inline]] inline Quad& quad_at(float* list, size_t node) {
  return *reinterpret_cast<Quad*>(list + 4 * node);
}
[[gnu::always_inline]] inline Quad quad_of(const float* list, size_t node) {
  return *reinterpret_cast<const Quad*>(list + 4 * node);
}
[[gnu::always_inline]] inline Quad times_quad(const float* block, Quad x) {
  const Quad* column = reinterpret_cast<const Quad*>(block);
  return column[0] * x[0] + column[1] * x[1] + column[2] * x[2];
}

void put_block(const Eigen::Matrix3d& block, bool turned, float* at) {
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      at[4 * j + i] = static_cast<float>(turned ? block(j, i) : block(i, j));
}

struct FloatRows {
  size_t n;
  const std::uint32_t *first, *column;
  const float* blocks;
  const float* p;
  float* q;
};

TREMOLO_CLONES
void multiply_rows(const FloatRows& g) {
  for (size_t i = 0; i < g.n; ++i) {
    Quad even = {}, odd = {};
    const size_t end = g.first[i + 1];
    size_t k = g.first[i];
    for (; k + 1 < end; k += 2) {
      even += times_quad(g.blocks + kQuads * k, quad_of(g.p, g.column[k]));
      odd += times_quad(g.blocks + kQuads * (k + 1), quad_of(g.p, g.column[k + 1]));
    }
    if (k < end) even += times_quad(g.blocks + kQuads * k, quad_of(g.p, g.column[k]));
    quad_at(g.q, i) = even + odd;
  }
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
    quad_at(g.z, i) = times_quad(g.inverse + kQuads * i, r);
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
  const size_t nodes = pattern.size(), whole = 2 * pattern.blocks() - nodes;
  first_.reserve(nodes + 1);
  column_.reserve(whole);
  place_.reserve(whole);
  at_.assign(2 * pattern.blocks(), kNowhere);
  diagonal_.reserve(nodes);
  blocks_.assign(kQuads * whole, 0.0F);
  inverse_.assign(kQuads * nodes, 0.0F);
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
  first_.assign(n_ + 1, 0);
  for (const std::uint32_t node : nodes)
    for (size_t k = first[node]; k < first[node + 1]; ++k) {
      if (rank[columns[k]] == kNoRank) continue;
      ++first_[rank[node] + 1];
      if (columns[k] != node) ++first_[rank[columns[k]] + 1];
    }
  for (size_t i = 0; i < n_; ++i) first_[i + 1] += first_[i];
  column_.resize(first_[n_]);
  place_.resize(first_[n_]);
  // Filled from where each row begins, which is put back at the end.
  for (const std::uint32_t node : nodes)
    for (size_t k = first[node]; k < first[node + 1]; ++k) {
      const std::uint32_t row = rank[node], other = rank[columns[k]];
      if (other == kNoRank) continue;
      const std::uint32_t at = first_[row]++;
      column_[at] = other;
      place_[at] = static_cast<std::uint32_t>(2 * k);
      if (other == row) continue;
      const std::uint32_t turned = first_[other]++;
      column_[turned] = row;
      place_[turned] = static_cast<std::uint32_t>(2 * k + 1);
    }
  for (size_t i = n_; i > 0; --i) first_[i] = first_[i - 1];
  first_[0] = 0;
  std::fill(at_.begin(), at_.end(), kNowhere);
  for (size_t k = 0; k < place_.size(); ++k) at_[place_[k]] = static_cast<std::uint32_t>(k);
  diagonal_.resize(n_);
  for (size_t i = 0; i < n_; ++i) diagonal_[i] = at_[2 * pattern.diagonal(nodes[i])];
}

FloatTarget ActiveFloats::begin() {
  std::fill_n(blocks_.begin(), kQuads * place_.size(), 0.0F);
  return {blocks_.data(), at_.data()};
}

void ActiveFloats::take(const BlockMatrix& a) {
  for (size_t k = 0; k < place_.size(); ++k)
    put_block(a.block(place_[k] / 2), place_[k] % 2 != 0, blocks_.data() + kQuads * k);
}

Eigen::Matrix3d ActiveFloats::diagonal(std::uint32_t node) const {
  using Block = Eigen::Map<const Eigen::Matrix3f, 0, Eigen::OuterStride<4>>;
  return Block(blocks_.data() + kQuads * diagonal_[node]).cast<double>();
}

double ActiveFloats::start(const std::vector<Eigen::Matrix3d>& inverse,
                           const SmoothMatrix& smooth_inverse,
                           const std::vector<Eigen::Vector3d>& r) {
  smooth_inverse_ = smooth_inverse.cast<float>();
  for (size_t i = 0; i < n_; ++i) {
    put_block(inverse[i], false, inverse_.data() + kQuads * i);
    Eigen::Map<Eigen::Vector3f>(r_.data() + 4 * i) = r[i].cast<float>();
    quad_at(x_.data(), i) = quad_at(q_.data(), i) = quad_at(p_.data(), i) = Quad{};
  }
  const double product = advance(0.0).second;
  turn(0.0);
  return product;
}

void ActiveFloats::multiply() {
  multiply_rows({n_, first_.data(), column_.data(), blocks_.data(), p_.data(), q_.data()});
}

double ActiveFloats::curvature() const {
  return product_of(p_.data(), q_.data(), n_);
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
         (first_.capacity() + column_.capacity() + place_.capacity() + at_.capacity() +
          diagonal_.capacity()) *
             sizeof(std::uint32_t);
}

}  // namespace tremolo
