// What a load does to a free body that its model cannot show: the motion as a whole.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// rigid_modes: motions without strain that the model leaves out, six for a free body in one piece.
// share: of the kinetic energy that a blow of the load gives to the body as a whole and to the
// model's coordinates, the first part; 0 to 1. It takes the mass as spread evenly over the body;
// not a number for several pieces. force: the load's resultant, N; torque: about the centre of
// mass, N m.
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
