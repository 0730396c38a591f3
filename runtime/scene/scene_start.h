// The start of a body of a scene: its loads, its first state, and a check of its frame's motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/contact_body.h"
#include "runtime/math/kernels/potential.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The load's vertices and their forces, N. Errors: kContent for a load without vertices on a model
// without a default load, or whose vertices do not move; those of selectors.
Result<DefaultLoad> forces_of(const SceneLoad& load, const Model& model);

// Gives the body its loads. load.table must outlive it. Errors as forces_of and Body::add_load.
Status add_loads(const std::vector<SceneLoad>& loads, ContactBody& body);

// Puts the body at rest in its equilibrium under its loads at t = 0 and gravity. Errors as for
// standing_shape.
Status settle(const SceneBody& wanted, const Eigen::Vector3d& gravity, ContactBody& body);

// The motion of the frame in the k-th step, counted from 0. piece: of the path.
FrameMotion frame_motion(const MotionPath& path, std::size_t piece, std::int64_t k, double step);

// Errors: kContent, with the acceleration, for a jump of the kind kRefuse, and for an acceleration
// above the body's limit of a point within `reach` (m) of the frame's origin.
Status check_accelerations(const SceneBody& wanted, const MotionPath& path, const Scene& scene,
                           double reach);

// Linear constraints rows q = target. rows: c x r, of full rank; target: c; c = 0: none.
struct Hold {
  Eigen::MatrixXd rows;
  Eigen::VectorXd target;
};

// The q (r) with grad V(q) = force + rows^T x and rows q = target, x being the constraint forces.
// The path from rest is followed by load increments, each solved by Newton's method and halved
// where that does not converge. Errors: kContent if the constrained rows are not independent,
// kSolver if the path cannot be followed to its end or the equilibrium there is not stable.
Result<Eigen::VectorXd> standing_shape(const Potential& potential, const Eigen::VectorXd& force,
                                       const Hold& hold = {});

}  // namespace tremolo
