// Which data of each stage is saved: all that the report, the basis file and later stages need.
// find_...() returns none if the stage must be computed; otherwise the data has the requested
// shapes.
#pragma once

#include <optional>

#include "precompute/checkpoint/checkpoint.h"
#include "precompute/modes/certificate.h"
#include "precompute/modes/mode_clusters.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reduction/derivatives.h"

namespace tremolo {

// The factor is not saved; the solver recomputes it bit for bit. count: the number requested; up to
// kMostAdded more may be stored.
void keep_modes(Checkpoint& checkpoint, const WholeModes& whole);
std::optional<WholeModes> find_modes(Checkpoint& checkpoint, Eigen::Index dofs, Eigen::Index count);

// modes: the mode vectors, i.e. the first columns; they are saved with the stage "modes".
void keep_derivatives(Checkpoint& checkpoint, const ModalDerivatives& derivatives);
std::optional<ModalDerivatives> find_derivatives(Checkpoint& checkpoint, const Columns& modes);

void keep_certificate(Checkpoint& checkpoint, const InertiaCertificate& certificate);
std::optional<InertiaCertificate> find_certificate(Checkpoint& checkpoint);

// basis: without vectors. rows: at this rank's vertices, rows x r, with up to kMostAdded more
// columns than requested. derivative_residual: saved here, since the stage "derivatives" is
// dropped.
struct FinishedBasis {
  Basis basis;
  BasisRows rows;
  double derivative_residual = 0;
};
void keep_basis(Checkpoint& checkpoint, const FinishedBasis& finished);
std::optional<FinishedBasis> find_basis(Checkpoint& checkpoint, Eigen::Index rows, Eigen::Index r);

// cubic, quartic, strain_gram: as in BasisData.
struct FinishedCoefficients {
  std::vector<double> cubic, quartic, strain_gram;
  double polynomial_error = 0;
};
void keep_coefficients(Checkpoint& checkpoint, const FinishedCoefficients& finished);
std::optional<FinishedCoefficients> find_coefficients(Checkpoint& checkpoint, Eigen::Index r);

}  // namespace tremolo
