// What of each stage is kept, and how it comes back: all that the report, the basis file and later
// stages want of it. find_... gives nothing when the stage is not there and is to be made; what
// comes back has the shapes that are asked for.
#pragma once

#include <optional>

#include "precompute/checkpoint/checkpoint.h"
#include "precompute/modes/certificate.h"
#include "precompute/modes/mode_clusters.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reduction/derivatives.h"

namespace tremolo {

// The factor is not kept: the solver makes it again, bit for bit. count: asked for; up to
// kMostAdded more may be there.
void keep_modes(Checkpoint& checkpoint, const WholeModes& whole);
std::optional<WholeModes> find_modes(Checkpoint& checkpoint, Eigen::Index dofs, Eigen::Index count);

// modes: their vectors, the first of the columns; they are kept with the modes.
void keep_derivatives(Checkpoint& checkpoint, const ModalDerivatives& derivatives);
std::optional<ModalDerivatives> find_derivatives(Checkpoint& checkpoint, const Columns& modes);

void keep_certificate(Checkpoint& checkpoint, const InertiaCertificate& certificate);
std::optional<InertiaCertificate> find_certificate(Checkpoint& checkpoint);

// basis: without its vectors. rows: of the vertices that this rank has, rows x r, up to kMostAdded
// more columns than asked for.
// derivative_residual: the derivatives are of no further use, and dropped.
struct FinishedBasis {
  Basis basis;
  BasisRows rows;
  double derivative_residual = 0;
};
void keep_basis(Checkpoint& checkpoint, const FinishedBasis& finished);
std::optional<FinishedBasis> find_basis(Checkpoint& checkpoint, Eigen::Index rows, Eigen::Index r);

// cubic, quartic: as in BasisData.
struct FinishedCoefficients {
  std::vector<double> cubic, quartic;
  double polynomial_error = 0;
};
void keep_coefficients(Checkpoint& checkpoint, const FinishedCoefficients& finished);
std::optional<FinishedCoefficients> find_coefficients(Checkpoint& checkpoint, Eigen::Index r);

}  // namespace tremolo
