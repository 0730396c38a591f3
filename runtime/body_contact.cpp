// Body: colliders.
#include "runtime/body.h"

namespace tremolo {

Status Body::set_contact(const ContactOptions& options) {
  if (model_->inertia() == nullptr)
    return usage_error(
        "contact needs the inertia integrals, which this basis file has not; make it again with "
        "tremolo-precompute");
  if (options.points < 1 || !(options.margin > 0.0) || !(options.stiffness > 0.0) ||
      !std::isfinite(options.margin) || !std::isfinite(options.stiffness))
    return usage_error("contact needs at least one point, a margin and a stiffness above zero");
  if (!energy_method_ && frame_ != FrameKind::kFixed)
    return usage_error("contact goes with avf, ep2 and ep4");
  contact_ = std::make_unique<ContactStep>(model_, options_, options, model_->inertia()->mass);
  return Success{};
}

// Where the frame is at both ends of the step, as far as that is known.
StepPoses Body::step_poses() const {
  if (driven_ && frame_ == FrameKind::kDriven) return {driven_->pose(), driven_->next_pose()};
  if (!free_) return {};
  const RigidState& rigid = free_->rigid();
  const double h = options_.step;
  Pose end;
  end.rotation = rigid.rotation * turn_by(h * rigid.spin);
  const Eigen::Vector3d centre = rigid.centre + h * rigid.velocity;
  end.position = centre - end.rotation * free_->mesh_centre();
  return {free_->pose(), end};
}

// The step with contact where something is near.
StepReport Body::advance_among(std::span<const PlacedCollider> colliders) {
  if (!contact_ || !contact_->gather(colliders, step_poses(), state_.q, state_.p)) {
    if (contact_) contact_->reset();
    return advance();
  }
  const StepReport report = contact_->step(state_, step_load_, free_.get());
  if (report.converged) integrator_->reset();
  return report;
}

}  // namespace tremolo
