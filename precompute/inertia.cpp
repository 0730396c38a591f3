// The certificate that no mode was missed: Sylvester's law of inertia on an LDL^T factor.
#include "precompute/failure.h"
#include "precompute/modes.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "count the modes by inertia");
}

}  // namespace

int count_modes_below(const Matrices& matrices, double bound) {
  PetscMatrix shifted;
  require(MatDuplicate(matrices.stiffness.get(), MAT_COPY_VALUES, shifted.out()));
  require(MatAXPY(shifted.get(), -bound, matrices.mass.get(), SUBSET_NONZERO_PATTERN));
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

InertiaCertificate certify(const Matrices& matrices, const Modes& modes, int rigid_count) {
  const Eigen::Index count = modes.squared_frequencies.size();
  const double last = modes.squared_frequencies[count - 1];
  const double next = modes.next_squared_frequency;
  InertiaCertificate certificate;
  certificate.expected = static_cast<int>(count) + rigid_count;
  if (next > last * (1.0 + 1e-7)) {
    certificate.bound = 0.5 * (last + next);
  } else {
    // The cut goes through a cluster: count above it, the next mode included.
    certificate.bound = std::max(last, next) * (1.0 + 1e-7);
    if (next > 0) ++certificate.expected;
  }
  certificate.counted = count_modes_below(matrices, certificate.bound);
  return certificate;
}

}  // namespace tremolo
