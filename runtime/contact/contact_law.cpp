#include "runtime/contact/contact_law.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
namespace {

using Eigen::Matrix3d;
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
                           const ContactWay& way, double h, const ContactHeld& held) {
  ContactForce contact;
  contact.distance = d1;
  contact.energy = law.energy(d1);
  const MeanForce mean = mean_force(law.stiffness, law.margin - d0, law.margin - d1);
  if (mean.value == 0.0 && held.grinding == 0.0) return contact;
  contact.acts = true;

  const Vector3d &n = held.normal, &p = way.path, &w = way.bend, over = p - w;
  // The correction c, and what it changes by. Below this length the change of distance is rounding.
  const double length2 = p.squaredNorm() + w.squaredNorm();
  const bool moves = length2 > 1e-18 * law.margin * law.margin;
  const double shorter2 = moves ? 1.0 / length2 : 0.0;
  const double c = (d1 - d0 - n.dot(over)) * shorter2;
  const Vector3d point_normal = n + c * p, bend_normal = n - c * w;
  const Vector3d by_path = shorter2 * (n + 2.0 * c * p), by_bend = shorter2 * (n - 2.0 * c * w);

  const double speed = (d1 - d0) / h;
  const double least = law.restitution * law.restitution;
  const double along = std::clamp(speed / law.rebound_speed, 0.0, 1.0);
  const double share = 1.0 - (1.0 - least) * along * along * (3.0 - 2.0 * along);
  contact.pressure = mean.value;
  contact.lost = (1.0 - share) * std::max(0.0, e0 - contact.energy);
  const double s = share * mean.value;
  const double fall = share * mean.fall + mean.value * (1.0 - least) * 6.0 * along * (1.0 - along) /
                                              (law.rebound_speed * h);
  contact.grinding = law.friction * s * point_normal.norm();

  // Across the normal; below the slip speed in proportion to the slip.
  const Matrix3d across = Matrix3d::Identity() - n * n.transpose() / n.squaredNorm();
  const Vector3d slip = across * over;
  const double length = slip.norm(), whole = h * law.slip_speed;
  const bool slides = length > whole;
  const double rubbing = held.grinding * (slides ? 1.0 / length : (2.0 - length / whole) / whole);
  contact.rubbed = rubbing * slip.squaredNorm();
  Matrix3d drag = rubbing * across;
  if (length > 0.0) {
    const double shorter = slides ? 1.0 / (length * length) : 1.0 / (whole * whole);
    drag -= (held.grinding * shorter / length) * slip * slip.transpose();
  }

  contact.force = s * point_normal - rubbing * slip;
  contact.slope.by_distance = fall * point_normal - (s * shorter2) * p;
  contact.slope.by_path = drag + s * p * by_path.transpose();
  contact.slope.by_path.diagonal().array() -= s * c;
  contact.slope.by_bend = -drag - s * p * by_bend.transpose();
  contact.bend_force = s * bend_normal - rubbing * slip;
  contact.bend_slope.by_distance = fall * bend_normal + (s * shorter2) * w;
  contact.bend_slope.by_path = drag - s * w * by_path.transpose();
  contact.bend_slope.by_bend = -drag + s * w * by_bend.transpose();
  contact.bend_slope.by_bend.diagonal().array() += s * c;
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
  const ContactWay way{end - start.place};
  if (renew > 0.0) held.normal = signed_distance(collider.shape, 0.5 * (start.place + end)).normal;
  ContactForce contact =
      contact_force(law, start.distance, start.energy, found.distance, way, h, held);
  if (renew > 0.0) {
    held.grinding += renew * (contact.grinding - held.grinding);
    contact = contact_force(law, start.distance, start.energy, found.distance, way, h, held);
  }
  if (!contact.acts) return contact;
  const Matrix3d turn = mid_rotation(collider).toRotationMatrix();
  contact.force = turn * contact.force;
  Matrix3d& slope = contact.slope.by_path;
  slope += contact.slope.by_distance * found.normal.transpose();
  slope = turn * slope * collider.end.rotation.toRotationMatrix().transpose();
  return contact;
}

}  // namespace tremolo
