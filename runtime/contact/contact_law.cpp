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

// (psi(d0) - psi(d1)) / (d1 - d0), and its fall with d1.
struct MeanForce {
  double value = 0.0;
  double fall = 0.0;
};

// Means of psi' from the depth a to b, which may be negative: (1/l) int psi' dx and (1/l^2) int (x
// - a) psi'' dx with l = b - a. They are summed piece by piece without differences of energies.
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

// c, and 1/(|p|^2 + |w|^2), which is 0 where the change of distance is rounding.
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

// The fraction of restitution by the point's own rate, and the fraction of rebound_speed from which
// that is whole. It damps small motions only.
constexpr double kPointShare = 0.02;
constexpr double kPointSpeed = 0.1;

// The factor falls smoothly with the rate and is 1 at rest; the ratio of its values at fast
// separation and fast approach is e^2. Small motions are damped, and the force stays monotonous.
// way: v h, m. share: of rebound_speed.
struct Taken {
  double value = 0.0;   // subtracted from the factor 1
  double growth = 0.0;  // its derivative with v h, 1/m
};

Taken taken_at(const ContactLaw& law, double way, double h, double share = 1.0) {
  const double square = law.restitution * law.restitution;
  const double taken = (1.0 - square) / (1.0 + square);
  const double whole = share * law.rebound_speed * h;
  const double along = std::clamp(way / whole, -1.0, 1.0);
  const double size = std::abs(along);
  return {taken * along * (2.0 - size), 2.0 * taken * (1.0 - size) / whole};
}

// The factor of restitution on the mean force, and its fall with d1 at a constant rate of the pair.
struct Restitution {
  double factor = 1.0;
  double fall = 0.0;
};

Restitution restitution_of(const ContactLaw& law, const ContactGap& gap, const ContactTime& time) {
  const Taken pair = taken_at(law, time.rate.way(), time.h);
  const Taken own = taken_at(law, gap.d1 - gap.d0, time.h, kPointSpeed);
  return {1.0 - (1.0 - kPointShare) * pair.value - kPointShare * own.value,
          kPointShare * own.growth};
}

// s, and its fall with d1.
struct Pressure {
  double value = 0.0;
  double fall = 0.0;
};

Pressure pressure_of(const ContactLaw& law, const ContactGap& gap, const ContactTime& time) {
  const MeanForce mean = mean_of(law, gap);
  const Restitution part = restitution_of(law, gap, time);
  return {part.factor * mean.value, part.factor * mean.fall + mean.value * part.fall};
}

// The part of the displacement across the normal, m.
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

double contact_pressure(const ContactLaw& law, const ContactGap& gap) {
  return mean_of(law, gap).value;
}

ContactForce contact_force(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                           const ContactTime& time, double limits, ContactHeld& held) {
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
  const double factor = restitution_of(law, gap, time).factor;
  contact.pressure = mean.value;
  contact.lost = (1.0 - factor) * (gap.e0 - energy);
  const double s = factor * mean.value;
  const Vector3d point_normal = held.normal + correction.c * way.path;
  contact.limit = law.friction * s * point_normal.norm();
  if (mean.value != 0.0) held.limit += limits * (contact.limit - held.limit);
  const Friction friction = friction_force(friction_law(law, time.h), held.limit, held.slip,
                                           tangential(way, held.normal));
  // A contact that ends forgets its slip; the stored energy becomes friction loss.
  const bool ends = gap.d1 >= law.begins;
  contact.rubbed = friction.lost + (ends ? friction.energy : 0.0);
  contact.slip = ends ? Vector3d(Vector3d::Zero()) : friction.slip;
  contact.energy = energy + (ends ? 0.0 : friction.energy);
  contact.force = s * point_normal + friction.force;
  contact.bend_force = s * (held.normal - correction.c * way.bend) + friction.force;
  return contact;
}

ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             const ContactTime& time, const ContactHeld& held, bool follows) {
  const auto& [p, w] = way;
  const Vector3d& n = held.normal;
  const auto [c, shorter2] = correct(law, gap, way, n);
  const Pressure pressure = pressure_of(law, gap, time);
  const double s = pressure.value;
  const FrictionSlopes friction = friction_slopes(friction_law(law, time.h), held.limit, held.slip,
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
    // Fall of L = mu s |m|, m = n + c p, with each.
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

ContactLink contact_link(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                         const ContactTime& time, const ContactHeld& held, bool follows) {
  const MeanForce mean = mean_of(law, gap);
  const auto [c, shorter2] = correct(law, gap, way, held.normal);
  const Vector3d pushes = held.normal + c * way.path;
  ContactLink link;
  link.point = mean.value * pushes;
  link.bend = mean.value * (held.normal - c * way.bend);
  if (follows) {
    const Vector3d& n = held.normal;
    const Vector3d friction = friction_slopes(friction_law(law, time.h), held.limit, held.slip,
                                              tangential(way, n), n / n.norm())
                                  .by_limit *
                              (law.friction * mean.value * pushes.norm());
    link.point += friction;
    link.bend += friction;
  }
  if (!(time.rate.force > 0.0)) return link;
  // The pair's displacement v h = given/force: both change with d1, psi(d0) - psi(d1) by psi'(d1).
  const double along = time.rate.way(), x = std::max(0.0, law.begins - gap.d1);
  const double least = std::min(x, law.linear_from);
  const double slope = law.stiffness * least * (2.0 * x - least);
  link.by_distance = (1.0 - kPointShare) * taken_at(law, along, time.h).growth *
                     (slope + along * mean.fall) / time.rate.force;
  return link;
}

ContactEnd contact_end(const ContactLaw& law, const PlacedCollider& collider,
                       const ContactStart& start, const Vector3d& x1) {
  ContactEnd end;
  end.place = into_frame(collider.end, x1);
  const CollisionDistance found = signed_distance(collider.shape, end.place);
  end.distance = found.distance;
  end.normal = found.normal;
  end.pressure = contact_pressure(law, {start.distance, start.energy, end.distance});
  return end;
}

ContactForce contact_force(const ContactLaw& law, const PlacedCollider& collider,
                           const ContactStart& start, const ContactMemory& memory,
                           const ContactEnd& end, const ContactTime& time,
                           const ContactRenewal& renewal, ContactHeld& held) {
  if (start.distance >= law.begins && end.distance >= law.begins) {
    if (renewal.limits == 1.0) held.limit = 0.0;
    if (held.limit == 0.0) {
      ContactForce apart;
      apart.clear(end.distance, 0.5 * law.shear * memory.slip.squaredNorm());
      return apart;
    }
  }
  if (renewal.normals) {
    const bool flat = std::holds_alternative<PlaneShape>(collider.shape);
    hold_normal(
        flat ? end.normal : signed_distance(collider.shape, 0.5 * (start.place + end.place)).normal,
        memory, held);
  }
  const ContactGap gap{start.distance, start.energy, end.distance};
  ContactForce contact =
      contact_force(law, gap, {end.place - start.place}, time, renewal.limits, held);
  if (contact.acts) contact.force = mid_rotation(collider).toRotationMatrix() * contact.force;
  return contact;
}

double contact_passage(const PlacedCollider& collider, const ContactStart& start,
                       const ContactEnd& end, bool& through) {
  const double way = (end.place - start.place).norm();
  through = false;
  if (std::holds_alternative<PlaneShape>(collider.shape) || way <= start.distance) return way;
  through = goes_through(collider.shape, {start.place, start.distance, start.normal},
                         {end.place, end.distance, end.normal});
  return way;
}

Matrix3d contact_stiffness(const ContactLaw& law, const PlacedCollider& collider,
                           const ContactStart& start, const ContactEnd& end,
                           const ContactTime& time, const ContactHeld& held, bool follows) {
  const ContactWay way{end.place - start.place};
  const ContactGap gap{start.distance, start.energy, end.distance};
  const ContactSlope slope = contact_slopes(law, gap, way, time, held, follows).point;
  const Matrix3d by_end = slope.by_path + slope.by_distance * end.normal.transpose();
  return mid_rotation(collider).toRotationMatrix() * by_end *
         collider.end.rotation.toRotationMatrix().transpose();
}

PlacedLink contact_link(const ContactLaw& law, const PlacedCollider& collider,
                        const ContactStart& start, const ContactEnd& end, const ContactTime& time,
                        const ContactHeld& held, bool follows) {
  const ContactWay way{end.place - start.place};
  const ContactGap gap{start.distance, start.energy, end.distance};
  const ContactLink link = contact_link(law, gap, way, time, held, follows);
  return {mid_rotation(collider) * link.point,
          link.by_distance * (collider.end.rotation * end.normal)};
}

}  // namespace tremolo
