#include "runtime/bodies/tets/solve/rigid_balance.h"

#include <Eigen/Geometry>

#include "runtime/bodies/tets/elements/element_turn.h"

namespace tremolo {
namespace {

Eigen::Index rigid_at(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

// Inertia about a point, from that about the centre.
Eigen::Matrix3d inertia_about(const TetModel& model, const RigidInertia& rigid,
                              const Eigen::Vector3d& point) {
  const Eigen::Vector3d arm = rigid.centre - point;
  return rigid.inertia +
         model.mass() * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
}

// J^-1 L, refined once: the inverse alone may have ten digits only.
Eigen::Vector3d spin_of(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& momentum) {
  const Eigen::Matrix3d inverse = bounded_inverse(inertia);
  const Eigen::Vector3d w = inverse * momentum;
  return w + inverse * (momentum - inertia * w);
}

}  // namespace

RigidFreedom rigid_freedom(const TetModel& model) {
  // Fixed points nearer to each other, or to a line, than this fraction of the mesh's size count as
  // one.
  constexpr double kSamePlace = 1e-9;
  const double least = kSamePlace * model.rest_box().diagonal();
  RigidFreedom freedom;
  const auto place = [&](std::size_t i) { return model.rest().segment<3>(rigid_at(i)); };
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < model.vertices(); ++i) {
    // A vertex without a tetrahedron is marked as fixed, too.
    if (model.held()[i] == 0 || model.masses()[model.pattern()->diagonal(i)] == 0.0) continue;
    switch (freedom.kind) {
      case RigidFreedom::Kind::kAll:
        freedom = {RigidFreedom::Kind::kAboutPoint, i, i};
        break;
      case RigidFreedom::Kind::kAboutPoint:
        axis = place(i) - place(freedom.pivot);
        if (axis.norm() <= least) break;
        axis.normalize();
        freedom = {RigidFreedom::Kind::kAboutAxis, freedom.pivot, i};
        break;
      default:
        if (axis.cross(place(i) - place(freedom.pivot)).norm() <= least) break;
        freedom.kind = RigidFreedom::Kind::kNone;
        return freedom;
    }
  }
  return freedom;
}

void rigid_part(const TetModel& model, const RigidFreedom& freedom, const Eigen::VectorXd& x,
                const Eigen::VectorXd& v, Eigen::VectorXd& work, Eigen::VectorXd& rigid) {
  using Kind = RigidFreedom::Kind;
  if (freedom.kind == Kind::kNone) {
    rigid.setZero();
    return;
  }
  const RigidInertia body = rigid_inertia(model, x, work);
  const Eigen::Vector3d about =
      freedom.kind == Kind::kAll ? body.centre : x.segment<3>(rigid_at(freedom.pivot));
  model.mass_times(v, work);
  Eigen::Vector3d shift = Eigen::Vector3d::Zero(), momentum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < model.nodes(); ++i) {
    if (freedom.kind == Kind::kAll) shift += work.segment<3>(rigid_at(i)) / model.mass();
    momentum += (x.segment<3>(rigid_at(i)) - about).cross(work.segment<3>(rigid_at(i)));
  }
  const Eigen::Matrix3d inertia = inertia_about(model, body, about);
  Eigen::Vector3d spin;
  if (freedom.kind == Kind::kAboutAxis) {
    const Eigen::Vector3d axis = (x.segment<3>(rigid_at(freedom.axis_end)) - about).normalized();
    const double along = axis.dot(inertia * axis);
    spin = along > 0.0 ? Eigen::Vector3d(axis * (axis.dot(momentum) / along))
                       : Eigen::Vector3d::Zero();
  } else {
    spin = spin_of(inertia, momentum);
  }
  for (std::size_t i = 0; i < model.nodes(); ++i)
    rigid.segment<3>(rigid_at(i)) =
        shift + spin.cross(Eigen::Vector3d(x.segment<3>(rigid_at(i)) - about));
}

RigidInertia rigid_inertia(const TetModel& model, const Eigen::VectorXd& x, Eigen::VectorXd& work) {
  RigidInertia rigid;
  model.mass_times(x, work);
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < model.nodes(); ++i) {
    rigid.centre += work.segment<3>(rigid_at(i)) / model.mass();
    second += work.segment<3>(rigid_at(i)) * x.segment<3>(rigid_at(i)).transpose();
  }
  second -= model.mass() * rigid.centre * rigid.centre.transpose();
  rigid.inertia = trace_minus(0.5 * (second + second.transpose()));
  return rigid;
}

void restore_spin(const TetModel& model, const Eigen::Vector3d& spin, const Eigen::VectorXd& x,
                  Eigen::VectorXd& v, Eigen::VectorXd& work) {
  const RigidInertia rigid = rigid_inertia(model, x, work);
  const Eigen::Vector3d w = bounded_inverse(rigid.inertia) * spin;
  for (std::size_t i = 0; i < model.nodes(); ++i)
    v.segment<3>(rigid_at(i)) += w.cross(x.segment<3>(rigid_at(i)) - rigid.centre);
}

bool rigid_correction(const TetModel& model, const Eigen::VectorXd& x,
                      const Eigen::VectorXd& residual, double rate, Eigen::VectorXd& motion) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  const RigidInertia rigid = rigid_inertia(model, x, motion);
  double scale = 0.0;
  for (std::size_t i = 0; i < model.nodes(); ++i) {
    const Eigen::Vector3d force = residual.segment<3>(rigid_at(i));
    sum += force;
    torque += (x.segment<3>(rigid_at(i)) - rigid.centre).cross(force);
    scale += force.norm();
  }
  if (!(sum.norm() > 1e-15 * scale) && !(torque.norm() > 1e-15 * scale)) return false;
  const Eigen::Vector3d shift = -sum / (rate * model.mass());
  const Eigen::Vector3d turn = -bounded_inverse(rigid.inertia) * torque / rate;
  for (std::size_t i = 0; i < model.nodes(); ++i)
    motion.segment<3>(rigid_at(i)) = shift + turn.cross(x.segment<3>(rigid_at(i)) - rigid.centre);
  return true;
}

}  // namespace tremolo
