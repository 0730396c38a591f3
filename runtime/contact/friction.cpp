#include "runtime/contact/friction.h"

#include <algorithm>

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The elastic step, as named in the header.
struct Return {
  Vector3d start, end, elastic;  // xi0 after the first clip, xi1, te, m
  Vector3d trial;                // x, m
  double trial_length = 0.0;     // |x|, m
  double plastic = 0.0;          // |tp|, m
  double length = 0.0;           // |te|, m
  double fraction = 1.0;         // a
  bool clipped = false;          // the first clip shortened xi0
};

Return return_map(double l, const Vector3d& slip, const Vector3d& path) {
  Return step;
  const double before = slip.norm();
  step.clipped = before > l;
  step.start = step.clipped ? Vector3d((l / before) * slip) : slip;
  step.trial = step.start + path;
  step.trial_length = step.trial.norm();
  step.plastic = std::max(0.0, step.trial_length - l);
  step.end = step.plastic > 0.0 ? Vector3d((l / step.trial_length) * step.trial) : step.trial;
  step.elastic = step.end - step.start;
  step.length = step.elastic.norm();
  const double both = step.length + step.plastic;
  if (step.plastic > 0.0) step.fraction = step.length / both;
  return step;
}

Vector3d spring_force(double k, const Return& step) {
  return -k * (step.end - (0.5 * step.fraction) * step.elastic);
}

}  // namespace

Friction friction_force(const FrictionLaw& law, double limit, const Vector3d& slip,
                        const Vector3d& path) {
  Friction friction;
  const double k = law.stiffness, before = 0.5 * k * slip.squaredNorm();
  if (!(limit > 0.0) || !(k > 0.0)) {
    friction.lost = before;
    return friction;
  }
  const Return step = return_map(limit / k, slip, path);
  friction.force = spring_force(k, step);
  const double damper = law.damping * step.length;
  if (damper > 0.0) {
    const double room = std::max(0.0, limit - friction.force.norm());
    friction.force -= std::min(1.0, room / damper) * law.damping * step.elastic;
  }
  friction.slip = step.end;
  friction.energy = 0.5 * k * step.end.squaredNorm();
  friction.lost = before - friction.energy - friction.force.dot(path);
  return friction;
}

namespace {

// The derivatives of the return map: of xi1 and of te by the path and by the limit; the direction
// and the length of te; a.
struct ReturnSlopes {
  Matrix3d end_by_path;  // derivatives of xi1 and of te
  Vector3d end_by_limit, elastic_by_limit;
  Vector3d along;  // of te, length 1 or 0
  Eigen::RowVector3d length_by_path, fraction_by_path = Eigen::RowVector3d::Zero();
  double length_by_limit = 0.0, fraction_by_limit = 0.0;
};

ReturnSlopes slopes_of(const Return& step, double k, double l, const Vector3d& slip,
                       const Vector3d& normal) {
  ReturnSlopes slopes;
  const Matrix3d plane = Matrix3d::Identity() - normal * normal.transpose();
  const Vector3d start_by_limit =
      step.clipped ? Vector3d(slip / (k * slip.norm())) : Vector3d(Vector3d::Zero());
  const bool slides = step.plastic > 0.0;
  const Vector3d way = slides ? Vector3d(step.trial / step.trial_length) : Vector3d(step.trial);
  slopes.end_by_path = plane;
  slopes.end_by_limit = start_by_limit;
  if (slides) {
    slopes.end_by_path = (l / step.trial_length) * (plane - way * way.transpose());
    slopes.end_by_limit = way / k + slopes.end_by_path * start_by_limit;
  }
  slopes.elastic_by_limit = slopes.end_by_limit - start_by_limit;
  slopes.along = step.length > 0.0 ? Vector3d(step.elastic / step.length) : step.elastic;
  slopes.length_by_path = slopes.along.transpose() * slopes.end_by_path;
  slopes.length_by_limit = slopes.along.dot(slopes.elastic_by_limit);
  if (!slides) return slopes;
  const double both2 = (step.length + step.plastic) * (step.length + step.plastic);
  const double plastic_by_limit = way.dot(start_by_limit) - 1.0 / k;
  slopes.fraction_by_path =
      (step.plastic * slopes.length_by_path - step.length * way.transpose()) / both2;
  slopes.fraction_by_limit =
      (step.plastic * slopes.length_by_limit - step.length * plastic_by_limit) / both2;
  return slopes;
}

// Adds the derivatives of the damper's force; the spring's force leaves it `room`, N.
void add_damper_slopes(const FrictionLaw& law, double limit, const Return& step,
                       const ReturnSlopes& parts, FrictionSlopes& slopes) {
  const double damper = law.damping * step.length;
  const Vector3d spring = spring_force(law.stiffness, step);
  const double force = spring.norm(), room = limit - force;
  // At rest the damper acts as soon as the point moves.
  if (damper == 0.0 ? step.plastic == 0.0 : damper <= room) {
    slopes.by_path -= law.damping * parts.end_by_path;
    slopes.by_limit -= law.damping * parts.elastic_by_limit;
    return;
  }
  if (damper == 0.0 || !(room > 0.0)) return;
  const Vector3d unit = force > 0.0 ? Vector3d(spring / force) : spring;
  const Eigen::RowVector3d room_by_path = -unit.transpose() * slopes.by_path;
  const double room_by_limit = 1.0 - unit.dot(slopes.by_limit);
  slopes.by_path -= parts.along * room_by_path +
                    (room / step.length) * (parts.end_by_path - parts.along * parts.length_by_path);
  slopes.by_limit -=
      parts.along * room_by_limit +
      (room / step.length) * (parts.elastic_by_limit - parts.along * parts.length_by_limit);
}

}  // namespace

FrictionSlopes friction_slopes(const FrictionLaw& law, double limit, const Vector3d& slip,
                               const Vector3d& path, const Vector3d& normal) {
  FrictionSlopes slopes;
  const double k = law.stiffness;
  if (!(limit > 0.0) || !(k > 0.0)) return slopes;
  const double l = limit / k;
  const Return step = return_map(l, slip, path);
  const ReturnSlopes parts = slopes_of(step, k, l, slip, normal);
  slopes.by_path = -k * ((1.0 - 0.5 * step.fraction) * parts.end_by_path -
                         0.5 * step.elastic * parts.fraction_by_path);
  slopes.by_limit = -k * (parts.end_by_limit - 0.5 * step.fraction * parts.elastic_by_limit -
                          (0.5 * parts.fraction_by_limit) * step.elastic);
  add_damper_slopes(law, limit, step, parts, slopes);
  return slopes;
}

Vector3d turn_to_plane(const Vector3d& vector, const Vector3d& from, const Vector3d& to) {
  const double beside = 1.0 + from.dot(to);
  if (!(beside > 1e-6)) return Vector3d::Zero();
  return vector - (to.dot(vector) / beside) * (from + to);
}

}  // namespace tremolo
