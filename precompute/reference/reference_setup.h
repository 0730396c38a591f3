// Beginnings of every run of the reference: checks, watched vertices, loads, the place of its
// output.
#pragma once

#include <string>
#include <vector>

#include "common/load_signal.h"
#include "common/mesh/tet_mesh.h"
#include "precompute/reference/full/full_order.h"
#include "precompute/reference/reference_options.h"

namespace tremolo {

// Returns the vertices of --probe, each once, in the order of the flags. Throws Failure.
std::vector<VertexId> probe_vertices(const ReferenceOptions& options, const TetMesh& mesh);

// Returns the path of run.csv in the folder of --out.
std::string table_path(const ReferenceOptions& options);

// Checks the output before hours of computation: it is no input, and can be written. Makes the
// folder. Throws Failure.
void require_output(const ReferenceOptions& options);

// point: the default load times the scale, multiplied by `signal` in time; gravity: constant. N,
// both without the rigid component of a free body.
struct BodyLoads {
  Vector point, gravity;
  Signal signal;

  Vector all() const { return point + gravity; }    // for statics
  Vector mean(double time, double step) const;      // over a step
  double share_at(double time, double step) const;  // of `point`, at the end of a step; 0 at t = 0
  bool to_come(double time, double step) const;     // whether a load acts after `time`
};

// Throws Failure: kUsage if nothing loads the body or --load has no default load, kContent if the
// force acts along held components only or moves a free body without deforming it.
BodyLoads make_body_loads(const ReferenceOptions& options, const Problem& problem,
                          const FullOrder& body);

}  // namespace tremolo
