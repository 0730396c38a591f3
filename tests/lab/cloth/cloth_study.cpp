#include "tests/lab/cloth/cloth_study.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/processor.h"
#include "runtime/step/nodal_integrator.h"
#include "tests/lab/work/failure.h"

namespace tremolo::cloth_study {
namespace {

constexpr double kFarAway = 1e3;     // m; a particle there has exploded
constexpr double kDisturbed = 1e-9;  // of the spacing
constexpr double kGrown = 1e6;
constexpr int kGrowthSteps = 4000;

NodalOptions study_options(double step) {
  NodalOptions options;
  options.step = step;
  // Newton's error lies below every method's own.
  options.tolerance = 1e-8;
  return options;
}

double kinetic_energy(const NodalSystem& system, const Eigen::VectorXd& v) {
  double twice = 0.0;
  for (Eigen::Index i = 0; i < system.mass().size(); ++i)
    twice += system.mass()[i] * v.segment<3>(3 * i).squaredNorm();
  return 0.5 * twice;
}

bool is_lost(const Eigen::VectorXd& x) {
  return !(x.cwiseAbs().maxCoeff() < kFarAway);
}

// The same disturbance in every run: a wave of the highest frequency with all directions in it.
Eigen::VectorXd disturbance(Eigen::Index size, double amplitude) {
  Eigen::VectorXd d(size);
  for (Eigen::Index i = 0; i < size; ++i)
    d[i] = amplitude * std::sin(12.9898 * static_cast<double>(i) + 0.5);
  return d;
}

bool stands(const NodalSystem& system, const Eigen::VectorXd& rest, const std::string& method,
            double step, double spacing) {
  const auto integrator = or_fail(make_nodal_integrator(method, system, study_options(step)));
  NodalState state{rest + disturbance(rest.size(), kDisturbed * spacing),
                   Eigen::VectorXd::Zero(rest.size()), 0.0};
  for (int k = 0; k < kGrowthSteps; ++k) {
    if (!integrator->step(state).made) return false;
    if (!((state.x - rest).cwiseAbs().maxCoeff() < kGrown * kDisturbed * spacing)) return false;
  }
  return true;
}

}  // namespace

SceneCloth study_sheet(const SheetSpec& spec) {
  SceneCloth cloth;
  cloth.grid.columns = cloth.grid.rows = spec.edge;
  cloth.grid.width = cloth.grid.height = spec.width;
  cloth.density = 0.2;
  cloth.drag = 0.0;
  cloth.structural = {spec.stiffness, spec.damping};
  cloth.shear = {spec.stiffness / 3.0, spec.damping};
  cloth.bend = {spec.stiffness / 100.0, spec.damping};
  if (spec.held)
    cloth.pins = {{{grid_particle(cloth.grid, spec.edge - 1, 0),
                    grid_particle(cloth.grid, spec.edge - 1, spec.edge - 1)},
                   {}}};
  return cloth;
}

ClothModel study_model(const SheetSpec& spec, const Eigen::Vector3d& gravity) {
  const SceneCloth cloth = study_sheet(spec);
  ClothModel model = or_fail(ClothModel::create(or_fail(make_grid_cloth(cloth))));
  model.set_gravity(gravity);
  for (const ClothPin& pin : cloth.pins)
    or_fail(model.pin(pin.particles, or_fail(MotionPath::create({})), pin.until));
  return model;
}

StudyOrbit run_case(const CaseSpec& spec) {
  const ClothModel model = study_model(spec.sheet, {0.0, 0.0, -9.81});
  const auto integrator =
      or_fail(make_nodal_integrator(spec.method, model, study_options(spec.step())));
  NodalState state{model.parts().x, Eigen::VectorXd::Zero(model.parts().x.size()), 0.0};
  StudyOrbit orbit;
  const double start = model.potential(state.x), before = processor_time();
  std::int64_t steps = 0, iterations = 0;
  for (int frame = 0; frame < spec.frames && orbit.why.empty(); ++frame) {
    for (int part = 0; part < spec.parts && orbit.why.empty(); ++part) {
      const NodalReport report = integrator->step(state);
      if (!report.made) orbit.why = "a step could not be made";
      if (is_lost(state.x)) orbit.why = "exploded";
      if (!orbit.why.empty()) break;
      ++steps;
      iterations += report.iterations;
      orbit.cut_steps += report.parts > 1 ? 1 : 0;
      orbit.damped += report.damped;
      orbit.numerical += report.numerical;
    }
    if (orbit.why.empty()) orbit.positions.push_back(state.x);
  }
  orbit.reached = static_cast<double>(steps) * spec.step();
  orbit.seconds = (processor_time() - before) / orbit.reached;
  orbit.energy = kinetic_energy(model, state.v) + model.potential(state.x) - start;
  orbit.iterations = static_cast<double>(iterations) / static_cast<double>(steps);
  return orbit;
}

double distance(const StudyOrbit& orbit, const StudyOrbit& truth) {
  if (!orbit.why.empty() || orbit.positions.size() != truth.positions.size())
    return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (std::size_t k = 0; k < orbit.positions.size(); ++k) {
    const double squares = (orbit.positions[k] - truth.positions[k]).squaredNorm();
    worst =
        std::max(worst, std::sqrt(3.0 * squares / static_cast<double>(truth.positions[k].size())));
  }
  return worst;
}

ObservedLimit find_limit(const std::string& method, const SheetSpec& spec) {
  const ClothModel model = study_model(spec, Eigen::Vector3d::Zero());
  const double spacing = spec.width / static_cast<double>(spec.edge - 1);
  const double omega = std::sqrt(largest_eigenvalue(model, model.parts().x, ForcePart::kAll));
  ObservedLimit limit{stability_number(method) / omega, 0.0};
  double good = 0.5 * limit.predicted, bad = 2.0 * limit.predicted;
  while (bad - good > 1e-3 * good) {
    const double middle = 0.5 * (good + bad);
    (stands(model, model.parts().x, method, middle, spacing) ? good : bad) = middle;
  }
  limit.observed = good;
  return limit;
}

}  // namespace tremolo::cloth_study
