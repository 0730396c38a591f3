// Shared by the C interfaces of tetrahedra, of cloth and of worlds of all kinds: C structs to
// values of a scene.
#pragma once

#include <string>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/motion/tet_body.h"
#include "runtime/math/pose.h"
#include "runtime/tremolo_cloth.h"
#include "runtime/tremolo_tets.h"

namespace tremolo::c_api {

// kUsage for an unknown method, degree or take_unsolved.
Result<TetBodyOptions> to_tets_options(const tremolo_tets_options& options);

// kUsage for a quaternion whose length is not one.
Result<Pose> to_pose(const double position[3], const double quaternion[4]);

SceneCloth to_cloth(const tremolo_cloth_options& options, std::string name);

}  // namespace tremolo::c_api
