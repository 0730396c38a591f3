#include "runtime/scene/scene_start.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "common/text.h"
#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/load.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

constexpr double kMostLooks = 1e6;  // steps whose accelerations are checked before a run

std::string acceleration_text(double acceleration) {
  return number_text(acceleration) + " m/s^2 (" + number_text(acceleration / 9.81) + " g)";
}

Error jump_error(const MotionPath& path, double step, double reach) {
  const double t = path.refused_jump();
  const std::size_t piece = path.piece(t);
  const Pose before = path.pose_in(piece - 1, t), after = path.pose_in(piece, t);
  const double way = (after.position - before.position).norm();
  const double angle = turn_of(before.rotation.conjugate() * after.rotation).norm();
  return content_error("its pose jumps at t = " + number_text(t) + " s by " + number_text(way) +
                       " m and " + number_text(angle * 180.0 / std::numbers::pi) +
                       " degrees: within a step that is an acceleration of " +
                       acceleration_text((way + angle * reach) / (step * step)) +
                       "; say jumps = \"smooth\" to spread it over smooth-time, or \"teleport\" "
                       "to put the body elsewhere without a kick");
}

// In the frame, N in the directions of q: of gravity, r.
Eigen::VectorXd push_of_gravity(const Model& model, const Pose& pose, const Eigen::Vector3d& g) {
  if (g.isZero(0.0)) return Eigen::VectorXd::Zero(model.modes());
  return model.inertia_about_origin()->s.transpose() * (pose.rotation.conjugate() * g);
}

}  // namespace

Result<DefaultLoad> forces_of(const SceneLoad& load, const Model& model) {
  if (load.at.empty()) {
    DefaultLoad own = model.default_load();
    if (own.vertices.empty())
      return content_error("the model has no load of its own; name one with `at` and `force`");
    for (Eigen::Vector3d& force : own.forces) force *= load.scale;
    return own;
  }
  const Result<std::vector<VertexId>> vertices = vertices_of(load.at, model);
  if (!vertices) return Error{vertices.error().kind, "at: " + vertices.error().message};
  DefaultLoad forces = shared_by_area(*vertices, load.scale * load.force, model);
  const Result<Eigen::VectorXd> reduced = reduce_load(model, forces);
  if (!reduced) return content_error(reduced.error().message);
  // A rigid body has no coordinates: a load moves its frame.
  const bool still = model.modes() > 0 ? reduced->isZero(0.0) : load.force.isZero(0.0);
  if (load.scale != 0.0 && still)
    return content_error("at = \"" + load.at +
                         "\": no vertex there moves (they are fixed or belong to no tetrahedron), "
                         "or the force is zero");
  return forces;
}

Status add_loads(const std::vector<SceneLoad>& loads, ContactBody& body) {
  for (const SceneLoad& load : loads) {
    if (load.signal.kind == SignalKind::kNone) continue;
    const Result<DefaultLoad> forces = forces_of(load, body.model());
    if (!forces) return forces.error();
    Signal signal = load.signal;
    signal.table = load.table.get();
    if (Status s = body.add_load(signal, *forces); !s) return s;
  }
  return Success{};
}

Status settle(const SceneBody& wanted, const Eigen::Vector3d& gravity, ContactBody& body) {
  const Model& model = body.model();
  Eigen::VectorXd force = push_of_gravity(model, body.pose(), gravity);
  if (body.bones() > 0) force = body.gravity_force();
  for (const SceneLoad& load : wanted.loads) {
    Signal signal = load.signal;
    signal.table = load.table.get();
    const double now = sample_signal(signal, 0.0, body.options().step).start;
    if (now == 0.0) continue;
    Result<DefaultLoad> forces = forces_of(load, model);
    if (!forces) return forces.error();
    for (std::size_t i = 0; i < forces->vertices.size(); ++i) {
      Eigen::Vector3d& one = forces->forces[i];
      if (body.bones() == 0) {
        one = body.pose().rotation.conjugate() * one;
        continue;
      }
      const Result<Eigen::Matrix3d> turn = body.turn_at(forces->vertices[i]);
      if (!turn) return turn.error();
      one = (turn->transpose() * one).eval();
    }
    const Result<Eigen::VectorXd> reduced = reduce_load(model, *forces, now);
    if (!reduced) return reduced.error();
    force += *reduced;
  }
  const Result<Eigen::VectorXd> q = standing_shape(model.potential(), force);
  if (!q) return Error{q.error().kind, "start = \"static\": " + q.error().message};
  return body.set_state(*q, Eigen::VectorXd::Zero(model.modes()));
}

FrameMotion frame_motion(const MotionPath& path, std::size_t piece, std::int64_t k, double step) {
  const auto pose = [&](std::int64_t node) {
    return path.pose_in(piece, static_cast<double>(node) * step);
  };
  return motion_between(pose(k - 1), pose(k), pose(k + 1), pose(k + 2), step);
}

Status check_accelerations(const SceneBody& wanted, const MotionPath& path, const Scene& scene,
                           double reach) {
  if (path.refused_jump() < kForEver) return jump_error(path, scene.step, reach);
  if (path.still()) return Success{};
  const double h = scene.step;
  const double looks = std::min(scene.duration / h, kMostLooks);
  for (std::int64_t k = 0; static_cast<double>(k) < looks; ++k) {
    const double t = static_cast<double>(k) * h;
    const FrameMotion motion = frame_motion(path, path.piece(t + 0.5 * h), k, h);
    const double most =
        motion.acceleration.norm() + reach * (motion.spin_rate.norm() + motion.spin.squaredNorm());
    if (most <= wanted.acceleration_limit) continue;
    return content_error("its motion accelerates it at t = " + number_text(t) + " s by up to " +
                         acceleration_text(most) + ", above its acceleration-limit of " +
                         number_text(wanted.acceleration_limit) +
                         " m/s^2: do its poses jump? A time that stands twice marks a jump, and "
                         "jumps = \"smooth\" or \"teleport\" says how it is meant");
  }
  return Success{};
}

}  // namespace tremolo
