// Body: the frame that moves, and what acts through it.
#include <algorithm>
#include <cmath>
#include <string>

#include "common/number_text.h"
#include "runtime/body.h"

namespace tremolo {

void Body::begin_frame(FrameKind frame) {
  frame_ = frame;
  const std::string_view name = integrator_->name();
  energy_method_ = name == "avf" || name == "ep2" || name == "ep4";
  if (frame == FrameKind::kDriven)
    driven_ = std::make_unique<DrivenFrame>(model_->inertia_about_origin(), options_.step);
  if (frame == FrameKind::kFree) {
    free_ = std::make_unique<FreeFrame>(model_->inertia_about_centre());
    sound_rigid_ = free_->rigid();
  }
}

Pose Body::pose() const {
  if (free_) return free_->pose();
  return frame_ == FrameKind::kDriven ? driven_->pose() : Pose{};
}

Status Body::check_pose(const Pose& pose) const {
  if (frame_ == FrameKind::kFixed) return usage_error("a fixed body has no pose to set");
  if (!pose.position.allFinite() || !pose.rotation.coeffs().allFinite())
    return usage_error("the pose is not finite");
  const double length = pose.rotation.norm();
  if (!(std::abs(length - 1.0) <= 1e-6))
    return usage_error("the quaternion of the pose is of length " + number_text(length) +
                       ", must be 1");
  return Success{};
}

Status Body::set_pose(const Pose& pose) {
  if (Status s = check_pose(pose); !s) return s;
  const Pose unit{pose.position, pose.rotation.normalized()};
  if (driven_) driven_->teleport(unit);
  if (free_) {
    free_->set_pose(unit, state_.q, state_.p);
    keep_sound_state();
  }
  return Success{};
}

Status Body::move_to(const Pose& next) {
  if (frame_ != FrameKind::kDriven) return usage_error("the body's frame is not driven");
  if (Status s = check_pose(next); !s) return s;
  driven_->move_to({next.position, next.rotation.normalized()});
  return Success{};
}

Status Body::move_to(const Pose& next, const FrameMotion& motion) {
  if (frame_ != FrameKind::kDriven) return usage_error("the body's frame is not driven");
  if (Status s = check_pose(next); !s) return s;
  if (!motion.acceleration.allFinite() || !motion.spin.allFinite() || !motion.spin_rate.allFinite())
    return usage_error("the frame's motion is not finite");
  driven_->move_to({next.position, next.rotation.normalized()}, motion);
  return Success{};
}

Status Body::set_motion(const Eigen::Vector3d& velocity, const Eigen::Vector3d& spin) {
  if (!free_) return usage_error("the body is not free");
  if (!velocity.allFinite() || !spin.allFinite())
    return usage_error("the velocity or the spin is not finite");
  free_->set_motion(velocity, spin, state_.q, state_.p);
  bound_.start(total_energy());
  keep_sound_state();
  return Success{};
}

Status Body::set_gravity(const Eigen::Vector3d& gravity) {
  if (!gravity.allFinite()) return usage_error("gravity is not finite");
  if (!driven_ && !free_ && !gravity.isZero(0.0)) {
    if (model_->inertia() == nullptr)
      return usage_error(
          "gravity needs the inertia integrals, which this basis file has not; make it again with "
          "tremolo-precompute");
    if (model_->rigid_mode_count() != 0)
      return usage_error("gravity on a body that is held nowhere needs the frame kFree");
    driven_ = std::make_unique<DrivenFrame>(model_->inertia_about_origin(), options_.step);
  }
  gravity_ = gravity;
  return Success{};
}

Eigen::Vector3d Body::linear_momentum() const {
  return free_ ? free_->linear_momentum() : Eigen::Vector3d::Zero();
}

Eigen::Vector3d Body::angular_momentum() const {
  return free_ ? free_->angular_momentum() : Eigen::Vector3d::Zero();
}

// steps: as in PointForce.
Status Body::add_point_force(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force,
                             int steps) {
  // For its checks.
  if (const Result<Eigen::VectorXd> reduced = reduce_force(*model_, vertex, force); !reduced)
    return reduced.error();
  Result<VertexRows> place = model_->vertex(vertex);
  if (!place) return place.error();
  points_.push_back({signal, std::move(*place), force, steps});
  step_forces_.resize(points_.size());
  return Success{};
}

// Turns, pushes and forces of the frame in the step to come, into the step's load or, of a free
// body, into its frame.
void Body::gather_frame() {
  step_load_.coupling = nullptr;
  if (free_) return gather_on_free();
  driven_->prepare(gravity_);
  const double h = options_.step;
  for (const PointForce& point : points_) {
    const StepSignal signal =
        point.steps > 0 ? StepSignal{1.0, 1.0, 1.0} : sample_signal(point.signal, time(), h);
    if (signal.start == 0.0 && signal.average == 0.0 && signal.end == 0.0) continue;
    const Eigen::Vector3d force = driven_->mid_rotation().transpose() * point.force;
    const auto& rows = point.place.rows;
    step_load_.start.noalias() += rows.transpose() * (signal.start * force);
    step_load_.average.noalias() += rows.transpose() * (signal.average * force);
    step_load_.end.noalias() += rows.transpose() * (signal.end * force);
    step_load_.active = true;
  }
  if (driven_->push().isZero(0.0) && !driven_->turning()) return;
  step_load_.start += driven_->push();
  step_load_.average += driven_->push();
  step_load_.end += driven_->push();
  step_load_.active = true;
  if (driven_->turning() && energy_method_) step_load_.coupling = driven_.get();
}

void Body::gather_on_free() {
  std::size_t count = 0;
  for (const PointForce& point : points_) {
    const double average =
        point.steps > 0 ? 1.0 : sample_signal(point.signal, time(), options_.step).average;
    if (average != 0.0) step_forces_[count++] = {&point.place, average * point.force};
  }
  rigid_before_ = free_->rigid();
  free_->prepare(std::span(step_forces_).first(count), gravity_);
  step_load_.coupling = free_.get();
}

StepReport Body::advance() {
  const bool around = driven_ && driven_->turning() && !energy_method_;
  if (!around) return integrator_->step(state_, step_load_);
  const Eigen::VectorXd& p = momentum_;
  momentum_ = state_.p;
  driven_->half_turn(true, state_);
  const StepReport report = integrator_->step(state_, step_load_);
  if (report.converged)
    driven_->half_turn(false, state_);
  else
    state_.p = p;
  return report;
}

// Books what the frame did in a step, or undoes it if the step was not made. Returns the work of
// what is not in the step's load, J.
double Body::end_frame_step(bool made) {
  double contact = 0.0;
  if (contact_ && made) {
    const ContactAccount account = contact_account();
    contact = account.work + account.hand_work;
    sums_.hand += account.hand_work;
    sums_.contact += account.work;
    sums_.lost += account.lost;
    sums_.rubbed += account.rubbed;
    sums_.given += account.given;
    sums_.contact_error += account.surplus;
  }
  return contact + end_frame_motion(made);
}

double Body::end_frame_motion(bool made) {
  if (driven_) {
    if (!made) {
      driven_->cancel_step();
      return 0.0;
    }
    const double before = driven_->support_work() + driven_->gravity_work();
    driven_->end_step(q_before_, state_.q);
    const double work = driven_->support_work() + driven_->gravity_work() - before;
    sums_.support = driven_->support_work();
    sums_.gravity = driven_->gravity_work();
    // The load's average holds push, whose work is among what was booked.
    return work - driven_->push().dot(state_.q - q_before_);
  }
  if (!free_) return 0.0;
  if (!made) {
    free_->restore(rigid_before_);
    return 0.0;
  }
  sums_.gravity += free_->gravity_work();
  return free_->load_work() + free_->gravity_work();
}

// p: of the vibration, r.
double Body::frame_kinetic(const Eigen::VectorXd& p) const {
  return free_ ? free_->kinetic(state_.q, p) : kinetic_energy(p);
}

// vectors: x y z x y z ..., along the frame's axes, or places in it.
template <class Number>
void Body::to_world(std::span<Number> vectors, bool places) const {
  if (frame_ == FrameKind::kFixed) return;
  using Vector = Eigen::Matrix<Number, 3, 1>;
  const Pose pose = this->pose();
  const Eigen::Matrix<Number, 3, 3> turn = pose.rotation.toRotationMatrix().cast<Number>();
  const Vector shift = places ? Vector(pose.position.cast<Number>()) : Vector(Vector::Zero());
  for (std::size_t i = 0; i + 2 < vectors.size(); i += 3) {
    Eigen::Map<Vector> x(vectors.data() + i);
    x = (turn * x + shift).eval();
  }
}

template void Body::to_world(std::span<double>, bool) const;
template void Body::to_world(std::span<float>, bool) const;

Result<Eigen::Vector3d> Body::position(VertexId vertex) const {
  const Result<VertexRows> rows = model_->vertex(vertex);
  if (!rows) return rows.error();
  return pose() * Eigen::Vector3d(rows->rest + rows->rows * state_.q);
}

}  // namespace tremolo
