#include "runtime/math/kernels/strain_matrix.h"

#include <algorithm>

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
  return workspace;
}

double StrainMatrix::multiply(const double* q, const double* v, Workspace& w, double* out) const {
  std::copy_n(q, r_, w.z.begin() + 1);
  std::copy_n(v, r_, w.dz.begin() + 1);
  const StrainVectors vectors{r_ + 1,         padded_,         w.z.data(),      w.dz.data(),
                              w.rates.data(), w.stress.data(), w.product.data()};
  const double power = TREMOLO_CALL(damp_strains, tiles_.data(), vectors);
  std::copy_n(w.product.begin() + 1, r_, out);
  return power;
}

}  // namespace tremolo
