// Joints between vertices of bodies (runtime/contact/joint.h).
#pragma once

#include "common/result.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"

namespace tremolo {

// Joins a vertex of each body. Both bodies need Body::set_contact() and one step size. Errors:
// kUsage for a value that is not finite or negative, and if neither vertex can move; otherwise same
// as for Model::vertex.
Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         VertexId to, const JointOptions& options = {});
// Joins a vertex of the first body to its present position on the second: to a point that moves
// with the nearest vertex of the second body's boundary.
Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         const JointOptions& options = {});
// Present distance of the joint's two points, m.
double joint_distance(const Joint& joint, const ContactBody& first, const ContactBody& second);

}  // namespace tremolo
