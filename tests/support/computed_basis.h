// The basis of a mesh, by all stages of the precompute.
#pragma once

#include <string>
#include <utility>

#include "precompute/pipeline.h"
#include "tests/support/meshes/mesh_writers.h"
#include "tests/support/temporary_folder.h"

namespace tremolo::testing {

// A request for linear elements of one material; fix: a selector.
inline PrecomputeRequest basis_request(const Material& material, const std::string& fix) {
  PrecomputeRequest request;
  request.solid.materials.usual = material;
  request.solid.support.fixed = {*parse_selector(fix)};
  return request;
}

struct ComputedBasis {
  PrecomputeRequest request;
  LoadedProblem loaded;
  PrecomputeResult result;
};

inline ComputedBasis compute_basis(const TetMesh& mesh, PrecomputeRequest request) {
  const TemporaryFolder folder;
  const auto files = as_veg(mesh);
  request.solid.files.mesh = folder.write(files.front().first, files.front().second);
  StageLog log(true);
  LoadedProblem loaded = load_mesh(request, log);
  PrecomputeResult result = run_precompute(request, loaded, log);
  return {std::move(request), std::move(loaded), std::move(result)};
}

}  // namespace tremolo::testing
