#include "runtime/bodies/cloth/spring_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/processor.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::uint32_t kChunk = 64;
// Shorter runs do not get a chunk of their own.
constexpr std::uint32_t kShortestRun = 8;
// Replaces zero lengths and squared lengths: the numerator is then zero itself.
constexpr double kNoSquare = 1e-300;
constexpr double kNoLength = 1e-150;

using ChunkVectors = std::array<double, 3 * kChunk + 1>;  // x y z of each spring; one is not used
using ChunkNumbers = std::array<double, kChunk>;

struct SpringView {
  const std::uint32_t* a;
  const std::uint32_t* b;
  const double* rest;
  std::span<const SpringChunk> chunks;
  double k, d;
};

// The positions of each spring's blocks, same as BlockPattern::find().
struct SpringPlaces {
  const std::uint32_t* a;
  const std::uint32_t* b;
  const std::uint32_t* between;
};

// x_a - x_b.
[[gnu::always_inline]] inline void spring_differences(const SpringView& s, const SpringChunk& chunk,
                                                      const double* x, double* r) {
  if (chunk.run) {
    const double* xa = x + 3 * std::size_t{s.a[chunk.first]};
    const double* xb = x + 3 * std::size_t{s.b[chunk.first]};
    for (std::uint32_t j = 0; j < 3 * chunk.count; ++j) r[j] = xa[j] - xb[j];
    return;
  }
  for (std::uint32_t i = 0; i < chunk.count; ++i) {
    const double* xa = x + 3 * std::size_t{s.a[chunk.first + i]};
    const double* xb = x + 3 * std::size_t{s.b[chunk.first + i]};
    for (std::uint32_t c = 0; c < 3; ++c) r[3 * i + c] = xa[c] - xb[c];
  }
}

// f_a -= c r, f_b += c r; r is overwritten.
[[gnu::always_inline]] inline void spring_pulls(const SpringView& s, const SpringChunk& chunk,
                                                const double* c, double* r, double* f) {
  for (std::uint32_t i = 0; i < chunk.count; ++i)
    for (std::uint32_t k = 0; k < 3; ++k) r[3 * i + k] *= c[i];
  if (chunk.run) {
    // Two springs may have the same particles: first one end, then the other.
    double* fa = f + 3 * std::size_t{s.a[chunk.first]};
    double* fb = f + 3 * std::size_t{s.b[chunk.first]};
    for (std::uint32_t j = 0; j < 3 * chunk.count; ++j) fa[j] -= r[j];
    for (std::uint32_t j = 0; j < 3 * chunk.count; ++j) fb[j] += r[j];
    return;
  }
  for (std::uint32_t i = 0; i < chunk.count; ++i) {
    double* fa = f + 3 * std::size_t{s.a[chunk.first + i]};
    double* fb = f + 3 * std::size_t{s.b[chunk.first + i]};
    for (std::uint32_t k = 0; k < 3; ++k) {
      fa[k] -= r[3 * i + k];
      fb[k] += r[3 * i + k];
    }
  }
}

[[gnu::always_inline]] inline void spring_squares(const double* r, const double* w,
                                                  std::uint32_t count, double* squares) {
  for (std::uint32_t i = 0; i < count; ++i)
    squares[i] = r[3 * i] * w[3 * i] + r[3 * i + 1] * w[3 * i + 1] + r[3 * i + 2] * w[3 * i + 2];
}

// Computes for each spring of the chunk: r = xa - xb (m), c so that the force on a is -c r (N/m),
// and 1/|r|^2.
[[gnu::always_inline]] inline void spring_factors(const SpringView& s, const SpringChunk& chunk,
                                                  const double* x, const double* v, ChunkVectors& r,
                                                  ChunkNumbers& c, ChunkNumbers& squares) {
  const double* rest = s.rest + chunk.first;
  spring_differences(s, chunk, x, r.data());
  spring_squares(r.data(), r.data(), chunk.count, squares.data());
  for (std::uint32_t i = 0; i < chunk.count; ++i) {
    const double square = squares[i] > kNoSquare ? squares[i] : kNoSquare;
    // One division gives both: 1/l is l/l^2.
    squares[i] = 1.0 / square;
    c[i] = s.k * (1.0 - rest[i] * std::sqrt(square) * squares[i]);
  }
  if (s.d == 0.0) return;
  ChunkVectors w;
  ChunkNumbers speeds;
  spring_differences(s, chunk, v, w.data());
  spring_squares(r.data(), w.data(), chunk.count, speeds.data());
  for (std::uint32_t i = 0; i < chunk.count; ++i) c[i] += s.d * speeds[i] * squares[i];
}

TREMOLO_CLONES
void spring_forces(const SpringView& s, const double* x, const double* v, double* f) {
  ChunkVectors r;
  ChunkNumbers squares, c;
  for (const SpringChunk& chunk : s.chunks) {
    spring_factors(s, chunk, x, v, r, c, squares);
    spring_pulls(s, chunk, c.data(), r.data(), f);
  }
}

TREMOLO_CLONES
double spring_step_forces(const SpringView& s, const double* x0, const double* x1, double h,
                          double* f) {
  ChunkVectors r0, r1;
  ChunkNumbers squares0, squares1, middle, c;
  double damped = 0.0;
  for (const SpringChunk& chunk : s.chunks) {
    const double* rest = s.rest + chunk.first;
    spring_differences(s, chunk, x0, r0.data());
    spring_differences(s, chunk, x1, r1.data());
    spring_squares(r0.data(), r0.data(), chunk.count, squares0.data());
    spring_squares(r1.data(), r1.data(), chunk.count, squares1.data());
    for (std::uint32_t j = 0; j < 3 * chunk.count; ++j) {
      const double change = r1[j] - r0[j];
      r0[j] += r1[j];
      r1[j] = change;
    }
    for (std::uint32_t i = 0; i < chunk.count; ++i) {
      double both = std::sqrt(squares0[i]) + std::sqrt(squares1[i]);
      both = both > kNoLength ? both : kNoLength;
      c[i] = 0.5 * s.k * (1.0 - 2.0 * rest[i] / both);
    }
    if (s.d != 0.0) {
      spring_squares(r0.data(), r0.data(), chunk.count, middle.data());
      spring_squares(r0.data(), r1.data(), chunk.count, squares0.data());
      for (std::uint32_t i = 0; i < chunk.count; ++i) {
        const double square = middle[i] > kNoSquare ? middle[i] : kNoSquare;
        const double pull = s.d / h * squares0[i] / square;
        c[i] += pull;
        damped += pull * squares0[i];
      }
    }
    spring_pulls(s, chunk, c.data(), r0.data(), f);
  }
  return damped;
}

// A sum of numbers that arrive chunk by chunk.
double sum_of(const ChunkNumbers& sums) {
  double total = 0.0;
  for (const double sum : sums) total += sum;
  return total;
}

TREMOLO_CLONES
double spring_energies(const SpringView& s, const double* x) {
  ChunkVectors r;
  ChunkNumbers squares, sums{};
  for (const SpringChunk& chunk : s.chunks) {
    const double* rest = s.rest + chunk.first;
    spring_differences(s, chunk, x, r.data());
    spring_squares(r.data(), r.data(), chunk.count, squares.data());
    for (std::uint32_t i = 0; i < chunk.count; ++i) {
      const double stretch = std::sqrt(squares[i]) - rest[i];
      sums[i] += stretch * stretch;
    }
  }
  return 0.5 * s.k * sum_of(sums);
}

TREMOLO_CLONES
double spring_damping(const SpringView& s, const double* x, const double* v) {
  ChunkVectors r, w;
  ChunkNumbers squares, speeds, sums{};
  for (const SpringChunk& chunk : s.chunks) {
    spring_differences(s, chunk, x, r.data());
    spring_differences(s, chunk, v, w.data());
    spring_squares(r.data(), r.data(), chunk.count, squares.data());
    spring_squares(r.data(), w.data(), chunk.count, speeds.data());
    for (std::uint32_t i = 0; i < chunk.count; ++i) {
      const double square = squares[i] > kNoSquare ? squares[i] : kNoSquare;
      sums[i] += speeds[i] * speeds[i] / square;
    }
  }
  return s.d * sum_of(sums);
}

// Divides the springs into chunks, at the ends of runs where these are long.
std::vector<SpringChunk> spring_chunks(std::span<const std::uint32_t> a,
                                       std::span<const std::uint32_t> b) {
  std::vector<SpringChunk> chunks;
  const auto n = static_cast<std::uint32_t>(a.size());
  for (std::uint32_t first = 0; first < n;) {
    std::uint32_t end = first + 1;
    while (end < n && a[end] == a[end - 1] + 1 && b[end] == b[end - 1] + 1) ++end;
    const bool run = end - first >= kShortestRun;
    if (run) {
      for (; first < end; first += kChunk)
        chunks.push_back({first, std::min(kChunk, end - first), true});
    } else if (!chunks.empty() && !chunks.back().run &&
               chunks.back().count + end - first <= kChunk) {
      chunks.back().count += end - first;
    } else {
      chunks.push_back({first, end - first, false});
    }
    first = end;
  }
  // Chunks near each other in memory are then used soon after each other.
  std::stable_sort(
      chunks.begin(), chunks.end(),
      [a](const SpringChunk& one, const SpringChunk& two) { return a[one.first] < a[two.first]; });
  return chunks;
}

}  // namespace

SpringSet::SpringSet(const ClothSprings& springs) : law_(springs.law) {
  // A kind without a law has no springs.
  if (law_.stiffness == 0.0 && law_.damping == 0.0) return;
  for (const NodePair& pair : springs.pairs) {
    a_.push_back(pair.first);
    b_.push_back(pair.second);
  }
  rest_ = springs.rest;
  chunks_ = spring_chunks(a_, b_);
}

void SpringSet::find_places(const BlockPattern& pattern) {
  place_a_.clear(), place_b_.clear(), place_ab_.clear();
  for (std::size_t i = 0; i < size(); ++i) {
    place_a_.push_back(static_cast<std::uint32_t>(pattern.diagonal(a_[i])));
    place_b_.push_back(static_cast<std::uint32_t>(pattern.diagonal(b_[i])));
    place_ab_.push_back(static_cast<std::uint32_t>(pattern.find(a_[i], b_[i])));
  }
}

void SpringSet::add_force(const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                          Eigen::VectorXd& f) const {
  const SpringView view{a_.data(), b_.data(), rest_.data(), chunks_, law_.stiffness, law_.damping};
  spring_forces(view, x.data(), v.data(), f.data());
}

double SpringSet::add_step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                 Eigen::VectorXd& f) const {
  const SpringView view{a_.data(), b_.data(), rest_.data(), chunks_, law_.stiffness, law_.damping};
  return spring_step_forces(view, x0.data(), x1.data(), h, f.data());
}

namespace {

// The numbers of a block except its last, at any address.
typedef double BlockNumbers __attribute__((vector_size(64), aligned(8), may_alias));

// across I + along r r^T.
struct SpringBlock {
  BlockNumbers numbers;
  double last;
};

// r: four numbers; the last may have any value.
[[gnu::always_inline]] inline SpringBlock spring_block(const double* r, double across,
                                                       double along) {
  typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
  const Four e = *reinterpret_cast<const Four*>(r);
  const BlockNumbers column = __builtin_shufflevector(e, e, 0, 0, 0, 1, 1, 1, 2, 2);
  const BlockNumbers row = __builtin_shufflevector(e, e, 0, 1, 2, 0, 1, 2, 0, 1);
  const BlockNumbers one = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
  // In this form it is symmetric to the last bit.
  return {along * (column * row) + across * one, along * (r[2] * r[2]) + across};
}

// The block of spring i: added at its particles' diagonal blocks, subtracted between them.
[[gnu::always_inline]] inline void add_spring_block(const SpringPlaces& places, std::size_t i,
                                                    const SpringBlock& block, double* blocks) {
  double* a = blocks + 9 * std::size_t{places.a[i]};
  double* b = blocks + 9 * std::size_t{places.b[i]};
  double* between = blocks + 9 * std::size_t{places.between[i]};
  *reinterpret_cast<BlockNumbers*>(a) += block.numbers;
  a[8] += block.last;
  *reinterpret_cast<BlockNumbers*>(b) += block.numbers;
  b[8] += block.last;
  *reinterpret_cast<BlockNumbers*>(between) -= block.numbers;
  between[8] -= block.last;
}

TREMOLO_CLONES
void add_spring_tangents(const SpringView& s, const SpringPlaces& places, const double* x,
                         const double* v, const SpringWeights& weights, double* blocks) {
  ChunkVectors r;
  r.back() = 0.0;
  ChunkNumbers squares, across;
  for (const SpringChunk& chunk : s.chunks) {
    spring_factors(s, chunk, x, v, r, across, squares);
    for (std::uint32_t i = 0; i < chunk.count; ++i) {
      const double aside =
          weights.position * (across[i] > 0.0 ? across[i] : weights.share * across[i]);
      const double along = (weights.position * s.k + weights.velocity * s.d - aside) * squares[i];
      add_spring_block(places, chunk.first + i, spring_block(r.data() + 3 * i, aside, along),
                       blocks);
    }
  }
}

}  // namespace

void SpringSet::add_block(std::size_t spring, const Matrix3d& block, BlockMatrix& a) const {
  a.block(place_a_[spring]) += block;
  a.block(place_b_[spring]) += block;
  a.block(place_ab_[spring]) -= block;
}

std::size_t SpringSet::add_tangent(const SpringPart& part, const Eigen::VectorXd& x,
                                   const Eigen::VectorXd& v, const SpringWeights& weights,
                                   BlockMatrix& a) const {
  std::size_t end = part.chunk;
  while (end < chunks_.size() && a_[chunks_[end].first] < part.particle) ++end;
  const std::span<const SpringChunk> chunks(chunks_.data() + part.chunk, end - part.chunk);
  const SpringView view{a_.data(), b_.data(), rest_.data(), chunks, law_.stiffness, law_.damping};
  if (!chunks.empty())
    add_spring_tangents(view, {place_a_.data(), place_b_.data(), place_ab_.data()}, x.data(),
                        v.data(), weights, a.block(0).data());
  return end;
}

double SpringSet::energy(const Eigen::VectorXd& x) const {
  const SpringView view{a_.data(), b_.data(), rest_.data(), chunks_, law_.stiffness, law_.damping};
  return spring_energies(view, x.data());
}

double SpringSet::damping_power(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const {
  if (law_.damping == 0.0) return 0.0;
  const SpringView view{a_.data(), b_.data(), rest_.data(), chunks_, law_.stiffness, law_.damping};
  return spring_damping(view, x.data(), v.data());
}

// With s = l0 + l1, -df_a/dx1_a = k/2 [(1 - 2 L/s) I + 2 L/s^2 m e1^T] + d/h u u^T and terms of the
// damper's direction. The symmetric part of u e1^T is (1 + u.e1)/2 q q^T - (1 - u.e1)/2 p p^T, q
// along u + e1.
void SpringSet::add_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                 double share, BlockMatrix& a) const {
  const double k = law_.stiffness, d = law_.damping;
  for (std::size_t i = 0; i < size(); ++i) {
    const Vector3d r0 = between(x0, i), r1 = between(x1, i);
    const double l1 = std::max(r1.norm(), kNoLength);
    const double both = std::max(r0.norm() + l1, kNoLength);
    const Vector3d m = r0 + r1;
    const double length = std::max(m.norm(), kNoLength);
    const Vector3d u = m / length, e1 = r1 / l1;
    const Vector3d q = u + e1;
    const double slack = 0.5 * k * (1.0 - 2.0 * rest_[i] / both);
    const double across = slack > 0.0 ? slack : share * slack;
    // (1 + u.e1)/2 = |q|^2/4, so that q need not be normalized.
    const double along = 0.25 * k * rest_[i] * length / (both * both);
    Matrix3d block = (along * q) * q.transpose();
    block -= (share * along * (u - e1)) * (u - e1).transpose();
    if (d != 0.0) block += (d / h * u) * u.transpose();
    block.diagonal().array() += across;
    add_block(i, block, a);
  }
}

void SpringSet::add_missing_product(const VectorXd& x, const VectorXd& v, double position,
                                    const VectorXd& u, VectorXd& y) const {
  if (law_.damping == 0.0) return;
  for (std::size_t i = 0; i < size(); ++i) {
    const Vector3d r = between(x, i), w = between(v, i);
    const double square = std::max(r.squaredNorm(), kNoSquare);
    const Vector3d aside = w - (w.dot(r) / square) * r;
    const Vector3d change = (position * law_.damping / square * aside.dot(between(u, i))) * r;
    y.segment<3>(3 * a_[i]) += change;
    y.segment<3>(3 * b_[i]) -= change;
  }
}

// The force on a is -c m with c = k/2 (1 - 2 L/s) + (d/h) m.w/|m|^2 and w = r1 - r0. Missing are
// the part of m (dc/dr1)^T that is not symmetric, and all of the damper's but u u^T.
void SpringSet::add_missing_step_product(const VectorXd& x0, const VectorXd& x1, double h,
                                         const VectorXd& u, VectorXd& y) const {
  for (std::size_t i = 0; i < size(); ++i) {
    const Vector3d r0 = between(x0, i), r1 = between(x1, i), way = between(u, i);
    const double l1 = std::max(r1.norm(), kNoLength);
    const double both = std::max(r0.norm() + l1, kNoLength);
    const Vector3d m = r0 + r1, w = r1 - r0, e1 = r1 / l1;
    const double square = std::max(m.squaredNorm(), kNoSquare);
    const double turn = 0.5 * law_.stiffness * rest_[i] / (both * both);
    const double along = m.dot(w) / square, over = m.dot(way) / square;
    Vector3d change = turn * (e1.dot(way) * m - m.dot(way) * e1);
    change +=
        (law_.damping / h) * (along * (way - over * m) + ((w - along * m).dot(way) / square) * m);
    y.segment<3>(3 * a_[i]) += change;
    y.segment<3>(3 * b_[i]) -= change;
  }
}

}  // namespace tremolo
