#include "runtime/tets/solve/rigid_balance.h"

#include "runtime/tets/elements/element_turn.h"

namespace tremolo {
namespace {

Eigen::Index rigid_at(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

}  // namespace

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
