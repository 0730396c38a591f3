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

// (psi(d0) - psi(d1)) / (d1 - d0) and how it falls with d1.
struct MeanForce {
  double value = 0.0;
  double fall = 0.0;
};

// The means of psi' from the depth a to b, which may be negative: (1/l) int psi' dx and
// (1/l^2) int (x - a) psi'' dx with l = b - a, piece by piece without differences of energies.
MeanForce mean_force(const ContactLaw& law, double a, double b) {
  const double w = law.linear_from;
  if (a <= 0.0 && b <= 0.0) return {};
  const double length = b - a;
  if (length == 0.0) {
    const double x = std::min(a, w);
    return {law.stiffness * x * (2.0 * a - x), law.stiffness * x};
  }
  // The part from 0 to w, where psi' is x^2.
  const double from = std::clamp(a, 0.0, w), to = std::clamp(b, 0.0, w);
  const double s = from - a, t = to - a;
  double value = (to - from) / 3.0 * (from * from + from * to + to * to);
  double fall = (t - s) * (a * (t + s) + 2.0 / 3.0 * (t * t + t * s + s * s));
  if (a > w || b > w) {
    const double first = std::max(a, w), last = std::max(b, w);
    value += w * (last - first) * (last + first - w);
    fall += w * (last - first) * (last + first - 2.0 * a);
  }
  return {law.stiffness * value / length, law.stiffness * fall / (length * length)};
}

MeanForce mean_of(const ContactLaw& law, const ContactGap& gap) {
  return mean_force(law, law.begins - gap.d0, law.begins - gap.d1);
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

// The factor of restitution on the mean force, and how it falls with d1.
struct Restitution {
  double factor = 1.0;
  double fall = 0.0;
};

// With e^2 the ratio of the factors far out and far in, 1 in between, where it falls as a damper:
// small motions die away, and the force stays monotonous.
Restitution restitution_of(const ContactLaw& law, const ContactGap& gap, double h) {
  const double square = law.restitution * law.restitution;
  const double taken = (1.0 - square) / (1.0 + square);
  const double along = std::clamp((gap.d1 - gap.d0) / (h * law.rebound_speed), -1.0, 1.0);
  const double size = std::abs(along);
  return {1.0 - taken * along * (2.0 - size), 2.0 * taken * (1.0 - size) / (law.rebound_speed * h)};
}

// s, and how it falls with d1.
struct Pressure {
  double value = 0.0;
  double fall = 0.0;
};

Pressure pressure_of(const ContactLaw& law, const ContactGap& gap, double h) {
  const MeanForce mean = mean_of(law, gap);
  const Restitution part = restitution_of(law, gap, h);
  return {part.factor * mean.value, part.factor * mean.fall + mean.value * part.fall};
}

// The part of the way across the normal, m.
Vector3d tangential(const ContactWay& way, const Vector3d& n) {
  const Vector3d over = way.path - way.bend;
  return over - (n.dot(over) / n.squaredNorm()) * n;
}

FrictionLaw friction_law(const ContactLaw& law, double h) {
  return {law.shear, law.shear_damping / h};
}

// The mean rotation of the collider's frame in the step.
Eigen::Quaterniond mid_rotation(const PlacedCollider& collider) {
  Eigen::Quaterniond end = collider.end.rotation;
  if (collider.start.rotation.dot(end) < 0.0) end.coeffs() = -end.coeffs();
  return Eigen::Quaterniond(collider.start.rotation.coeffs() + end.coeffs()).normalized();
}

}  // namespace

double ContactLaw::energy(double distance) const {
  const double depth = begins - distance;
  if (!(depth > 0.0)) return 0.0;
  const double x = std::min(depth, linear_from), beyond = depth - x;
  return stiffness * (x * x * x / 3.0 + (beyond > 0.0 ? x * beyond * (x + beyond) : 0.0));
}

void hold_normal(const Vector3d& normal, const ContactMemory& memory, ContactHeld& held) {
  held.normal = normal;
  held.slip = memory.slip;
  if (held.slip.isZero(0.0)) return;
  const double length = normal.norm();
  held.slip = length > 0.0 ? turn_to_plane(memory.slip, memory.normal, normal / length)
                           : Vector3d(Vector3d::Zero());
}

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
                           double h, double limits, ContactHeld& held) {
  ContactForce contact;
  contact.distance = gap.d1;
  const double energy = law.energy(gap.d1);
  const MeanForce mean = mean_of(law, gap);
  const double stored = 0.5 * law.shear * held.slip.squaredNorm();
  if (mean.value == 0.0) held.limit -= limits * held.limit;
  if (mean.value == 0.0 && held.limit == 0.0) {
    contact.rubbed = stored;
    return contact;
  }
  contact.acts = true;
  const Correction correction = correct(law, gap, way, held.normal);
  const double factor = restitution_of(law, gap, h).factor;
  contact.pressure = mean.value;
  contact.lost = (1.0 - factor) * (gap.e0 - energy);
  const double s = factor * mean.value;
  const Vector3d point_normal = held.normal + correction.c * way.path;
  contact.limit = law.friction * s * point_normal.norm();
  if (mean.value != 0.0) held.limit += limits * (contact.limit - held.limit);
  const Friction friction =
      friction_force(friction_law(law, h), held.limit, held.slip, tangential(way, held.normal));
  // A contact that ends forgets its slip, and what that stores is friction's.
  const bool ends = gap.d1 >= law.begins;
  contact.rubbed = friction.lost + (ends ? friction.energy : 0.0);
  contact.slip = ends ? Vector3d(Vector3d::Zero()) : friction.slip;
  contact.energy = energy + (ends ? 0.0 : friction.energy);
  contact.force = s * point_normal + friction.force;
  contact.bend_force = s * (held.normal - correction.c * way.bend) + friction.force;
  return contact;
}

ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             double h, const ContactHeld& held, bool follows) {
  const auto& [p, w] = way;
  const Vector3d& n = held.normal;
  const auto [c, shorter2] = correct(law, gap, way, n);
  const Pressure pressure = pressure_of(law, gap, h);
  const double s = pressure.value;
  const FrictionSlopes friction = friction_slopes(friction_law(law, h), held.limit, held.slip,
                                                  tangential(way, n), n / n.norm());
  const Matrix3d drag = -friction.by_path;
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
  if (follows) {
    // By how much L = mu s |m|, m = n + c p, falls with each.
    const Vector3d m = n + c * p;
    const double length = m.norm(), sizes = law.friction * s / length;
    const double fall = law.friction * pressure.fall * length - sizes * shorter2 * m.dot(p);
    const Eigen::RowVector3d fall_by_path =
        sizes * (m.dot(p) * by_path.transpose() - c * m.transpose());
    const Eigen::RowVector3d fall_by_bend = -sizes * m.dot(p) * by_bend.transpose();
    for (ContactSlope* slope : {&slopes.point, &slopes.bend}) {
      slope->by_distance += fall * friction.by_limit;
      slope->by_path += friction.by_limit * fall_by_path;
      slope->by_bend += friction.by_limit * fall_by_bend;
    }
  }
  return slopes;
}

ContactForce contact_force(const ContactLaw& law, const PlacedCollider& collider,
                           const ContactStart& start, const ContactMemory& memory,
                           const Vector3d& x1, double h, const ContactRenewal& renewal,
                           ContactHeld& held) {
  const Vector3d end = into_frame(collider.end, x1);
  const CollisionDistance found = signed_distance(collider.shape, end);
  if (start.distance >= law.begins && found.distance >= law.begins) {
    if (renewal.limits == 1.0) held.limit = 0.0;
    if (held.limit == 0.0) {
      ContactForce apart;
      apart.clear(found.distance, 0.5 * law.shear * memory.slip.squaredNorm());
      return apart;
    }
  }
  if (renewal.normals) {
    const bool flat = std::holds_alternative<PlaneShape>(collider.shape);
    hold_normal(
        flat ? found.normal : signed_distance(collider.shape, 0.5 * (start.place + end)).normal,
        memory, held);
  }
  const ContactGap gap{start.distance, start.energy, found.distance};
  ContactForce contact = contact_force(law, gap, {end - start.place}, h, renewal.limits, held);
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
                           const ContactHeld& held, bool follows) {
  const Vector3d end = into_frame(collider.end, x1);
  const CollisionDistance found = signed_distance(collider.shape, end);
  const ContactWay way{end - start.place};
  const ContactGap gap{start.distance, start.energy, found.distance};
  const ContactSlope slope = contact_slopes(law, gap, way, h, held, follows).point;
  const Matrix3d by_end = slope.by_path + slope.by_distance * found.normal.transpose();
  return mid_rotation(collider).toRotationMatrix() * by_end *
         collider.end.rotation.toRotationMatrix().transpose();
}

}  // namespace tremolo
