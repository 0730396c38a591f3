#include "runtime/bodies/reduced/surface_velocity.h"

#include <string>

namespace tremolo {

using Eigen::Vector3d;

Status surface_velocities(const Body& body, std::span<double> velocities) {
  const DrawnSurface surface = body.model().drawn();
  const std::size_t needed = 3 * surface.rest.size();
  if (velocities.size() != needed)
    return usage_error("the buffer has the length " + std::to_string(velocities.size()) + ", " +
                       std::to_string(needed) + " are needed");
  if (body.bones() > 0 || body.frame() == FrameKind::kDriven)
    return usage_error(
        "velocities are those of a fixed or a free body: a driven frame has poses instead of a "
        "velocity");
  const State& state = body.state();
  Eigen::Map<Eigen::VectorXd> out(velocities.data(), static_cast<Eigen::Index>(needed));
  out.noalias() = surface.rows * state.p;
  if (body.frame() != FrameKind::kFree) return Success{};
  const RigidState rigid = body.rigid_state();
  const Pose pose = body.pose();
  const Vector3d spin = pose.rotation * rigid.spin;
  for (std::size_t i = 0; i < surface.rest.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    const Vector3d u = surface.rows.middleRows(at, 3) * state.q;
    const Vector3d arm = pose * (surface.rest[i] + u) - rigid.centre - rigid.centre_rest;
    const Vector3d relative = pose.rotation * Vector3d(out.segment<3>(at));
    out.segment<3>(at) = rigid.velocity + spin.cross(arm) + relative;
  }
  return Success{};
}

}  // namespace tremolo
