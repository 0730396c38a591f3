// Bodies of scenes whose models are clouds of mass points.
#pragma once

#include <string>

#include "common/result.h"
#include "runtime/scene/scene.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo::testing {

// The model file "free" or "held", the only ones that there are. lowest, highest: of the clouds'
// frequencies, rad/s.
inline Result<Model::Pointer> cloud_file(const SceneBody& body, double lowest, double highest) {
  const bool free = body.model == "free";
  return frame_model(5, free, lowest, highest, 0.2, free ? 3 : 4);
}

// beta: of Rayleigh's damping, s.
inline SceneBody cloud_body(const std::string& name, FrameKind kind, double beta = 0.0) {
  SceneBody body;
  body.name = name;
  body.kind = kind;
  body.model = kind == FrameKind::kFree ? "free" : "held";
  body.options.beta = beta;
  return body;
}

}  // namespace tremolo::testing
