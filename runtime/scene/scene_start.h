// The start of a body of a scene: its loads, its first state, and a check of its frame's motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/result.h"
#include "runtime/contact_body.h"
#include "runtime/scene/motion.h"
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

}  // namespace tremolo
