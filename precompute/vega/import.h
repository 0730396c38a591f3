// A model that VegaFEM reduced -> a basis file, without solving: its basis U (.U) and the
// polynomials of its forces (.cub) over its own mesh.
//
// Their coordinates y have the mass y'^T G y' / 2 with G = U^T M U, which is the identity in
// VegaFEM's lumped mass, and the stiffness L at rest. With L R = G R diag(lambda), R^T G R = I the
// coordinates q of y = R q are Tremolo's: U R, lambda, and the tensors of V(R q).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/stage_log.h"
#include "precompute/problem/problem.h"
#include "precompute/reduction/encoding_error.h"

namespace tremolo {

// U^T M U of columns over all vertices. density: kg/m^3, one a tetrahedron; basis: 3n x r.
Eigen::MatrixXd reduced_mass(const TetMesh& mesh, const std::vector<double>& density,
                             const BasisRows& basis, MassKind kind);

// request.imported is true.
struct ImportRequest : ProblemRequest {
  std::string basis_path;   // .U, over the vertices of the mesh
  std::string cubic_path;   // .cub
  bool mass_given = false;  // by the user: the basis is made orthonormal in `mass`
};

struct ImportFindings {
  std::string basis_hash;  // XXH3-64 of the files
  std::string cubic_hash;
  double asymmetry = 0;         // of the .cub's rows (precompute/vega/reduced_tensors.h)
  double force_error = 0;       // |R^T f(Rq) - grad V(q)| / |R^T f(Rq)|, f of the .cub, at most
  double lumped_error = 0;      // max |G - I| as the files are
  double consistent_error = 0;  // the same in the consistent mass
  MassKind mass = MassKind::kLumped;
  bool orthonormalised = false;     // G was taken into account; else it was I
  double orthonormality_error = 0;  // max |(UR)^T M UR - I|
  std::optional<EncodingError> encoding_error;
};

struct ImportResult {
  BasisData data;  // provenance is still empty
  Problem problem;
  ImportFindings findings;
};

// Reads request.mesh_path and the two files. A basis of 3n rows brings zero rows for
// the vertices that do not move (1e-12 of a column's largest entry counts as zero); one of 3(n -
// fixed) rows needs request.fix. Throws Failure: kContent when the files do not fit each other
// (both are named), the forces have no potential, the stiffness is not positive, or the basis is
// orthonormal in neither mass and none was asked for.
ImportResult import_reduced(const ImportRequest& request, StageLog& log);

// The JSON object kept in the file, and the one printed by --json.
std::string import_provenance(const ImportRequest& request, const std::string& command_line,
                              const ImportResult& result);
std::string import_report(const ImportResult& result);

}  // namespace tremolo
