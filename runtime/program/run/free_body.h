// The part of a load that moves a free body as a whole, which its model leaves out.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// The rigid motion of a free body under a load. The mass is assumed to be uniform over the body.
struct RigidLoss {
  std::uint64_t rigid_modes = 0;  // motions left out of the model; six for a body in one piece
  // Fraction of the kinetic energy of a short push that goes into rigid motion, 0 to 1; the rest
  // goes into the model's coordinates. Not a number for several pieces.
  double share = 0.0;
  double force = 0.0;   // resultant of the load, N
  double torque = 0.0;  // about the centre of mass, N m
};

// Empty if the body is not free or there is no load. Errors: those of reading the file.
Result<std::optional<RigidLoss>> rigid_loss(const RunOptions& options, const Model& model);

// The same for a given load, mass (kg) and number of rigid motions.
RigidLoss rigid_loss(const Model& model, const DefaultLoad& load, double mass,
                     std::uint64_t rigid_modes);

}  // namespace tremolo
