// Joints between vertices of bodies (runtime/contact/joint.h).
#pragma once

#include "common/result.h"
#include "runtime/body.h"
#include "runtime/contact/joint.h"

namespace tremolo {

// Joins a vertex of each body. Both need Body::set_contact() and one step size. kUsage for what is
// not finite or negative, and where neither place moves; errors as Model::vertex.
Result<Joint> make_joint(const Body& first, VertexId at, const Body& second, VertexId to,
                         const JointOptions& options = {});
// Joins a vertex of the first to where that is now, on the second: to a place that goes with the
// nearest vertex of the second's boundary.
Result<Joint> make_joint(const Body& first, VertexId at, const Body& second,
                         const JointOptions& options = {});
// How far the places are apart now, m.
double joint_distance(const Joint& joint, const Body& first, const Body& second);

}  // namespace tremolo
