// The part of a load that moves a free body as a whole, which its model leaves out.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// rigid_modes: motions without strain that the model leaves out, six for a free body in one piece.
// share: the part of the kinetic energy of a short push that goes into rigid motion, 0 to 1; the
// rest goes into the model's coordinates. The mass is taken as spread evenly over the body; the
// share is not a number for several pieces. force: the load's resultant, N; torque: about the
// centre of mass, N m.
struct RigidLoss {
  std::uint64_t rigid_modes = 0;
  double share = 0.0;
  double force = 0.0;
  double torque = 0.0;
};

// Empty if the body is not free or there is no load. Errors: those of reading the file.
Result<std::optional<RigidLoss>> rigid_loss(const RunOptions& options, const Model& model);

// The same for a given load, mass (kg) and number of rigid motions.
RigidLoss rigid_loss(const Model& model, const DefaultLoad& load, double mass,
                     std::uint64_t rigid_modes);

}  // namespace tremolo
