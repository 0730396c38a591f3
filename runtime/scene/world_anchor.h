// The world as a body to which joints hold others: none of its points moves.
#pragma once

#include "common/result.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"

namespace tremolo {

// A fixed body in the world's frame that no force moves, and that feels no contact. step: s.
Result<ContactBody> make_world_anchor(double step);

// The point of the anchor at a position, m.
JointPlace world_place(const Eigen::Vector3d& position, const ContactBody& anchor);

}  // namespace tremolo
