#include "runtime/contact/contact_law.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
namespace {

using Eigen::Vector3d;

Vector3d into_frame(const Pose& pose, const Vector3d& x) {
  return pose.rotation.conjugate() * (x - pose.position);
}

// (psi(d0) - psi(d1)) / (d1 - d0) and how it falls with d1. a, b: depths of the ends, M - d, which
// may be negative.
struct MeanForce {
  double value = 0.0;
  double fall = 0.0;
};

MeanForce mean_force(double k, double a, double b) {
  if (a <= 0.0 && b <= 0.0) return {};
  const double third = k / 3.0;
  if (a >= 0.0 && b >= 0.0) return {third * (a * a + a * b + b * b), third * (a + 2.0 * b)};
  // One end is outside: the cube of the other over the whole way, b - a.
  if (b > 0.0) {
    const double way = b - a, cube = b * b * b;
    return {third * cube / way, third * (3.0 * b * b * way - cube) / (way * way)};
  }
  const double way = a - b;
  return {third * a * a * a / way, third * a * a * a / (way * way)};
}

// The mean rotation of the collider's frame in the step.
Eigen::Quaterniond mid_rotation(const PlacedCollider& collider) {
  Eigen::Quaterniond end = collider.end.rotation;
  if (collider.start.rotation.dot(end) < 0.0) end.coeffs() = -end.coeffs();
  return Eigen::Quaterniond(collider.start.rotation.coeffs() + end.coeffs()).normalized();
}

}  // namespace

ContactStart contact_start(const ContactLaw& law, const PlacedCollider& collider,
                           const Vector3d& x) {
  ContactStart start;
  start.place = into_frame(collider.start, x);
  const CollisionDistance found = signed_distance(collider.shape, start.place);
  start.distance = found.distance;
  start.normal = found.normal;
  start.energy = law.energy(start.distance);
  return start;
}

ContactForce contact_force(const ContactLaw& law, double d0, double e0, double d1,
                           const Vector3d& way, double h, const ContactHeld& held) {
  ContactForce contact;
  contact.distance = d1;
  contact.energy = law.energy(d1);
  const MeanForce mean = mean_force(law.stiffness, law.margin - d0, law.margin - d1);
  if (mean.value == 0.0 && held.grinding == 0.0) return contact;
  contact.acts = true;

  // n = held + bend way. Below this length the change of distance is rounding.
  Vector3d normal = held.normal, bent = Vector3d::Zero();
  Eigen::Matrix3d turning = Eigen::Matrix3d::Zero();
  if (const double length2 = way.squaredNorm(); length2 > 1e-18 * law.margin * law.margin) {
    const double bend = (d1 - d0 - held.normal.dot(way)) / length2;
    normal += bend * way;
    bent = way / length2;
    turning = -bent * (held.normal + 2.0 * bend * way).transpose();
    turning.diagonal().array() += bend;
  }

  const double speed = (d1 - d0) / h;
  const double least = law.restitution * law.restitution;
  const double along = std::clamp(speed / law.rebound_speed, 0.0, 1.0);
  const double share = 1.0 - (1.0 - least) * along * along * (3.0 - 2.0 * along);
  contact.pressure = mean.value;
  contact.lost = (1.0 - share) * std::max(0.0, e0 - contact.energy);
  const double fall = share * mean.fall + mean.value * (1.0 - least) * 6.0 * along * (1.0 - along) /
                                              (law.rebound_speed * h);
  contact.grinding = law.friction * share * mean.value * normal.norm();

  // Across the normal; below the slip speed in proportion to the slip.
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() -
                                 held.normal * held.normal.transpose() / held.normal.squaredNorm();
  const Vector3d slip = across * way;
  const double length = slip.norm(), whole = h * law.slip_speed;
  const bool slides = length > whole;
  const double rubbing = held.grinding * (slides ? 1.0 / length : (2.0 - length / whole) / whole);
  contact.rubbed = rubbing * slip.squaredNorm();
  contact.force = share * mean.value * normal - rubbing * slip;
  contact.fall = fall * normal - share * mean.value * bent;
  contact.stiffness = rubbing * across - share * mean.value * turning;
  if (length > 0.0) {
    const double shorter = slides ? 1.0 / (length * length) : 1.0 / (whole * whole);
    contact.stiffness -= (held.grinding * shorter / length) * slip * slip.transpose();
  }
  return contact;
}

ContactForce contact_force(const ContactLaw& law, const PlacedCollider& collider,
                           const ContactStart& start, const Vector3d& x1, double h, double renew,
                           ContactHeld& held) {
  const Vector3d end = into_frame(collider.end, x1);
  const CollisionDistance found = signed_distance(collider.shape, end);
  if (start.distance >= law.margin && found.distance >= law.margin && held.grinding == 0.0) {
    ContactForce apart;
    apart.distance = found.distance;
    return apart;
  }
  const Vector3d way = end - start.place;
  if (renew > 0.0) held.normal = signed_distance(collider.shape, 0.5 * (start.place + end)).normal;
  ContactForce contact =
      contact_force(law, start.distance, start.energy, found.distance, way, h, held);
  if (renew > 0.0) {
    held.grinding += renew * (contact.grinding - held.grinding);
    contact = contact_force(law, start.distance, start.energy, found.distance, way, h, held);
  }
  if (!contact.acts) return contact;
  const Eigen::Matrix3d turn = mid_rotation(collider).toRotationMatrix();
  contact.force = turn * contact.force;
  contact.stiffness += contact.fall * found.normal.transpose();
  contact.stiffness =
      turn * contact.stiffness * collider.end.rotation.toRotationMatrix().transpose();
  return contact;
}

}  // namespace tremolo
