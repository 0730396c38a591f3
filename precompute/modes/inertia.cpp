// The certificate that no mode was missed: Sylvester's law of inertia on an LDL^T factor.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "precompute/modes/mode_clusters.h"
#include "precompute/modes/modes.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "count the modes by inertia");
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
  require_factorised(factor.get());
  PetscInt negative = 0, zero = 0, positive = 0;
  require(MatGetInertia(factor.get(), &negative, &zero, &positive));
  if (zero > 0)
    throw Failure({ErrorKind::kSolver, "the count of modes by inertia met " + std::to_string(zero) +
                                           " pivots that are zero"});
  return static_cast<int>(negative);
}

int count_modes_below(const Matrices& matrices, double bound, SparseCholesky& factor,
                      unsigned threads, double most_growth) {
  // A pivot that is small by chance, one of the eigenvalues of a part of the mesh being next to the
  // bound, leaves far less than that.
  constexpr double kStable = 1e5;
  const PetscMatrix shifted = shifted_stiffness(matrices, bound);
  const LdlReport report = factor.count_negative(sparse_rows(shifted.get()), threads);
  return report.growth <= std::min(kStable, most_growth) ? static_cast<int>(report.negative) : -1;
}

InertiaCertificate certify(const Matrices& matrices, Modes& modes, int rigid_count,
                           unsigned threads) {
  std::vector<double> values(modes.squared_frequencies.begin(), modes.squared_frequencies.end());
  if (!modes.left_out.empty())
    values.insert(values.end(), modes.left_out.begin(), modes.left_out.end());
  else if (modes.next_squared_frequency > 0)
    values.push_back(modes.next_squared_frequency);
  // Between the last two that differ by more than rounding: a cluster at the cut may go on beyond
  // what was computed.
  const Nearness near = nearness(values.front(), modes.cancellation);
  std::size_t below = values.size() - 1;
  while (below > 0 && near(values[below - 1], values[below])) --below;
  InertiaCertificate certificate;
  if (below == 0) {  // all alike, or one mode that is all there is
    certificate.bound = 0.5 * values.front();
    certificate.expected = rigid_count;
  } else {
    certificate.bound = 0.5 * (values[below - 1] + values[below]);
    certificate.expected = static_cast<int>(below) + rigid_count;
  }
  certificate.counted = -1;
  if (modes.cholesky != nullptr) {
    // The count is that of a matrix off by the factor's growth times rounding, relative to its
    // diagonal: that must not carry a mode across the bound.
    const double room = std::abs(values[below] - certificate.bound);
    const double unit =
        std::numeric_limits<double>::epsilon() * values.front() / modes.cancellation;
    certificate.counted =
        count_modes_below(matrices, certificate.bound, *modes.cholesky, threads, 0.5 * room / unit);
    certificate.solver = "own";
    release_solver(modes);
  }
  if (certificate.counted < 0) {
    release_solver(modes);
    certificate.counted = count_modes_below(matrices, certificate.bound);
    certificate.solver = "mumps";
  }
  return certificate;
}

}  // namespace tremolo
