#include "runtime/contact/contact_law.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/passage.h"

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

MeanForce mean_of(const ContactLaw& law, const ContactGap& gap) {
  return mean_force(law.stiffness, law.margin - gap.d0, law.margin - gap.d1);
}

// c, and 1/(|p|^2 + |w|^2), 0 where the change of distance is rounding.
struct Correction {
  double c = 0.0;
  double shorter2 = 0.0;
};

Correction correct(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                   const Vector3d& normal) {
  const double length2 = way.path.squaredNorm() + way.bend.squaredNorm();
  if (!(length2 > 1e-18 * law.margin * law.margin)) return {};
  const double shorter2 = 1.0 / length2;
  return {(gap.d1 - gap.d0 - normal.dot(way.path - way.bend)) * shorter2, shorter2};
}

// The share of the mean force that pushes, and how it falls with d1.
struct Outgoing {
  double share = 1.0;
  double fall = 0.0;
};

Outgoing outgoing(const ContactLaw& law, const ContactGap& gap, double h) {
  const double speed = (gap.d1 - gap.d0) / h;
  const double taken = 1.0 - law.restitution * law.restitution;
  const double along = std::clamp(speed / law.rebound_speed, 0.0, 1.0);
  return {1.0 - taken * along * along * (3.0 - 2.0 * along),
          taken * 6.0 * along * (1.0 - along) / (law.rebound_speed * h)};
}

// s, and how it falls with d1.
struct Pressure {
  double value = 0.0;
  double fall = 0.0;
};

Pressure pressure_of(const ContactLaw& law, const ContactGap& gap, double h) {
  const MeanForce mean = mean_of(law, gap);
  const Outgoing out = outgoing(law, gap, h);
  return {out.share * mean.value, out.share * mean.fall + mean.value * out.fall};
}

// The part of the way across the normal, m, its length, and friction over it, N/m: below the slip
// speed friction is in proportion to the slip.
struct Slip {
  Vector3d way;
  double length = 0.0;
  bool slides = false;
  double rubbing = 0.0;
};

Slip slip_of(const ContactLaw& law, const ContactWay& way, double h, const ContactHeld& held) {
  const Vector3d over = way.path - way.bend;
  const Vector3d& n = held.normal;
  Slip slip{over - (n.dot(over) / n.squaredNorm()) * n};
  slip.length = slip.way.norm();
  const double whole = h * law.slip_speed;
  slip.slides = slip.length > whole;
  slip.rubbing =
      held.grinding * (slip.slides ? 1.0 / slip.length : (2.0 - slip.length / whole) / whole);
  return slip;
}

// Returns how friction falls with the way. whole: m, at which it is whole.
Matrix3d drag_of(const Slip& slip, const Vector3d& n, double grinding, double whole) {
  Matrix3d drag = slip.rubbing * (Matrix3d::Identity() - n * n.transpose() / n.squaredNorm());
  if (slip.length > 0.0) {
    const double shorter = slip.slides ? 1.0 / (slip.length * slip.length) : 1.0 / (whole * whole);
    drag -= (grinding * shorter / slip.length) * slip.way * slip.way.transpose();
  }
  return drag;
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

ContactForce contact_force(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                           double h, double renew, ContactHeld& held) {
  ContactForce contact;
  contact.distance = gap.d1;
  contact.energy = law.energy(gap.d1);
  const MeanForce mean = mean_of(law, gap);
  if (mean.value == 0.0 && held.grinding == 0.0) return contact;
  contact.acts = true;
  const Correction correction = correct(law, gap, way, held.normal);
  const Outgoing out = outgoing(law, gap, h);
  contact.pressure = mean.value;
  contact.lost = (1.0 - out.share) * std::max(0.0, gap.e0 - contact.energy);
  const double s = out.share * mean.value;
  const Vector3d point_normal = held.normal + correction.c * way.path;
  contact.grinding = law.friction * s * point_normal.norm();
  if (renew > 0.0) held.grinding += renew * (contact.grinding - held.grinding);
  const Slip slip = slip_of(law, way, h, held);
  contact.rubbed = slip.rubbing * slip.way.squaredNorm();
  contact.force = s * point_normal - slip.rubbing * slip.way;
  contact.bend_force = s * (held.normal - correction.c * way.bend) - slip.rubbing * slip.way;
  return contact;
}

ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             double h, const ContactHeld& held) {
  const auto& [p, w] = way;
  const Vector3d& n = held.normal;
  const auto [c, shorter2] = correct(law, gap, way, n);
  const Pressure pressure = pressure_of(law, gap, h);
  const double s = pressure.value;
  const Matrix3d drag = drag_of(slip_of(law, way, h, held), n, held.grinding, h * law.slip_speed);
  const Vector3d by_path = shorter2 * (n + 2.0 * c * p), by_bend = shorter2 * (n - 2.0 * c * w);
  ContactSlopes slopes;
  slopes.point.by_distance = pressure.fall * (n + c * p) - (s * shorter2) * p;
  slopes.point.by_path = drag + s * p * by_path.transpose();
  slopes.point.by_path.diagonal().array() -= s * c;
  slopes.point.by_bend = -drag - s * p * by_bend.transpose();
  slopes.bend.by_distance = pressure.fall * (n - c * w) + (s * shorter2) * w;
  slopes.bend.by_path = drag - s * w * by_path.transpose();
  slopes.bend.by_bend = -drag + s * w * by_bend.transpose();
  slopes.bend.by_bend.diagonal().array() += s * c;
  return slopes;
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
  if (renew > 0.0) held.normal = signed_distance(collider.shape, 0.5 * (start.place + end)).normal;
  const ContactGap gap{start.distance, start.energy, found.distance};
  ContactForce contact = contact_force(law, gap, {end - start.place}, h, renew, held);
  if (contact.acts) contact.force = mid_rotation(collider).toRotationMatrix() * contact.force;
  return contact;
}

double contact_passage(const PlacedCollider& collider, const ContactStart& start,
                       const Vector3d& x1, bool& through) {
  const Vector3d end = into_frame(collider.end, x1);
  const double way = (end - start.place).norm();
  through = false;
  if (std::holds_alternative<PlaneShape>(collider.shape) || way <= start.distance) return way;
  const CollisionDistance found = signed_distance(collider.shape, end);
  through = goes_through(collider.shape, {start.place, start.distance, start.normal},
                         {end, found.distance, found.normal});
  return way;
}

Matrix3d contact_stiffness(const ContactLaw& law, const PlacedCollider& collider,
                           const ContactStart& start, const Vector3d& x1, double h,
                           const ContactHeld& held) {
  const Vector3d end = into_frame(collider.end, x1);
  const CollisionDistance found = signed_distance(collider.shape, end);
  const ContactWay way{end - start.place};
  const ContactGap gap{start.distance, start.energy, found.distance};
  const ContactSlope slope = contact_slopes(law, gap, way, h, held).point;
  const Matrix3d by_end = slope.by_path + slope.by_distance * found.normal.transpose();
  return mid_rotation(collider).toRotationMatrix() * by_end *
         collider.end.rotation.toRotationMatrix().transpose();
}

}  // namespace tremolo
