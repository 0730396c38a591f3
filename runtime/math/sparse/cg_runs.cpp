#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "common/processor.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/sparse/conjugate_gradients.h"

namespace tremolo {
namespace {

constexpr std::size_t kRunLanes = 16;
// A symmetric block is six of its nine numbers.
constexpr std::size_t kWhole = 9 * kRunLanes, kHalf = 6 * kRunLanes;  // floats of sixteen blocks
// Below this fraction of lanes with a block, rows are faster.
constexpr double kLeastFilled = 0.5;

// Sixteen floats, at any address.
typedef float RunVector __attribute__((vector_size(64), aligned(4), may_alias));
typedef double RunDoubles __attribute__((vector_size(64)));
typedef float RunOctet __attribute__((vector_size(32)));

// Blocks (row + l, column + l) of lanes l; those that are not stored are zeros.
struct BlockRun {
  std::uint32_t row = 0, column = 0;
};

// Vectors: x of all nodes, then y, then z, `stride` floats apart, followed by zeros. whole: nine
// numbers, column by column, of each run's lanes; diagonal, inverse: xx yx zx yy zy zz of the lanes
// of sixteen nodes.
struct RunView {
  std::size_t stride;
  std::size_t count;  // of runs
  const BlockRun* runs;
  const float* blocks;
  const float* diagonal;
  const float* inverse;
  float *r, *z, *p, *q, *d;
};

[[gnu::always_inline]] inline RunVector& run_at(float* list, std::size_t place) {
  return *reinterpret_cast<RunVector*>(list + place);
}
[[gnu::always_inline]] inline const RunVector& run_at(const float* list, std::size_t place) {
  return *reinterpret_cast<const RunVector*>(list + place);
}

// A symmetric block's product, of lanes: half is their place.
[[gnu::always_inline]] inline void half_times(const float* half, const RunVector (&x)[3],
                                              RunVector (&y)[3]) {
  const RunVector xx = run_at(half, 0), yx = run_at(half, kRunLanes),
                  zx = run_at(half, 2 * kRunLanes), yy = run_at(half, 3 * kRunLanes),
                  zy = run_at(half, 4 * kRunLanes), zz = run_at(half, 5 * kRunLanes);
  y[0] = xx * x[0] + yx * x[1] + zx * x[2];
  y[1] = yx * x[0] + yy * x[1] + zy * x[2];
  y[2] = zx * x[0] + zy * x[1] + zz * x[2];
}

// Sums of products of floats in doubles: one in floats loses digits as it grows.
[[gnu::always_inline]] inline void add_run_product(RunDoubles& sum, const RunVector& product) {
  const RunOctet low = __builtin_shufflevector(product, product, 0, 1, 2, 3, 4, 5, 6, 7);
  const RunOctet high = __builtin_shufflevector(product, product, 8, 9, 10, 11, 12, 13, 14, 15);
  sum += __builtin_convertvector(low, RunDoubles) + __builtin_convertvector(high, RunDoubles);
}
[[gnu::always_inline]] inline double run_total(const RunDoubles& sum) {
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

// y += B x of a run's upper triangle, and z = B^T w of its lower one.
[[gnu::always_inline]] inline void whole_times(const float* whole, const RunVector (&x)[3],
                                               const RunVector (&w)[3], RunVector (&y)[3],
                                               RunVector (&z)[3]) {
  for (std::size_t c = 0; c < 3; ++c) {
    const RunVector b0 = run_at(whole, (3 * c) * kRunLanes),
                    b1 = run_at(whole, (3 * c + 1) * kRunLanes),
                    b2 = run_at(whole, (3 * c + 2) * kRunLanes);
    y[0] += b0 * x[c];
    y[1] += b1 * x[c];
    y[2] += b2 * x[c];
    z[c] = b0 * w[0] + b1 * w[1] + b2 * w[2];
  }
}

[[gnu::always_inline]] inline void load_run(const float* list, std::size_t stride, std::size_t node,
                                            RunVector (&x)[3]) {
  for (std::size_t c = 0; c < 3; ++c) x[c] = run_at(list, c * stride + node);
}

// q = A p; returns p.q. The triangles of a run are applied one after the other, because their nodes
// may be the same.
template <bool kSymmetric>
[[gnu::always_inline]] inline double multiply_by_runs(const RunView& g) {
  const std::size_t s = g.stride;
  for (std::size_t i = 0; i < s; i += kRunLanes) {
    RunVector x[3], y[3];
    load_run(g.p, s, i, x);
    half_times(g.diagonal + 6 * i, x, y);
    for (std::size_t c = 0; c < 3; ++c) run_at(g.q, c * s + i) = y[c];
  }
  for (std::size_t k = 0; k < g.count; ++k) {
    const std::size_t row = g.runs[k].row, column = g.runs[k].column;
    RunVector xi[3], xj[3], yi[3], yj[3];
    load_run(g.p, s, row, xi);
    load_run(g.p, s, column, xj);
    if constexpr (kSymmetric) {
      half_times(g.blocks + kHalf * k, xj, yi);
      half_times(g.blocks + kHalf * k, xi, yj);
    } else {
      yi[0] = yi[1] = yi[2] = RunVector{};
      whole_times(g.blocks + kWhole * k, xj, xi, yi, yj);
    }
    for (std::size_t c = 0; c < 3; ++c) run_at(g.q, c * s + row) += yi[c];
    for (std::size_t c = 0; c < 3; ++c) run_at(g.q, c * s + column) += yj[c];
  }
  RunDoubles sum = {};
  for (std::size_t i = 0; i < 3 * s; i += kRunLanes)
    add_run_product(sum, run_at(g.p, i) * run_at(g.q, i));
  return run_total(sum);
}

TREMOLO_CLONES
double multiply_runs(const RunView& g) {
  return multiply_by_runs<false>(g);
}
TREMOLO_CLONES
double multiply_symmetric_runs(const RunView& g) {
  return multiply_by_runs<true>(g);
}

TREMOLO_CLONES
CgSizes advance_runs(const RunView& g, float alpha) {
  const std::size_t s = g.stride;
  RunDoubles square = {}, product = {};
  for (std::size_t i = 0; i < s; i += kRunLanes) {
    RunVector r[3], z[3];
    RunVector squares = {}, products = {};
    for (std::size_t c = 0; c < 3; ++c) {
      run_at(g.d, c * s + i) += alpha * run_at(g.p, c * s + i);
      r[c] = run_at(g.r, c * s + i) - alpha * run_at(g.q, c * s + i);
      run_at(g.r, c * s + i) = r[c];
    }
    half_times(g.inverse + 6 * i, r, z);
    for (std::size_t c = 0; c < 3; ++c) {
      run_at(g.z, c * s + i) = z[c];
      squares += r[c] * r[c];
      products += r[c] * z[c];
    }
    add_run_product(square, squares);
    add_run_product(product, products);
  }
  return {run_total(square), run_total(product)};
}

TREMOLO_CLONES
void turn_runs(const RunView& g, float beta) {
  for (std::size_t i = 0; i < 3 * g.stride; i += kRunLanes)
    run_at(g.p, i) = run_at(g.z, i) + beta * run_at(g.p, i);
}

class CgRuns : public CgStorage {
 public:
  explicit CgRuns(const BlockPattern& pattern);
  // The fraction of lanes that have a block.
  double filled() const { return filled_; }
  void take(const BlockMatrix& a, double scale) override;
  void start(const Eigen::VectorXd& b, double scale) override;
  double multiply() override {
    return symmetric_ ? multiply_symmetric_runs(view()) : multiply_runs(view());
  }
  CgSizes advance(float alpha) override { return advance_runs(view(), alpha); }
  void turn(float beta) override { turn_runs(view(), beta); }
  void add_found(double scale, Eigen::VectorXd& x) const override;
  void copy_direction(Eigen::VectorXd& x) const override;

 private:
  static constexpr std::uint32_t kNoBlock = static_cast<std::uint32_t>(-1);

  bool take_symmetric(const BlockMatrix& a, double scale);
  void take_any(const BlockMatrix& a, double scale);
  RunView view() {
    return {stride_,          runs_.size(),    runs_.data(), blocks_.data(),
            diagonal_.data(), inverse_.data(), r_.data(),    z_.data(),
            p_.data(),        q_.data(),       d_.data()};
  }

  std::size_t n_ = 0, stride_ = 0;
  double filled_ = 1.0;
  bool symmetric_ = true;  // until a block off the diagonal is not
  std::vector<BlockRun> runs_;
  std::vector<std::array<std::uint32_t, kRunLanes>> place_;  // of each lane's block
  AlignedFloats blocks_, diagonal_, inverse_;
  AlignedFloats r_, z_, p_, q_, d_;
};

CgRuns::CgRuns(const BlockPattern& pattern) : n_(pattern.size()) {
  using Block = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // off, row, place
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t p = pattern.first()[i]; p + 1 < pattern.first()[i + 1]; ++p)
      blocks.emplace_back(static_cast<std::uint32_t>(i) - pattern.columns()[p],
                          static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(p));
  std::sort(blocks.begin(), blocks.end());
  std::vector<std::pair<BlockRun, std::array<std::uint32_t, kRunLanes>>> found;
  std::uint32_t begin_off = 0;
  for (const auto& [off, row, place] : blocks) {
    if (found.empty() || off != begin_off || row - found.back().first.row >= kRunLanes) {
      found.push_back({{row, row - off}, {}});
      found.back().second.fill(kNoBlock);
      begin_off = off;
    }
    found.back().second[row - found.back().first.row] = place;
  }
  // Rows in their order keep accesses to memory near each other.
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first.row < b.first.row; });
  for (const auto& [run, places] : found) {
    runs_.push_back(run);
    place_.push_back(places);
  }
  if (!runs_.empty())
    filled_ = static_cast<double>(blocks.size()) / static_cast<double>(kRunLanes * runs_.size());
  if (filled_ < kLeastFilled) return;
  // A run's lanes may begin at the last node.
  stride_ = (n_ + 2 * kRunLanes - 1) / kRunLanes * kRunLanes;
  blocks_.assign(kWhole * runs_.size(), 0.0F);
  diagonal_.assign(6 * stride_, 0.0F);
  inverse_.assign(6 * stride_, 0.0F);
  for (AlignedFloats* list : {&r_, &z_, &p_, &q_, &d_}) list->assign(3 * stride_, 0.0F);
}

// Columns of the lower triangle of a block into a lane.
void store_half(const Eigen::Matrix3d& m, double scale, float* at) {
  std::size_t k = 0;
  for (int j = 0; j < 3; ++j)
    for (int i = j; i < 3; ++i) at[kRunLanes * k++] = static_cast<float>(scale * m(i, j));
}

// Rounds to the resolution of floats.
bool is_symmetric(const Eigen::Matrix3d& m) {
  const double off =
      std::abs(m(1, 0) - m(0, 1)) + std::abs(m(2, 0) - m(0, 2)) + std::abs(m(2, 1) - m(1, 2));
  return off <= 1e-7 * m.diagonal().cwiseAbs().sum();
}

void CgRuns::take(const BlockMatrix& a, double scale) {
  for (std::size_t i = 0; i < n_; ++i) {
    const std::size_t at = kHalf * (i / kRunLanes) + i % kRunLanes;
    const Eigen::Matrix3d block = scale * a.diagonal(i);
    store_half(block, 1.0, diagonal_.data() + at);
    store_half(block.inverse(), 1.0, inverse_.data() + at);
  }
  symmetric_ = symmetric_ && take_symmetric(a, scale);
  if (!symmetric_) take_any(a, scale);
}

bool CgRuns::take_symmetric(const BlockMatrix& a, double scale) {
  for (std::size_t k = 0; k < runs_.size(); ++k)
    for (std::size_t l = 0; l < kRunLanes; ++l) {
      if (place_[k][l] == kNoBlock) continue;
      const Eigen::Matrix3d& block = a.block(place_[k][l]);
      if (!is_symmetric(block)) {
        std::fill(blocks_.begin(), blocks_.end(), 0.0F);
        return false;
      }
      store_half(block, scale, blocks_.data() + kHalf * k + l);
    }
  return true;
}

void CgRuns::take_any(const BlockMatrix& a, double scale) {
  for (std::size_t k = 0; k < runs_.size(); ++k)
    for (std::size_t l = 0; l < kRunLanes; ++l) {
      if (place_[k][l] == kNoBlock) continue;
      const double* from = a.block(place_[k][l]).data();
      float* to = blocks_.data() + kWhole * k + l;
      for (std::size_t m = 0; m < 9; ++m) to[kRunLanes * m] = static_cast<float>(scale * from[m]);
    }
}

void CgRuns::start(const Eigen::VectorXd& b, double scale) {
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      r_[c * stride_ + i] = static_cast<float>(b[3 * i + c] * scale);
  for (AlignedFloats* list : {&d_, &p_, &q_}) std::fill(list->begin(), list->end(), 0.0F);
}

void CgRuns::add_found(double scale, Eigen::VectorXd& x) const {
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      x[3 * i + c] += scale * static_cast<double>(d_[c * stride_ + i]);
}

void CgRuns::copy_direction(Eigen::VectorXd& x) const {
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t c = 0; c < 3; ++c) x[3 * i + c] = static_cast<double>(p_[c * stride_ + i]);
}

}  // namespace

std::unique_ptr<CgStorage> make_cg_runs(const BlockPattern& pattern) {
  auto runs = std::make_unique<CgRuns>(pattern);
  if (runs->filled() < kLeastFilled) return nullptr;
  return runs;
}

}  // namespace tremolo
