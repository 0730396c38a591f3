// The model of a periodic motion with its load and its probe, as the flags name them.
#pragma once

#include <string>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/tremolo/response/response_commands.h"
#include "runtime/apps/tremolo/run/body_scene.h"
#include "runtime/model.h"
#include "runtime/response/probe.h"
#include "runtime/response/response.h"

namespace tremolo {

struct PeriodicModel {
  Model::Pointer model;
  BodyScene scene;           // of the flags, for messages and input files
  Eigen::VectorXd load;      // reduced, r; zero without one
  Eigen::VectorXd constant;  // of --static-scale and --gravity, r
  // Of the load at the places of the model's stored response (place_forces_of); zero without one.
  Eigen::VectorXd place_forces;
  double size = 0.0;  // largest extent of the surface at rest, m
  VertexId probe = 0;
  Eigen::MatrixXd probe_rows;  // 3 x r

  Probe the_probe() const { return {probe, probe_rows, true}; }
};

// needs_load: a model without a default load is refused unless --at names one. mode: from 0; the
// vertex that moves most in it is the default probe. Errors: those of loading; kUsage and kContent
// for flags.
Result<PeriodicModel> periodic_model(const PeriodicOptions& options, bool needs_load,
                                     Eigen::Index mode);

// The options of the curve, with the probe's displacement as amplitude. usual_most: its most
// harmonics if the flags do not say. Errors: kContent.
Result<CurveOptions> curve_options(const PeriodicOptions& options, const PeriodicModel& made,
                                   Eigen::Index usual_most);

}  // namespace tremolo
