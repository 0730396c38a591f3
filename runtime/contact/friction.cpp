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

FrictionSlopes friction_slopes(const FrictionLaw& law, double limit, const Vector3d& slip,
                               const Vector3d& path, const Vector3d& normal) {
  FrictionSlopes slopes;
  const double k = law.stiffness;
  if (!(limit > 0.0) || !(k > 0.0)) return slopes;
  const double l = limit / k;
  const Return step = return_map(l, slip, path);
  const Matrix3d plane = Matrix3d::Identity() - normal * normal.transpose();
  const Vector3d start_by_limit =
      step.clipped ? Vector3d(slip / (k * slip.norm())) : Vector3d(Vector3d::Zero());
  // Of xi1, and with the start's of te.
  Matrix3d end_by_path = plane;
  Vector3d end_by_limit = start_by_limit;
  if (step.plastic > 0.0) {
    const Vector3d along = step.trial / step.trial_length;
    end_by_path = (l / step.trial_length) * (plane - along * along.transpose());
    end_by_limit = along / k + end_by_path * start_by_limit;
  }
  const Vector3d elastic_by_limit = end_by_limit - start_by_limit;
  const Vector3d way = step.length > 0.0 ? Vector3d(step.elastic / step.length) : step.elastic;
  const Eigen::RowVector3d length_by_path = way.transpose() * end_by_path;
  const double length_by_limit = way.dot(elastic_by_limit);
  Eigen::RowVector3d fraction_by_path = Eigen::RowVector3d::Zero();
  double fraction_by_limit = 0.0;
  if (step.plastic > 0.0) {
    const Vector3d along = step.trial / step.trial_length;
    const double both = step.length + step.plastic,
                 plastic_by_limit = along.dot(start_by_limit) - 1.0 / k;
    fraction_by_path =
        (step.plastic * length_by_path - step.length * along.transpose()) / (both * both);
    fraction_by_limit =
        (step.plastic * length_by_limit - step.length * plastic_by_limit) / (both * both);
  }
  slopes.by_path =
      -k * ((1.0 - 0.5 * step.fraction) * end_by_path - 0.5 * step.elastic * fraction_by_path);
  slopes.by_limit = -k * (end_by_limit - 0.5 * step.fraction * elastic_by_limit -
                          (0.5 * fraction_by_limit) * step.elastic);
  const double damper = law.damping * step.length;
  if (!(damper > 0.0)) {
    // At rest the damper acts as soon as the point moves.
    if (step.plastic == 0.0) slopes.by_path -= law.damping * end_by_path;
    return slopes;
  }
  const Vector3d spring = spring_force(k, step);
  const double force = spring.norm(), room = limit - force;
  if (damper <= room) {
    slopes.by_path -= law.damping * end_by_path;
    slopes.by_limit -= law.damping * elastic_by_limit;
    return slopes;
  }
  if (!(room > 0.0)) return slopes;
  const Vector3d unit = force > 0.0 ? Vector3d(spring / force) : spring;
  const Eigen::RowVector3d room_by_path = -unit.transpose() * slopes.by_path;
  const double room_by_limit = 1.0 - unit.dot(slopes.by_limit);
  slopes.by_path -=
      way * room_by_path + (room / step.length) * (end_by_path - way * length_by_path);
  slopes.by_limit -=
      way * room_by_limit + (room / step.length) * (elastic_by_limit - way * length_by_limit);
  return slopes;
}

Vector3d turn_to_plane(const Vector3d& vector, const Vector3d& from, const Vector3d& to) {
  const double beside = 1.0 + from.dot(to);
  if (!(beside > 1e-6)) return Vector3d::Zero();
  return vector - (to.dot(vector) / beside) * (from + to);
}

}  // namespace tremolo
