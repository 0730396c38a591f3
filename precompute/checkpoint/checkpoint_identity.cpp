// The identity of a run, on which the reuse of a stage depends.
#include <span>
#include <suitesparse/cholmod.h>

#include <metis.h>

#include "precompute/checkpoint/checkpoint.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

// Returns the instruction set for which the loader has chosen the TREMOLO_CLONES.
std::string vector_instructions() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512vl")) return "AVX-512";
  if (__builtin_cpu_supports("avx2")) return "AVX2";
#endif
  return "plain";
}

}  // namespace

CheckpointIdentity checkpoint_identity(const PrecomputeRequest& request, const Problem& problem,
                                       const ModeCounts& counts, LinearSolver solver,
                                       int blas_threads) {
  const std::string given = petsc_options();
  int cholmod[3] = {};
  cholmod_version(cholmod);
  // A default count may be extended so that the cut does not divide a cluster.
  const auto count = [](int number, bool asked) {
    return std::to_string(number) + (asked ? "" : " or more");
  };
  CheckpointIdentity identity;
  for (const Fact& fact : facts_of(problem)) identity.emplace_back(fact.name, fact.value);
  const CheckpointIdentity rest = {
      {"mass", request.solid.elements.mass == MassKind::kConsistent ? "consistent" : "lumped"},
      {"linear modes", count(counts.linear, request.basis.linear_modes.has_value())},
      {"coordinates", count(counts.modes, request.basis.modes.has_value())},
      {"kept modes", request.basis.keep_modes ? std::to_string(*request.basis.keep_modes) : "auto"},
      {"derivatives", request.basis.linear ? "no" : std::to_string(request.basis.derivatives)},
      {kSolverFact, name_of(solver)},
      {"PETSc options", given.empty() ? "none" : given},
      {"ranks", std::to_string(mpi_ranks())},
      {"BLAS threads", std::to_string(blas_threads)},
      {"BLAS", blas_name()},
      {"vector instructions", vector_instructions()},
      {"the program", program_version()},
      {"PETSc", petsc_version()},
      {"SLEPc", slepc_version()},
      {"METIS", version_text(METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)},
      {"CHOLMOD", version_text(cholmod[0], cholmod[1], cholmod[2])}};
  identity.insert(identity.end(), rest.begin(), rest.end());
  return identity;
}

}  // namespace tremolo
