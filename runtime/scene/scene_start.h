// How a body of a scene begins: its loads, its first state, and whether its frame may move as it
// is to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/result.h"
#include "runtime/contact_body.h"
#include "runtime/scene/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The load's vertices and their forces, N. Errors: kContent for a load that names no vertices where
// the model has no load of its own, or whose vertices do not move; those of selectors.
Result<DefaultLoad> forces_of(const SceneLoad& load, const Model& model);

// Gives the body its loads. load.table must outlive it. Errors as forces_of and Body::add_load.
Status add_loads(const std::vector<SceneLoad>& loads, ContactBody& body);

// Puts the body at rest where its loads at t = 0 and gravity hold it. Errors as standing_shape.
Status settle(const SceneBody& wanted, const Eigen::Vector3d& gravity, ContactBody& body);

// The motion of the frame in the k-th step, counted from 0. piece: of the path.
FrameMotion frame_motion(const MotionPath& path, std::size_t piece, std::int64_t k, double step);

// Errors: kContent, telling the acceleration, for a jump that says nothing of how it is meant, and
// for an acceleration of a point within `reach` (m) of the frame's origin above the body's limit.
Status check_accelerations(const SceneBody& wanted, const MotionPath& path, const Scene& scene,
                           double reach);

}  // namespace tremolo
