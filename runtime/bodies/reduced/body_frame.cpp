// Body: its moving frame, and the loads that act through the frame.
#include <algorithm>
#include <cmath>
#include <string>

#include "common/mesh/surface_mesh.h"
#include "common/mesh/tet_mesh.h"
#include "common/overflow.h"
#include "common/text.h"
#include "runtime/body.h"

namespace tremolo {
namespace {

Status check_frame_motion(const FrameMotion& motion) {
  if (motion.acceleration.allFinite() && motion.spin.allFinite() && motion.spin_rate.allFinite())
    return Success{};
  return usage_error("the frame's motion is not finite");
}

}  // namespace

void Body::begin_frame(FrameKind frame) {
  frame_ = frame;
  energy_method_ = is_energy_method(integrator_->name());
  if (const InertiaIntegrals* inertia = model_->inertia()) {
    const BoundingBox box = bounding_box(model_->surface().rest);
    bound_.set_rest(energy_at_rest(inertia->mass, (box.high - box.low).maxCoeff(), options_.step));
  }
  if constexpr (kHasFrames) {
    if (frame == FrameKind::kDriven) begin_driven();
    if (frame == FrameKind::kFree) {
      free_ = std::make_unique<FreeFrame>(model_->inertia_about_centre());
      sound_rigid_ = free_->rigid();
    }
  }
}

void Body::begin_driven() {
  if constexpr (kHasFrames)
    driven_ = std::make_unique<DrivenFrame>(model_->inertia_about_origin(), options_.step);
}

Pose Body::pose(std::size_t bone) const {
  if (free_) return free_->pose();
  return frame() == FrameKind::kDriven ? driven_->pose(bone) : Pose{};
}

Status Body::check_pose(const Pose& pose) const {
  if (frame() == FrameKind::kFixed) return usage_error("a fixed body has no pose to set");
  if (!pose.position.allFinite() || !pose.rotation.coeffs().allFinite())
    return usage_error("the pose is not finite");
  if (const double far = pose.position.lpNorm<Eigen::Infinity>(); overflows(far))
    return usage_error(overflow_text("the position", far, "m"));
  const double length = pose.rotation.norm();
  if (!(std::abs(length - 1.0) <= 1e-6))
    return usage_error("the quaternion of the pose is of length " + number_text(length) +
                       ", must be 1");
  return Success{};
}

Result<std::pair<std::size_t, std::size_t>> Body::bones_of(std::size_t bone) const {
  if (bone == kAllBones) return std::pair(std::size_t{0}, driven_ ? driven_->bones() : 0);
  if (bone >= bones())
    return usage_error("the body has " + std::to_string(bones()) + " bones, no bone " +
                       std::to_string(bone));
  return std::pair(bone, bone + 1);
}

Status Body::set_pose(const Pose& pose, std::size_t bone) {
  const auto range = bones_of(bone);
  if (!range) return range.error();
  if (Status s = check_pose(pose); !s) return s;
  const Pose unit{pose.position, pose.rotation.normalized()};
  moved_ = true;
  for (std::size_t b = range->first; b < range->second; ++b) driven_->teleport(unit, b);
  if (free_) {
    free_->set_pose(unit, state_.q, state_.p);
    keep_sound_state();
  }
  return Success{};
}

Status Body::move_to(const Pose& next, const std::optional<FrameMotion>& motion, std::size_t bone) {
  if (frame() != FrameKind::kDriven) return usage_error("the body's frame is not driven");
  const auto range = bones_of(bone);
  if (!range) return range.error();
  if (Status s = check_pose(next); !s) return s;
  if (motion)
    if (Status s = check_frame_motion(*motion); !s) return s;
  const Pose unit{next.position, next.rotation.normalized()};
  for (std::size_t b = range->first; b < range->second; ++b) {
    if (motion)
      driven_->move_to(unit, *motion, b);
    else
      driven_->move_to(unit, b);
  }
  return Success{};
}

Status Body::set_motion(const Eigen::Vector3d& velocity, const Eigen::Vector3d& spin) {
  if (!free_) return usage_error("the body is not free");
  if (!velocity.allFinite() || !spin.allFinite())
    return usage_error("the velocity or the spin is not finite");
  if (const Status s = check_start_size(Eigen::Vector3d::Zero(), velocity, spin); !s)
    return usage_error(s.error().message);
  free_->set_motion(velocity, spin, state_.q, state_.p);
  moved_ = true;
  bound_.start(total_energy());
  keep_sound_state();
  return Success{};
}

Status Body::set_gravity(const Eigen::Vector3d& gravity) {
  if (!gravity.allFinite()) return usage_error("gravity is not finite");
  if (const double most = gravity.lpNorm<Eigen::Infinity>(); overflows(most))
    return usage_error(overflow_text("gravity", most, "m/s^2"));
  if (!driven_ && !free_ && !gravity.isZero(0.0)) {
    if (model_->inertia() == nullptr)
      return usage_error(
          "gravity needs the inertia integrals, which this basis file has not; make it again with "
          "tremolo-precompute");
    if (model_->rigid_mode_count() != 0)
      return usage_error(
          "gravity on a body that is held nowhere needs a free frame: kind = \"free\"");
    begin_driven();
  }
  gravity_ = gravity;
  return Success{};
}

BodyMomentum Body::momentum() const {
  if (!free_) return {};
  return {free_->linear_momentum(), free_->angular_momentum()};
}

// steps: as in PointForce.
Status Body::add_point_force(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force,
                             int steps) {
  // Only for its checks.
  if (const Result<Eigen::VectorXd> reduced = reduce_force(*model_, vertex, force); !reduced)
    return reduced.error();
  Result<VertexRows> place = model_->vertex(vertex);
  if (!place) return place.error();
  PointForce point{signal, std::move(*place), force, steps};
  if (skin_) {
    const Result<std::span<const double>> weights = weights_of(vertex);
    if (!weights) return weights.error();
    point.weights = Eigen::VectorXd::Map(weights->data(), std::ssize(*weights));
  }
  points_.push_back(std::move(point));
  step_forces_.resize(points_.size());
  return Success{};
}

StepPoses Body::step_poses() const {
  if (driven_ && frame() == FrameKind::kDriven) return {driven_->pose(), driven_->next_pose()};
  if (!free_) return {};
  const RigidState& rigid = free_->rigid();
  const double h = options_.step;
  Pose end;
  end.rotation = rigid.rotation * turn_by(h * rigid.spin);
  const Eigen::Vector3d centre = rigid.centre + h * rigid.velocity;
  end.position = centre - end.rotation * free_->mesh_centre();
  return {free_->pose(), end};
}

// Adds rotations, pushes and forces of the frame in the next step to the step's load or, for a free
// body, to its frame.
void Body::gather_frame() {
  step_load_.coupling = nullptr;
  if (free_) return gather_on_free();
  driven_->prepare(gravity_);
  const double h = options_.step;
  for (const PointForce& point : points_) {
    const StepSignal signal =
        point.steps > 0 ? StepSignal{1.0, 1.0, 1.0} : sample_signal(point.signal, time(), h);
    if (signal.start == 0.0 && signal.average == 0.0 && signal.end == 0.0) continue;
    Eigen::Matrix3d turn = driven_->mid_rotation();
    if (skin_) {
      turn.setZero();
      for (std::size_t b = 0; b < bones(); ++b)
        turn += point.weights[static_cast<Eigen::Index>(b)] * driven_->mid_rotation(b);
    }
    const Eigen::Vector3d force = turn.transpose() * point.force;
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

// Adds the frame's work in a step to the sums, or cancels it if the step failed. Returns the work
// of forces that are not in the step's load, J.
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
    // The load's average contains push, whose work is already in the sums.
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

Result<std::span<const double>> Body::weights_of(VertexId vertex) const {
  const auto row = [](const BoneWeights& weights, std::size_t at) {
    const auto count = static_cast<std::size_t>(weights.cols());
    return std::span(weights.data() + at * count, count);
  };
  if (const auto at = find_vertex(model_->surface().vertex_ids, vertex))
    return row(skin_->surface, *at);
  const Result<const VertexBlock*> interior = model_->interior();
  if (!interior) return interior.error();
  if (const auto at = find_vertex((*interior)->vertex_ids, vertex);
      at && std::cmp_less(*at, skin_->interior.rows()))
    return row(skin_->interior, *at);
  return usage_error("the skin has no weights of vertex " + std::to_string(vertex));
}

std::span<const BoneMap> Body::bone_maps() const {
  for (std::size_t b = 0; b < bones(); ++b) bone_maps_[b] = bone_map(driven_->pose(b));
  return bone_maps_;
}

Eigen::VectorXd Body::gravity_force() const {
  if (!driven_) return Eigen::VectorXd::Zero(model_->modes());
  return driven_->gravity_force(gravity_);
}

Result<Eigen::Matrix3d> Body::turn_at(VertexId vertex) const {
  if (!skin_) return pose().rotation.toRotationMatrix();
  const Result<std::span<const double>> weights = weights_of(vertex);
  if (!weights) return weights.error();
  return Eigen::Matrix3d(blended(*weights, bone_maps()).leftCols<3>());
}

// vectors: x y z x y z ..., along the frame's axes, or positions in it.
template <class Number>
void Body::to_world(std::span<Number> vectors, bool places, BoneWeights Skin::*weights) const {
  if (frame() == FrameKind::kFixed) return;
  if (skin_)
    return places ? skin_places((*skin_).*weights, bone_maps(), vectors)
                  : skin_normals((*skin_).*weights, bone_maps(), vectors);
  using Vector = Eigen::Matrix<Number, 3, 1>;
  const Pose pose = this->pose();
  const Eigen::Matrix<Number, 3, 3> turn = pose.rotation.toRotationMatrix().cast<Number>();
  const Vector shift = places ? Vector(pose.position.cast<Number>()) : Vector(Vector::Zero());
  for (std::size_t i = 0; i + 2 < vectors.size(); i += 3) {
    Eigen::Map<Vector> x(vectors.data() + i);
    x = (turn * x + shift).eval();
  }
}

template void Body::to_world(std::span<double>, bool, BoneWeights Skin::*) const;
template void Body::to_world(std::span<float>, bool, BoneWeights Skin::*) const;

Result<Eigen::Vector3d> Body::position(VertexId vertex) const {
  const Result<VertexRows> rows = model_->vertex(vertex);
  if (!rows) return rows.error();
  const Result<Eigen::Vector3d> moved = displacement(vertex);
  if (!moved) return moved.error();
  const Eigen::Vector3d y = rows->rest + *moved;
  if (!skin_) return pose() * y;
  const Result<std::span<const double>> weights = weights_of(vertex);
  if (!weights) return weights.error();
  const BoneMap map = blended(*weights, bone_maps());
  return Eigen::Vector3d(map.leftCols<3>() * y + map.col(3));
}

}  // namespace tremolo
