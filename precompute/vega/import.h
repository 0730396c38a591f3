// Import of a model reduced by VegaFEM into a basis file, without solving: its basis U (.U) and the
// polynomials of its reduced forces (.cub), on its own mesh.
//
// VegaFEM's coordinates y have the kinetic energy y'^T G y' / 2 with G = U^T M U, the identity in
// its lumped mass, and the stiffness L at rest. With L R = G R diag(lambda) and R^T G R = I, y = R
// q defines Tremolo's coordinates q: the basis is U R, with lambda and the tensors of V(R q).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/stage_log.h"
#include "precompute/problem/precompute_request.h"
#include "precompute/problem/problem.h"
#include "precompute/reduction/encoding_error.h"

namespace tremolo {

// Returns U^T M U for columns at all vertices. density: kg/m^3, one a tetrahedron; basis: 3n x r.
Eigen::MatrixXd reduced_mass(const TetMesh& mesh, const std::vector<double>& density,
                             const BasisRows& basis, MassKind kind);

struct ImportFindings {
  std::string basis_hash;  // XXH3-64 of the files
  std::string cubic_hash;
  double asymmetry = 0;         // of the .cub's rows (precompute/vega/reduced_tensors.h)
  double force_error = 0;       // largest |R^T f(Rq) - grad V(q)| / |R^T f(Rq)|, f of the .cub
  double lumped_error = 0;      // max |G - I| of the files, in the lumped mass
  double consistent_error = 0;  // the same in the consistent mass
  MassKind mass = MassKind::kLumped;
  bool orthonormalised = false;     // whether G was used; else the basis counts as orthonormal
  double orthonormality_error = 0;  // max |(UR)^T M UR - I|
  std::optional<EncodingError> encoding_error;
};

struct ImportResult {
  BasisData data;  // provenance is empty
  Problem problem;
  ImportFindings findings;
};

// Reads the mesh and both files. A basis of 3n rows has zero rows at vertices that do not
// move (up to 1e-12 of a column's largest entry counts as zero); one of 3 (n - fixed) rows requires
// --fix. Throws Failure (kContent) if the files do not match (the message names both), the
// forces have no potential, the stiffness is not positive, or the basis is orthonormal in neither
// mass and no mass was requested.
ImportResult import_reduced(const ImportRequest& request, StageLog& log);

// Return the JSON object stored in the file, and the one printed by --json.
std::string import_provenance(const ImportRequest& request, const ImportResult& result);
std::string import_report(const ImportResult& result);

}  // namespace tremolo
