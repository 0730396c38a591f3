#include "runtime/math/kernels/strain_matrix.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "common/packed_index.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// Vectors of StrainMatrix::Workspace. n: length of z. end: padded pairs.
struct StrainVectors {
  std::size_t n;
  std::size_t end;
  const double* z;
  const double* dz;
  double* rates;
  double* stress;
  double* product;
};

// The coefficients of StrainMatrix::multiply_quickly.
struct StrainSquares {
  const double* stiffness;      // Lambda
  const double* coupling;       // B: for each vector of rows all pairs
  const float* float_coupling;  // B/unit: for each vector of floats of pairs all rows
  const float* tiles;           // H/unit, as symmetric_floats.inc has it
  double unit;
};

// Its vectors. end: pairs of q, to whole vectors. Vectors of r are padded with zeros.
struct SquareVectors {
  std::size_t r;
  std::size_t end;
  const double* q;
  const double* v;
  double* rates;
  float* float_rates;
  double* linear;
  float* float_stretch;
  double* stress;
  float* above;
  double* below;
  double* product;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/kernels/strain_matrix.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {

using std::size_t;

StrainMatrix::StrainMatrix(size_t r, std::span<const double> gram)
    : r_(r), padded_(padded(pair_count(r + 1))) {
  tiles_.assign(plain::group_start(padded_ / kVectorLanes), 0.0);
  const size_t terms = strain_terms(r);
  const auto set = [this, gram](size_t a, size_t b) {
    const size_t row = a + 1, column = b + 1;  // after the constant term
    tiles_[plain::group_start(column / kVectorLanes) + column % kVectorLanes * kVectorLanes +
           row / kVectorLanes * plain::kTile + row % kVectorLanes] =
        (a == b ? 0.5 : 1.0) * gram[pair_index(a, b)];
  };
  for (size_t b = 0; b < terms; ++b)
    for (size_t a = 0; a <= b; ++a) set(a, b);
  for (size_t j = 0; j < r; ++j)
    for (size_t i = 0; i <= j; ++i) {
      const size_t column = strain_index(j) + 1, row = strain_index(i) + 1;
      tiles_[plain::group_start(column / kVectorLanes) + column % kVectorLanes * kVectorLanes +
             row / kVectorLanes * plain::kTile + row % kVectorLanes] = 0.0;
    }
  split(gram);
}

// Sets Lambda, B and H = Q - B^T Lambda^-1 B of the header.
void StrainMatrix::split(std::span<const double> gram) {
  using Eigen::Index;
  constexpr Index kBlock = 64;  // columns of H at a time
  constexpr size_t kLanes = kVectorLanes, kFloats = plain::kFloatLanes;
  const size_t pairs = pair_count(r_), groups = padded(pairs) / kLanes;
  std::vector<size_t> terms(pairs);
  for (size_t j = 0; j < r_; ++j)
    for (size_t i = 0; i <= j; ++i) terms[pair_index(i, j)] = strain_index(i, j);
  const auto entry = [gram](size_t a, size_t b) {
    return gram[a <= b ? pair_index(a, b) : pair_index(b, a)];
  };
  Eigen::MatrixXd coupling(r_, pairs), stretch(r_, pairs);
  stiffness_.assign(r_, 1.0);
  for (size_t k = 0; k < r_; ++k) {
    const double stiffness = entry(strain_index(k), strain_index(k));
    if (stiffness > 0.0) stiffness_[k] = stiffness;
    const auto row = static_cast<Index>(k);
    for (size_t a = 0; a < pairs; ++a)
      coupling(row, static_cast<Index>(a)) = entry(strain_index(k), terms[a]);
    stretch.row(row) = coupling.row(row) / stiffness_[k];
  }
  // Of a group of columns the rows down to its end, in whole vectors of floats.
  std::vector<size_t> starts(groups + 1, 0);
  for (size_t g = 0; g < groups; ++g)
    starts[g + 1] = starts[g] + (g * kLanes / kFloats + 1) * plain::kFloatTile;
  AlignedDoubles tiles(starts[groups], 0.0);
  double unit = 0.0;
  for (Index first = 0; first < coupling.cols(); first += kBlock) {
    const Index count = std::min(kBlock, coupling.cols() - first);
    const Eigen::MatrixXd product =
        coupling.leftCols(first + count).transpose() * stretch.middleCols(first, count);
    for (Index c = 0; c < count; ++c) {
      const auto b = static_cast<size_t>(first + c);
      double* column = tiles.data() + starts[b / kLanes] + b % kLanes * kFloats;
      for (size_t a = 0; a <= b; ++a) {
        const double value = entry(terms[a], terms[b]) - product(static_cast<Index>(a), c);
        unit = std::max(unit, std::abs(value));
        column[a / kFloats * plain::kFloatTile + a % kFloats] = (a == b ? 0.5 : 1.0) * value;
      }
    }
  }
  // A model whose linear terms have all its strains has no H.
  unit_ = std::max(unit, std::numeric_limits<float>::epsilon() * coupling.cwiseAbs().maxCoeff());
  if (!(unit_ > 0.0)) unit_ = 1.0;
  float_tiles_.resize(tiles.size());
  for (size_t i = 0; i < tiles.size(); ++i) float_tiles_[i] = static_cast<float>(tiles[i] / unit_);
  coupling_.assign(padded(r_) * padded(pairs), 0.0);
  float_coupling_.assign((pairs + kFloats - 1) / kFloats * kFloats * r_, 0.0F);
  for (size_t a = 0; a < pairs; ++a)
    for (size_t k = 0; k < r_; ++k) {
      const double b = coupling(static_cast<Index>(k), static_cast<Index>(a));
      coupling_[((k / kLanes * groups + a / kLanes) * kLanes + k % kLanes) * kLanes + a % kLanes] =
          b;
      float_coupling_[(a / kFloats * r_ + k) * kFloats + a % kFloats] =
          static_cast<float>(b / unit_);
    }
}

StrainMatrix::Workspace StrainMatrix::make_workspace() const {
  Workspace workspace;
  const size_t length = padded(r_ + 1);
  for (AlignedDoubles* vector : {&workspace.z, &workspace.dz, &workspace.product})
    vector->assign(length + kVectorLanes, 0.0);
  // Whole groups of eight columns are read.
  const size_t pairs = padded(pair_count(length)) + kVectorLanes;
  for (AlignedDoubles* vector : {&workspace.rates, &workspace.stress}) vector->assign(pairs, 0.0);
  workspace.z[0] = 1.0;
  for (AlignedDoubles* vector : {&workspace.q, &workspace.v, &workspace.linear})
    vector->assign(length + kVectorLanes, 0.0);
  workspace.below.assign(pairs, 0.0);
  for (AlignedFloats* vector : {&workspace.float_rates, &workspace.float_stretch, &workspace.above})
    vector->assign(pairs + plain::kFloatLanes, 0.0F);
  return workspace;
}

double StrainMatrix::multiply(const double* q, const double* v, Workspace& w, double* out) const {
  w.by_squares = false;
  std::copy_n(q, r_, w.z.begin() + 1);
  std::copy_n(v, r_, w.dz.begin() + 1);
  const StrainVectors vectors{r_ + 1,         padded_,         w.z.data(),      w.dz.data(),
                              w.rates.data(), w.stress.data(), w.product.data()};
  const double power = TREMOLO_CALL(damp_strains, tiles_.data(), vectors);
  std::copy_n(w.product.begin() + 1, r_, out);
  return power;
}

double StrainMatrix::multiply_quickly(const double* q, const double* v, Workspace& w,
                                      double* out) const {
  // Relative to the rates q v the stretch v is 1/q, which float does not hold for a body that has
  // come to rest. Nor is the inverse of the rates finite for all of them.
  constexpr double kSmallest = 1e-20, kSmallestRate = 1e-290;
  double most_q = 0.0, most_v = 0.0;
  for (size_t i = 0; i < r_; ++i) {
    w.q[i] = q[i];
    w.v[i] = v[i];
    most_q = std::max(most_q, std::abs(q[i]));
    most_v = std::max(most_v, std::abs(v[i]));
  }
  if (most_q < kSmallest || most_q * most_v < kSmallestRate) return multiply(q, v, w, out);
  w.by_squares = true;
  // The largest rate becomes about one. A number that is not finite stays so.
  const double scale = 1.0 / (most_q * most_v);
  const SquareVectors vectors{r_,
                              padded(pair_count(r_)),
                              w.q.data(),
                              w.v.data(),
                              w.rates.data(),
                              w.float_rates.data(),
                              w.linear.data(),
                              w.float_stretch.data(),
                              w.stress.data(),
                              w.above.data(),
                              w.below.data(),
                              w.product.data()};
  const StrainSquares squares{stiffness_.data(), coupling_.data(), float_coupling_.data(),
                              float_tiles_.data(), unit_};
  TREMOLO_CALL(damp_by_squares, squares, vectors, scale);
  double power = 0.0, whole = 0.0, square = 0.0;
  for (size_t i = 0; i < r_; ++i) {
    power += v[i] * w.product[i];
    whole += v[i] * (w.product[i] + stiffness_[i] * v[i]);
    square += v[i] * v[i];
  }
  // G is positive, but the rounding of float is not.
  const double excess = whole < 0.0 ? whole / square : 0.0;
  for (size_t i = 0; i < r_; ++i) out[i] = w.product[i] - excess * v[i];
  return power - excess * square;
}

void StrainMatrix::multiply_stress(const double* q, Workspace& w, double* out) const {
  if (w.by_squares) {
    std::copy_n(q, r_, w.q.begin());
    TREMOLO_CALL(spread_stress, w.stress.data(), r_, w.q.data(), w.product.data());
    for (size_t i = 0; i < r_; ++i) out[i] = w.product[i] + w.linear[i];
    return;
  }
  std::copy_n(q, r_, w.z.begin() + 1);
  TREMOLO_CALL(spread_stress, w.stress.data(), r_ + 1, w.z.data(), w.product.data());
  std::copy_n(w.product.begin() + 1, r_, out);
}

}  // namespace tremolo
