#include "precompute/reference/world/world_step.h"

#include <cmath>

#include "common/text.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

RigidMotion support_at(const WorldBody& world, double time) {
  return world.path == nullptr ? RigidMotion{} : world.path->at(time);
}

double whole_kinetic(const WorldBody& world, const Motion& motion) {
  const Field v = whole_velocity(world, motion);
  return 0.5 * v.dot(whole_mass_times(world, v));
}

// Multiplies the velocity relative to the support at the motion's time by `factor`.
void damp_by_mass(const WorldBody& world, double factor, Motion& motion) {
  if (factor == 1.0) return;
  const RigidMotion support = support_at(world, motion.time);
  const Vector relative = motion.v - riding_velocity(world, support, motion.u);
  const double before = whole_kinetic(world, motion);
  motion.v -= (1.0 - factor) * relative;
  motion.kinetic = whole_kinetic(world, motion);
  const double taken =
      0.5 * (1.0 - factor * factor) * relative.dot(multiply(world.body, world.body.mass, relative));
  motion.dissipated += taken;
  motion.work += motion.kinetic - before + taken;
}

// The work of the support in a step, J. acceleration: mean of all vertices, 3n.
double support_work(const WorldBody& world, const std::vector<SegmentPoint>& points,
                    const Motion& motion, const Vector& d, const Field& acceleration) {
  if (world.path == nullptr) return 0.0;
  const FullOrder& body = world.body;
  const Field force = whole_mass_times(world, acceleration) + held_force(body, points, motion.u, d);
  return force.dot(body.support.by);
}

}  // namespace

Motion start_in_world(const WorldBody& world, const RigidMotion& flight) {
  Motion motion;
  const RigidMotion support = world.path == nullptr ? flight : support_at(world, 0.0);
  motion.u.resize(world.body.size());
  for (Eigen::Index i = 0; i < motion.u.size(); i += 3) {
    const std::size_t vertex = world.body.unknowns.dof[i] / 3;
    const Eigen::Vector3d& rest = world.body.solid.mesh.vertices[vertex];
    motion.u.segment<3>(i) = world.path == nullptr ? Eigen::Vector3d::Zero().eval()
                                                   : (support.place(rest) - rest).eval();
  }
  motion.v = riding_velocity(world, support, motion.u);
  motion.kinetic = whole_kinetic(world, motion);
  return motion;
}

Field whole_displacement(const WorldBody& world, const Motion& motion) {
  Field field = expand(world.body.unknowns, motion.u);
  if (world.path != nullptr) field += held_displacement(world, support_at(world, motion.time));
  return field;
}

Field whole_velocity(const WorldBody& world, const Motion& motion) {
  Field field = expand(world.body.unknowns, motion.v);
  if (world.path != nullptr) field += held_velocity(world, support_at(world, motion.time));
  return field;
}

void advance_in_world(WorldBody& world, const TimeSettings& settings, const LoadHistory& load,
                      Motion& motion) {
  FullOrder& body = world.body;
  const double h = settings.step, time = motion.time;
  const double factor = std::exp(-0.5 * settings.alpha * h);
  damp_by_mass(world, factor, motion);
  Field acceleration = Field::Zero(body.unknowns.of_dof.size());
  if (world.path != nullptr) {
    const RigidMotion start = support_at(world, time), end = support_at(world, time + h);
    body.support.from = held_displacement(world, start);
    body.support.by = held_displacement(world, end) - body.support.from;
    acceleration = (held_velocity(world, end) - held_velocity(world, start)) / h;
  }
  const Vector pull = load(time, h);
  StepEquation equation{2.0 / (h * h), 0.0, segment_points(settings.scheme, settings.beta / h),
                        motion.u, (-2.0 / h) * multiply(body, body.mass, motion.v) - pull};
  if (world.path != nullptr)
    equation.constant += restrict_to(body.unknowns, whole_mass_times(world, acceleration));

  Vector d = h * motion.v;
  if (motion.last_steps.size() == 3)
    d = 3.0 * (motion.last_steps[0] - motion.last_steps[1]) + motion.last_steps[2];
  const SolveReport report = solve(world.solver, equation, std::max(0.0, motion.total()), d);
  motion.iterations += report.iterations;
  motion.linear_iterations += report.linear_iterations;
  motion.factorisations += report.factorisations;
  if (!report.converged)
    throw Failure({ErrorKind::kSolver,
                   text("the step from t = %.6g s did not converge: take a smaller --step", time)});
  if (report.scale > 0)
    motion.worst_residual = std::max(motion.worst_residual, report.residual / report.scale);

  acceleration += expand(body.unknowns, (2.0 / h) * (d / h - motion.v));
  motion.work += pull.dot(d) + support_work(world, equation.points, motion, d, acceleration);
  if (settings.beta > 0)
    motion.dissipated += (settings.beta / h) * strain_change_work(body, motion.u, d);
  motion.v = (2.0 / h) * d - motion.v;
  motion.u += d;
  motion.potential = potential_energy(body, motion.u);
  ++motion.steps;
  motion.time = static_cast<double>(motion.steps) * h;
  motion.kinetic = whole_kinetic(world, motion);
  damp_by_mass(world, factor, motion);
  motion.last_steps.insert(motion.last_steps.begin(), std::move(d));
  if (motion.last_steps.size() > 3) motion.last_steps.pop_back();
}

namespace {

template <class ValueAt>
Field of_held(const WorldBody& world, const ValueAt& value_at) {
  const std::vector<int>& of_dof = world.body.unknowns.of_dof;
  Field field = Field::Zero(of_dof.size());
  for (std::size_t v = 0; 3 * v < of_dof.size(); ++v)
    if (of_dof[3 * v] < 0)
      field.segment<3>(3 * static_cast<Eigen::Index>(v)) =
          value_at(world.body.solid.mesh.vertices[v]);
  return field;
}

}  // namespace

Field held_displacement(const WorldBody& world, const RigidMotion& support) {
  return of_held(world, [&](const Eigen::Vector3d& rest) -> Eigen::Vector3d {
    return support.place(rest) - rest;
  });
}

Field held_velocity(const WorldBody& world, const RigidMotion& support) {
  return of_held(world, [&](const Eigen::Vector3d& rest) -> Eigen::Vector3d {
    return support.velocity_at(support.place(rest));
  });
}

Vector riding_velocity(const WorldBody& world, const RigidMotion& support, const Vector& u) {
  const Unknowns& unknowns = world.body.unknowns;
  Vector velocity(u.size());
  for (Eigen::Index i = 0; i < u.size(); i += 3) {
    const std::size_t vertex = unknowns.dof[i] / 3;
    velocity.segment<3>(i) =
        support.velocity_at(world.body.solid.mesh.vertices[vertex] + u.segment<3>(i));
  }
  return velocity;
}

Field whole_mass_times(const WorldBody& world, const Field& x) {
  const Solid& solid = world.body.solid;
  Field product = Field::Zero(x.size());
  for (std::size_t e = 0; e < solid.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (int a = 0; a < nodes.count; ++a)
      for (int b = 0; b < nodes.count; ++b)
        product.segment<3>(3 * Eigen::Index{nodes[a]}) +=
            element_mass(solid, e, a, b, world.mass) * x.segment<3>(3 * Eigen::Index{nodes[b]});
  }
  for (std::size_t v = 0; v < solid.point_mass.size(); ++v) {
    const auto at = 3 * static_cast<Eigen::Index>(v);
    product.segment<3>(at) += solid.point_mass[v] * x.segment<3>(at);
  }
  return product;
}

}  // namespace tremolo
