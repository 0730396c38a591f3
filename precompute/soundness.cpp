#include "precompute/soundness.h"

#include <algorithm>
#include <limits>

#include "common/text.h"
#include "precompute/ranks/halo.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// Returns the vertex with the largest motion in the first mode, over all ranks.
VertexId most_moved_vertex(const LocalDofs& local, const BasisRows& psi) {
  struct {
    double motion = 0;
    int vertex = -1;
  } most;
  Eigen::Index row = 0;
  if (psi.rows() > 0) {
    most.motion = psi.col(0).cwiseAbs().maxCoeff(&row);
    most.vertex = local.vertices[row / 3];
  }
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, PETSC_COMM_WORLD);
  return most.vertex;
}

}  // namespace

double stiffness_ratio(const Solid& solid) {
  double low = std::numeric_limits<double>::max(), high = 0;
  for (const Elasticity& elasticity : solid.elasticities) {
    low = std::min(low, elasticity.tensor.norm());
    high = std::max(high, elasticity.tensor.norm());
  }
  return high / low;
}

void require_no_mechanism(const Problem& problem, const Solid& solid, const LocalDofs& local,
                          const Modes& modes, const BasisRows& psi) {
  // psi^T K psi is a sum of terms that cancel. A double has 2e-16 and the factorisation loses some
  // digits; a cantilever a thousand times as long as thick keeps 1e-13.
  constexpr double kNoise = 2e-14;
  const bool finite = over_ranks(psi.allFinite() ? 0.0 : 1.0, MPI_MAX) == 0.0;
  if (modes.cancellation > kNoise && finite) return;
  std::string where;
  if (const VertexId v = finite ? most_moved_vertex(local, psi) : -1; v >= 0) {
    const Eigen::Vector3d& x = problem.mesh.vertices[v];
    where = text(" near vertex %d at %g, %g, %g", static_cast<int>(v), x.x(), x.y(), x.z());
  }
  // A stiff part on a soft one cancels as much.
  if (const double ratio = stiffness_ratio(solid); ratio > kContrast)
    where += text(
        " (or: the materials differ %.0e times in stiffness, too much for this machine's numbers)",
        ratio);
  throw Failure(content_error(
      "a part of the mesh" + where +
      " moves without strain: it hangs by a vertex or an edge only. Join it by faces, or fix it"));
}

void require_accurate(const PrecomputeFindings& findings, const Solid& solid, double residual,
                      double cancellation) {
  // The bounds are far above the values of a sound mesh (1e-9, 1e-14 and 1e-12) and far below
  // harmful ones. A beam with one half a million times as stiff as the other reaches 4e-6. In a
  // finely meshed slender beam, rounding of the shape alone causes forces larger than those of its
  // slow bending; such a residual does not affect the frequency.
  const double rounding = 10 * std::numeric_limits<double>::epsilon() / cancellation;
  const double tolerance = solid.uniform() ? std::max(1e-6, rounding) : 1e-4;
  if (residual <= tolerance && findings.derivative_residual <= tolerance &&
      findings.orthonormality_error <= 1e-9 && findings.polynomial_error <= 1e-9)
    return;
  std::string question = "is the mesh extremely thin or uneven";
  if (const double ratio = stiffness_ratio(solid); ratio > kContrast)
    question += text(", do the materials differ too much (%.0e times in stiffness)", ratio);
  throw Failure({ErrorKind::kSolver,
                 text("the result is not accurate: residual of the modes %.1e, of the derivatives "
                      "%.1e, |U^T M U - I| %.1e, polynomial %.1e; ",
                      residual, findings.derivative_residual, findings.orthonormality_error,
                      findings.polynomial_error) +
                     question + ", or does a PETSc option change the factorisation?"});
}

}  // namespace tremolo
