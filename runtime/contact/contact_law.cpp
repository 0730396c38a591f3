#include "runtime/contact/contact_law.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/collider.h"

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

// c, and 1/(|p|^2 + |w|^2) in its derivative. That is 0 on a path shorter than way.apart: c is then
// nearly half a curvature. Its derivative is the difference of two normals divided by the path, and
// for normals of places farther apart than the path that quotient could exceed the stiffness.
struct Correction {
  double c = 0.0;
  double shorter2 = 0.0;
};

Correction correct(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                   const Vector3d& normal) {
  const double length2 = way.path.squaredNorm() + way.bend.squaredNorm();
  if (!(length2 > 1e-18 * law.margin * law.margin)) return {};
  double missed = gap.d1 - gap.d0 - normal.dot(way.path - way.bend);
  if (law.rounding > 0.0) missed -= std::clamp(missed, -law.rounding, law.rounding);
  return {missed / length2, length2 > way.apart * way.apart ? 1.0 / length2 : 0.0};
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

// The part of the way across the normal, m.
Vector3d tangential(const ContactLaw& law, const ContactWay& way, const ContactHeld& held) {
  const Vector3d& n = held.normal;
  Vector3d over = way.path - way.bend;
  if (law.radius > 0.0) over += way.turn.cross(surface_arm(law, held));
  return over - (n.dot(over) / n.squaredNorm()) * n;
}

FrictionLaw friction_law(const ContactLaw& law, double h) {
  return {law.shear, law.shear_damping / h};
}

bool moves(const PlacedCollider& collider) {
  return collider.start.position != collider.end.position ||
         collider.start.rotation.coeffs() != collider.end.rotation.coeffs();
}

}  // namespace

bool moves_near(std::span<const PlacedCollider> colliders, const Vector3d& place, double reach) {
  for (const PlacedCollider& collider : colliders) {
    if (!moves(collider)) continue;
    for (const Pose& pose : {collider.start, collider.end}) {
      const Vector3d local = pose.rotation.conjugate() * (place - pose.position);
      if (signed_distance(collider.shape, local).distance < reach) return true;
    }
  }
  return false;
}

double ContactLaw::energy(double distance) const {
  const double depth = begins - distance;
  if (!(depth > 0.0)) return 0.0;
  const double x = std::min(depth, linear_from), beyond = depth - x;
  return stiffness * (x * x * x / 3.0 + (beyond > 0.0 ? x * beyond * (x + beyond) : 0.0));
}

// The stiffnesses are the slopes of the pressure at the depth at which both count as linear,
// otherwise kappa. If each body has points on the other's shape, all of them act. The rebound is
// whole from the lower speed on.
ContactLaw law_in_series(ContactLaw law, const ContactLaw& own, const ContactLaw& theirs,
                         double area) {
  const double both = std::min(own.linear_from, theirs.linear_from);
  const auto slope = [both](const ContactLaw& one) {
    return std::isfinite(both) ? one.stiffness * std::min(one.margin, one.linear_from) / both
                               : one.stiffness;
  };
  law.rebound_speed = std::min(own.rebound_speed, theirs.rebound_speed);
  const double mine = slope(own), others = slope(theirs);
  const double before = law.shear;
  law.linear_from = both;
  law.stiffness = area * mine * others / (mine + others);
  law.shear = law.stiffness * std::min(law.margin, 2.0 * law.linear_from);
  if (before > 0.0) law.shear_damping *= std::sqrt(law.shear / before);
  return law;
}

void hold_normal(const Vector3d& normal, const ContactMemory& memory, ContactHeld& held) {
  held.normal = normal;
  held.slip = memory.slip;
  if (held.slip.isZero(0.0)) return;
  const double length = normal.norm();
  held.slip = length > 0.0 ? turn_to_plane(memory.slip, memory.normal, normal / length)
                           : Vector3d(Vector3d::Zero());
}

Vector3d surface_arm(const ContactLaw& law, const ContactHeld& held) {
  const double length = held.normal.norm();
  return length > 0.0 ? Vector3d(-law.radius / length * held.normal) : Vector3d(Vector3d::Zero());
}

ContactStart contact_start(const ContactLaw& law, const PlacedCollider& collider, const Vector3d& x,
                           const Vector3d& middle, const ContactMemory* memory) {
  ContactStart start;
  start.place = into_frame(collider.start, x);
  start.inward = (into_frame(collider.start, middle) - start.place).normalized();
  if (memory != nullptr && memory->side.counts() &&
      is_behind(collider.shape, memory->side, start.place))
    start.side = memory->side;
  CollisionDistance found = distance_by(collider.shape, start.side, start.place);
  if (memory == nullptr) {
    start.side = side_on_edge(collider.shape, start.place, found, start.inward);
    if (start.side.counts()) found.normal = start.side.normal;
  }
  start.distance = found.distance - law.radius;
  start.normal = found.normal;
  start.energy = law.energy(start.distance);
  return start;
}

double held_slip(const ContactLaw& law, const ContactForce& now) {
  constexpr double kRounding = 1e-9;  // a point that slides has the limit to rounding
  if (!now.acts) return 0.0;
  const double slip = now.slip.norm();
  return law.shear * slip < (1.0 - kRounding) * now.limit ? slip : 0.0;
}

ContactGap make_gap(const ContactLaw& law, double d0, double e0, double d1) {
  const MeanForce mean = mean_force(law, law.begins - d0, law.begins - d1);
  return {d0, e0, d1, mean.value, mean.fall};
}

ColliderTurns turns_of(const PlacedCollider& collider) {
  Eigen::Quaterniond end = collider.end.rotation;
  if (collider.start.rotation.dot(end) < 0.0) end.coeffs() = -end.coeffs();
  const Eigen::Quaterniond mean(collider.start.rotation.coeffs() + end.coeffs());
  return {collider.end.rotation.toRotationMatrix(), mean.normalized().toRotationMatrix()};
}

ContactForce contact_force(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                           const ContactTime& time, double limits, ContactHeld& held) {
  ContactForce contact;
  contact.distance = gap.d1;
  const double energy = law.energy(gap.d1);
  const double stored = 0.5 * law.shear * held.slip.squaredNorm();
  if (gap.pressure == 0.0) held.limit -= limits * held.limit;
  if (gap.pressure == 0.0 && held.limit == 0.0) {
    contact.friction_loss = stored;
    return contact;
  }
  contact.acts = true;
  const Correction correction = correct(law, gap, way, held.normal);
  const double factor = restitution_of(law, gap, time).factor;
  contact.pressure = gap.pressure;
  const double s = factor * gap.pressure;
  contact.lost = (1.0 - factor) * (gap.e0 - energy);
  const Vector3d point_normal = held.normal + correction.c * way.path;
  contact.limit = law.friction * s * point_normal.norm();
  if (gap.pressure != 0.0) held.limit += limits * (contact.limit - held.limit);
  const Friction friction =
      friction_force(friction_law(law, time.h), held.limit, held.slip, tangential(law, way, held));
  // A contact that ends forgets its slip; the stored energy becomes friction loss.
  const bool ends = gap.d1 >= law.begins;
  contact.friction_loss = friction.lost + (ends ? friction.energy : 0.0);
  contact.slip = ends ? Vector3d(Vector3d::Zero()) : friction.slip;
  contact.energy = energy + (ends ? 0.0 : friction.energy);
  contact.force = s * point_normal + friction.force;
  contact.bend_force = s * (held.normal - correction.c * way.bend) + friction.force;
  contact.rub = friction.force;
  return contact;
}

namespace {

// Growth of the fraction that restitution takes by the pair's rate with d1, 1/m. The pair's way v h
// is given/force, of which both change with d1, psi(d0) - psi(d1) by psi'(d1).
double taken_by_distance(const ContactLaw& law, const ContactGap& gap, const ContactTime& time) {
  if (!(time.rate.force > 0.0)) return 0.0;
  const double along = time.rate.way(), x = std::max(0.0, law.begins - gap.d1);
  const double least = std::min(x, law.linear_from);
  const double slope = law.stiffness * least * (2.0 * x - least);
  return (1.0 - kPointShare) * taken_at(law, along, time.h).growth * (slope + along * gap.fall) /
         time.rate.force;
}

}  // namespace

ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             const ContactTime& time, const ContactHeld& held, bool follows) {
  const Vector3d &p = way.path, &w = way.bend;
  const Vector3d& n = held.normal;
  const auto [c, shorter2] = correct(law, gap, way, n);
  const Restitution part = restitution_of(law, gap, time);
  const double s = part.factor * gap.pressure;
  const double s_fall = part.factor * gap.fall + gap.pressure * part.fall;
  const FrictionSlopes friction = friction_slopes(friction_law(law, time.h), held.limit, held.slip,
                                                  tangential(law, way, held), n / n.norm());
  const Matrix3d drag = -friction.by_path;
  const Vector3d by_path = shorter2 * (n + 2.0 * c * p), by_bend = shorter2 * (n - 2.0 * c * w);
  ContactSlopes slopes;
  slopes.point.by_distance = s_fall * (n + c * p) - (s * shorter2) * p;
  slopes.point.by_path = drag + s * p * by_path.transpose();
  slopes.point.by_path.diagonal().array() -= s * c;
  slopes.point.by_bend = -drag - s * p * by_bend.transpose();
  slopes.bend.by_distance = s_fall * (n - c * w) + (s * shorter2) * w;
  slopes.bend.by_path = drag - s * w * by_path.transpose();
  slopes.bend.by_bend = -drag + s * w * by_bend.transpose();
  slopes.bend.by_bend.diagonal().array() += s * c;
  const Vector3d m = n + c * p;
  slopes.point.by_taken = gap.pressure * m;
  slopes.bend.by_taken = gap.pressure * (n - c * w);
  slopes.taken_by_distance = taken_by_distance(law, gap, time);
  // psi is zero at d0, so that the pressure is psi(d1) over the way from d0.
  const bool begins = !(gap.d0 < law.begins) && gap.d1 < gap.d0;
  const double start_fall = begins ? part.factor * gap.pressure / (gap.d0 - gap.d1) : 0.0;
  slopes.by_start = begins ? Vector3d(start_fall * m + (s * shorter2) * p) : Vector3d::Zero();
  const bool rolls = law.radius > 0.0;
  if (rolls) {
    slopes.rub = {Vector3d::Zero(), drag, -drag, Vector3d::Zero()};
    slopes.by_roll = drag;
  }
  if (follows) {
    // The fall of L = mu s |m|, m = n + c p, with each.
    const double length = m.norm(), sizes = law.friction * s / length;
    const double fall = law.friction * s_fall * length - sizes * shorter2 * m.dot(p);
    const Eigen::RowVector3d fall_by_path =
        sizes * (m.dot(p) * by_path.transpose() - c * m.transpose());
    const Eigen::RowVector3d fall_by_bend = -sizes * m.dot(p) * by_bend.transpose();
    for (ContactSlope* slope : {&slopes.point, &slopes.bend}) {
      slope->by_distance += fall * friction.by_limit;
      slope->by_path += friction.by_limit * fall_by_path;
      slope->by_bend += friction.by_limit * fall_by_bend;
      slope->by_taken += (law.friction * gap.pressure * length) * friction.by_limit;
    }
    if (begins)
      slopes.by_start +=
          (law.friction * start_fall * length + sizes * shorter2 * m.dot(p)) * friction.by_limit;
    if (rolls) {
      slopes.rub.by_distance = fall * friction.by_limit;
      slopes.rub.by_path += friction.by_limit * fall_by_path;
      slopes.rub.by_bend += friction.by_limit * fall_by_bend;
      slopes.rub.by_taken = (law.friction * gap.pressure * length) * friction.by_limit;
    }
  }
  return slopes;
}

ContactEnd contact_end(const ContactLaw& law, const PlacedCollider& collider,
                       const ColliderTurns& turns, const ContactStart& start, const Vector3d& x1) {
  ContactEnd end;
  end.place = turns.end.transpose() * (x1 - collider.end.position);
  CollisionDistance found = signed_distance(collider.shape, end.place);
  end.side =
      side_at(collider.shape, start.side, {start.place, start.distance + law.radius, start.normal},
              end.place, found, start.inward, law.begins + law.radius);
  if (end.side.counts()) found = {end.side.at(end.place), end.side.normal};
  end.normal = found.normal;
  end.gap = make_gap(law, start.distance, start.energy, found.distance - law.radius);
  return end;
}

ContactForce contact_force(const ContactLaw& law, const PlacedCollider& collider,
                           const ColliderTurns& turns, const ContactStart& start,
                           const ContactMemory& memory, const ContactEnd& end,
                           const ContactTime& time, const ContactRenewal& renewal,
                           ContactHeld& held) {
  if (start.distance >= law.begins && end.gap.d1 >= law.begins) {
    if (renewal.limits == 1.0) held.limit = 0.0;
    if (held.limit == 0.0) {
      ContactForce apart;
      apart.clear(end.gap.d1, 0.5 * law.shear * memory.slip.squaredNorm());
      return apart;
    }
  }
  if (renewal.normals) {
    const EntrySide& side = start.side.counts() ? start.side : end.side;
    const bool flat = std::holds_alternative<PlaneShape>(collider.shape);
    const Vector3d middle = 0.5 * (start.place + end.place);
    hold_normal(flat ? end.normal : distance_by(collider.shape, side, middle).normal, memory, held);
  }
  const ContactWay way{.path = end.place - start.place, .turn = end.turn};
  ContactForce contact = contact_force(law, end.gap, way, time, renewal.limits, held);
  if (contact.acts) contact.force = turns.mean * contact.force;
  if (contact.acts && law.radius > 0.0) contact.rub = turns.mean * contact.rub;
  if (end.side.counts() && !is_behind(collider.shape, end.side, end.place)) contact.release();
  return contact;
}

double contact_passage(const PlacedCollider& collider, const ContactStart& start,
                       const ContactEnd& end, bool& through) {
  const double way = (end.place - start.place).norm();
  through = false;
  if (std::holds_alternative<PlaneShape>(collider.shape) || way <= start.distance) return way;
  if (end.side.counts()) {
    through = !is_behind(collider.shape, end.side, end.place) &&
              is_through(collider.shape, end.side, end.place);
    return way;
  }
  through = goes_through(collider.shape, {start.place, start.distance, start.normal},
                         {end.place, end.gap.d1, end.normal});
  return way;
}

PlacedSlope contact_slope(const ContactLaw& law, const ColliderTurns& turns,
                          const ContactStart& start, const ContactEnd& end, const ContactTime& time,
                          const ContactHeld& held, bool follows) {
  const ContactWay way{.path = end.place - start.place, .turn = end.turn};
  const ContactSlopes slopes = contact_slopes(law, end.gap, way, time, held, follows);
  const ContactSlope& point = slopes.point;
  const Matrix3d by_end = point.by_path + point.by_distance * end.normal.transpose();
  PlacedSlope placed;
  placed.by_end = turns.mean * by_end * turns.end.transpose();
  placed.by_taken = turns.mean * point.by_taken;
  placed.taken = slopes.taken_by_distance * (turns.end * end.normal);
  if (!(law.radius > 0.0)) return placed;
  const ContactSlope& rub = slopes.rub;
  const Matrix3d rub_by_end = rub.by_path + rub.by_distance * end.normal.transpose();
  placed.rub_by_end = turns.mean * rub_by_end * turns.end.transpose();
  placed.by_roll = turns.mean * slopes.by_roll * turns.mean.transpose();
  placed.rub_by_taken = turns.mean * rub.by_taken;
  return placed;
}

}  // namespace tremolo
