// What loads the body in a reference run.
#pragma once

#include "common/load_signal.h"
#include "precompute/reference/full_order.h"
#include "precompute/reference/reference_options.h"

namespace tremolo {

// point: the default load times the scale, with its shape in time; gravity: for ever. N, both
// without the share that would set a free body in motion.
struct BodyLoads {
  Vector point, gravity;
  Signal signal;

  Vector all() const { return point + gravity; }  // of statics
  Vector mean(double time, double step) const;    // over a step
  bool to_come(double time, double step) const;   // whether some load acts after `time`
};

// Throws Failure: kUsage when nothing loads the body or --load does not know where, kContent when
// the force acts along held components only or moves a free body without deforming it.
BodyLoads make_body_loads(const ReferenceOptions& options, const Problem& problem,
                          const FullOrder& body);

}  // namespace tremolo
