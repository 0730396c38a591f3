// SceneWorld: the energy balance and the momenta of a body.
#include <array>
#include <vector>

#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/world/scene_world.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Momenta of the body of one frame. poses: of the frame one step before, now, and one step later.
Momenta momenta_in_frame(const FrameInertia& inertia, const Eigen::VectorXd& q,
                         const Eigen::VectorXd& v, const std::array<Pose, 3>& poses, double h) {
  const auto& [before, pose, behind] = poses;
  // The frame's velocities at the time between two steps are the means of the two steps.
  const Vector3d velocity =
      pose.rotation.conjugate() * (behind.position - before.position) / (2.0 * h);
  const Vector3d spin = (turn_of(before.rotation.conjugate() * pose.rotation) +
                         turn_of(pose.rotation.conjugate() * behind.rotation)) /
                        (2.0 * h);
  InertiaAt at(q.size());
  at.compute(inertia, q);
  const Vector3d moment = inertia.first_moment + inertia.s * q;
  const Vector3d linear = inertia.mass * velocity + spin.cross(moment) + inertia.s * v;
  const Vector3d angular = moment.cross(velocity) + at.J * spin + inertia.a * v + at.couple(v);
  const Vector3d world = pose.rotation * linear;
  return {world, pose.position.cross(world) + pose.rotation * angular};
}

}  // namespace

EnergyAccount SceneWorld::account(std::size_t i) const {
  const ContactBody& body = actors_[i].body;
  const Energy energy = body.energy();
  EnergyAccount account;
  account.kinetic = energy.kinetic;
  account.potential = energy.potential;
  account.at_start = actors_[i].energy_at_start;
  account.support = body.sums().support;
  account.gravity = body.sums().gravity;
  account.contact = body.contact_account().energy;
  account.contact_given = body.contact_sums().given;
  account.restitution = 0.0 - body.contact_sums().lost;
  account.friction = 0.0 - body.contact_sums().friction_loss;
  account.hand = body.contact_sums().hand;
  account.joint = body.contact_sums().joint;
  account.contact_error = body.contact_sums().error;
  account.load = body.sums().work - account.support - account.gravity - body.contact_sums().work -
                 account.hand - account.joint;
  account.damping = 0.0 - body.sums().dissipated;
  return account;
}

Momenta SceneWorld::momenta(std::size_t i) const {
  const Actor& actor = actors_[i];
  const ContactBody& body = actor.body;
  if (body.frame() == FrameKind::kFree) return {body.momentum().linear, body.momentum().angular};
  if (!actor.inertia) return {};
  Eigen::VectorXd v(body.model().modes());
  body.integrator().synchronized_momentum(body.state(), v);
  const double h = scene_.step, t = time();
  if (actor.bones) {
    const std::size_t count = actor.bones->size();
    std::vector<Pose> before(count), behind(count);
    actor.bones->poses(t - h, before);
    actor.bones->poses(t + h, behind);
    Momenta sum;
    for (std::size_t b = 0; b < count; ++b) {
      const Momenta one = momenta_in_frame(*body.skin()->shares[b], body.state().q, v,
                                           {before[b], body.pose(b), behind[b]}, h);
      sum.linear += one.linear;
      sum.angular += one.angular;
    }
    return sum;
  }
  const Pose pose = body.pose();
  if (actor.path.still())
    return momenta_in_frame(*actor.inertia, body.state().q, v, {pose, pose, pose}, h);
  return momenta_in_frame(
      *actor.inertia, body.state().q, v,
      {actor.path.pose_in(actor.piece, t - h), pose, actor.path.pose_in(actor.piece, t + h)}, h);
}

}  // namespace tremolo
