// tremolo_body_*: frames that move, momenta, gravity and works, from C.
#include <algorithm>

#include "runtime/c/c_api.h"

namespace {

using Eigen::Vector3d;
using tremolo::ContactBody;
using tremolo::Pose;
using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::put;
using tremolo::c_api::with;

Pose to_pose(const double position[3], const double quaternion[4]) {
  return {Vector3d(position),
          Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3])};
}

}  // namespace

tremolo_status tremolo_body_set_pose(tremolo_body* body, const double position[3],
                                     const double quaternion[4]) {
  return with(body, {{position, "the position"}, {quaternion, "the quaternion"}},
              [&](ContactBody& known) { return known.set_pose(to_pose(position, quaternion)); });
}

tremolo_status tremolo_body_pose(const tremolo_body* body, double position[3],
                                 double quaternion[4]) {
  return with(body, [&](const ContactBody& known) -> Status {
    const Pose pose = known.pose();
    put(pose.position, position);
    if (quaternion == nullptr) return Success{};
    quaternion[0] = pose.rotation.w();
    put(Vector3d(pose.rotation.vec()), quaternion + 1);
    return Success{};
  });
}

tremolo_status tremolo_body_move_to(tremolo_body* body, const double position[3],
                                    const double quaternion[4],
                                    const tremolo_frame_motion* motion) {
  return with(body, {{position, "the position"}, {quaternion, "the quaternion"}},
              [&](ContactBody& known) -> Status {
                const Pose pose = to_pose(position, quaternion);
                if (motion == nullptr) return known.move_to(pose);
                return known.move_to(pose, tremolo::FrameMotion{Vector3d(motion->acceleration),
                                                                Vector3d(motion->spin),
                                                                Vector3d(motion->spin_rate)});
              });
}

tremolo_status tremolo_body_set_motion(tremolo_body* body, const double velocity[3],
                                       const double spin[3]) {
  return with(body, {{velocity, "the velocity"}, {spin, "the spin"}}, [&](ContactBody& known) {
    return known.set_motion(Vector3d(velocity), Vector3d(spin));
  });
}

tremolo_status tremolo_body_motion(const tremolo_body* body, double velocity[3], double spin[3]) {
  return with(body, [&](const ContactBody& known) -> Status {
    const tremolo::RigidState rigid = known.rigid_state();
    put(rigid.velocity, velocity);
    put(rigid.spin, spin);
    return Success{};
  });
}

tremolo_status tremolo_body_momentum(const tremolo_body* body, double linear[3],
                                     double angular[3]) {
  return with(body, [&](const ContactBody& known) -> Status {
    put(known.momentum().linear, linear);
    put(known.momentum().angular, angular);
    return Success{};
  });
}

tremolo_status tremolo_body_set_gravity(tremolo_body* body, const double gravity[3]) {
  return with(body, {{gravity, "gravity"}},
              [&](ContactBody& known) { return known.set_gravity(Vector3d(gravity)); });
}

tremolo_status tremolo_body_work(const tremolo_body* body, double* load, double* support,
                                 double* gravity, double* damping) {
  return with(body, [&](const ContactBody& known) -> Status {
    const double contact = known.contact_sums().work + known.contact_sums().hand;
    put(known.sums().work - known.sums().support - known.sums().gravity - contact, load);
    put(known.sums().support, support);
    put(known.sums().gravity, gravity);
    put(0.0 - known.sums().dissipated, damping);
    return Success{};
  });
}
