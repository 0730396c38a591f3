#include "runtime/contact/solve/make_joint.h"

#include <cmath>
#include <limits>

#include "runtime/contact/contact_values.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d place_now(const ContactBody& body, const VertexRows& place) {
  return body.pose() * Vector3d(place.rest + place.rows * body.state().q);
}

// h omega of the two masses on a stiff joint, same as for a pin.
constexpr double kTurn = 30.0;

Status set_springs(Joint& joint, const ContactBody& first, const ContactBody& second,
                   const JointOptions& options) {
  joint.length = options.length;
  joint.touch = options.touch;
  for (const double value : {options.stiffness.value_or(0.0), options.damping, joint.length})
    if (!std::isfinite(value) || value < 0.0)
      return usage_error("a joint's stiffness, damping and length are finite and not negative");
  const double h = first.step_size();
  const double lightness = 1.0 / first.mass_at(joint.first) + 1.0 / second.mass_at(joint.second);
  if (!options.stiffness && !(lightness > 0.0))
    return usage_error("neither place moves: there is nothing to join");
  const HandSpring most{kTurn * kTurn / (lightness * h * h), 2.0 * kTurn / (lightness * h)};
  joint.stiffness = options.stiffness.value_or(most.stiffness);
  joint.damping = options.stiffness ? options.damping : most.damping;
  limit_spring(most, h, joint.stiffness, joint.damping);
  return Success{};
}

Status check_bodies(const ContactBody& first, const ContactBody& second) {
  if (&first == &second) return usage_error("a joint needs two bodies");
  if (first.contact() == nullptr || second.contact() == nullptr)
    return usage_error("joints need set_contact() of both bodies first");
  if (first.step_size() != second.step_size())
    return usage_error("bodies that are joined have one step size");
  return Success{};
}

}  // namespace

double joint_distance(const Joint& joint, const ContactBody& first, const ContactBody& second) {
  return (place_now(first, joint.first) - place_now(second, joint.second)).norm();
}

Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         VertexId to, const JointOptions& options) {
  if (Status s = check_bodies(first, second); !s) return s.error();
  Joint joint;
  if (Status s = take(joint.first, first.model().vertex(at)); !s) return s.error();
  if (Status s = take(joint.second, second.model().vertex(to)); !s) return s.error();
  if (Status s = set_springs(joint, first, second, options); !s) return s.error();
  return joint;
}

Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         const JointOptions& options) {
  if (Status s = check_bodies(first, second); !s) return s.error();
  Joint joint;
  if (Status s = take(joint.first, first.model().vertex(at)); !s) return s.error();
  const Pose pose = second.pose();
  const Vector3d place =
      pose.rotation.conjugate() * (place_now(first, joint.first) - pose.position);
  const Eigen::VectorXd& q = second.state().q;
  double nearest = std::numeric_limits<double>::infinity();
  const VertexBlock& boundary = second.model().surface();
  for (std::size_t i = 0; i < boundary.rest.size(); ++i) {
    const auto rows = boundary.rows.middleRows(3 * i, 3);
    const Vector3d there = boundary.rest[i] + rows * q;
    if ((there - place).squaredNorm() >= nearest) continue;
    nearest = (there - place).squaredNorm();
    joint.second = {boundary.rest[i] + (place - there), rows};
  }
  if (Status s = set_springs(joint, first, second, options); !s) return s.error();
  return joint;
}

}  // namespace tremolo
