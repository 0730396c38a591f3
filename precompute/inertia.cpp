// The certificate that no mode was missed: Sylvester's law of inertia on an LDL^T factor.
#include <vector>

#include "precompute/failure.h"
#include "precompute/modes.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "count the modes by inertia");
}

PetscMatrix shifted_stiffness(const Matrices& matrices, double bound) {
  PetscMatrix shifted;
  require(MatDuplicate(matrices.stiffness.get(), MAT_COPY_VALUES, shifted.out()));
  require(MatAXPY(shifted.get(), -bound, matrices.mass.get(), SUBSET_NONZERO_PATTERN));
  return shifted;
}

}  // namespace

int count_modes_below(const Matrices& matrices, double bound) {
  const PetscMatrix shifted = shifted_stiffness(matrices, bound);
  // Symmetric but indefinite: MUMPS must not take it for positive definite.
  require(MatSetOption(shifted.get(), MAT_SPD, PETSC_FALSE));
  require(MatSetOption(shifted.get(), MAT_SYMMETRIC, PETSC_TRUE));

  PetscMatrix factor;
  require(MatGetFactor(shifted.get(), MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.out()));
  require(MatMumpsSetIcntl(factor.get(), 24, 1));  // detect null pivots
  require(MatMumpsSetIcntl(factor.get(), 13, 1));  // a ScaLAPACK root would hide its inertia
  MatFactorInfo info;
  require(MatFactorInfoInitialize(&info));
  require(MatCholeskyFactorSymbolic(factor.get(), shifted.get(), nullptr, &info));
  require(MatCholeskyFactorNumeric(factor.get(), shifted.get(), &info));
  PetscInt negative = 0, zero = 0, positive = 0;
  require(MatGetInertia(factor.get(), &negative, &zero, &positive));
  return static_cast<int>(negative);
}

int count_modes_below(const Matrices& matrices, double bound, SparseCholesky& factor,
                      unsigned threads) {
  // The count is that of a matrix off by this times rounding, relative to the diagonal. A pivot
  // that is small by chance, one of the eigenvalues of a part of the mesh being next to the bound,
  // leaves far less than that.
  constexpr double kStable = 1e5;
  const PetscMatrix shifted = shifted_stiffness(matrices, bound);
  const LdlReport report = factor.count_negative(sparse_rows(shifted.get()), threads);
  return report.growth <= kStable ? static_cast<int>(report.negative) : -1;
}

InertiaCertificate certify(const Matrices& matrices, Modes& modes, int rigid_count,
                           unsigned threads) {
  constexpr double kGap = 1e-7;  // relative: closer eigenvalues are a cluster
  std::vector<double> values(modes.squared_frequencies.begin(), modes.squared_frequencies.end());
  if (modes.next_squared_frequency > 0) values.push_back(modes.next_squared_frequency);
  // Between the last two that differ: a cluster at the cut may go on beyond what was computed.
  std::size_t below = values.size() - 1;
  while (below > 0 && values[below] <= values[below - 1] * (1.0 + kGap)) --below;
  InertiaCertificate certificate;
  if (below == 0) {  // all alike, or one mode that is all there is
    certificate.bound = values.front() * (1.0 - kGap);
    certificate.expected = rigid_count;
  } else {
    certificate.bound = 0.5 * (values[below - 1] + values[below]);
    certificate.expected = static_cast<int>(below) + rigid_count;
  }
  certificate.counted = -1;
  if (modes.cholesky != nullptr) {
    certificate.counted = count_modes_below(matrices, certificate.bound, *modes.cholesky, threads);
    certificate.solver = "own";
    modes.cholesky.reset();
  }
  if (certificate.counted < 0) {
    certificate.counted = count_modes_below(matrices, certificate.bound);
    certificate.solver = "mumps";
  }
  return certificate;
}

}  // namespace tremolo
