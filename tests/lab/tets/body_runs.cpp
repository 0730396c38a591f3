#include "tests/lab/tets/body_runs.h"

#include <algorithm>
#include <cmath>

#include "common/processor.h"
#include "runtime/bodies/tets/contact/tet_surface.h"
#include "runtime/bodies/tets/motion/tet_body.h"
#include "tests/lab/work/failure.h"

namespace tremolo::tets {
namespace {

TetModelPointer shape_model(const Shape& shape, double young) {
  const MaterialTable materials{{{"rubber", {young, 0.4, 1000.0}}}, {}};
  return or_fail(TetModel::create(shape.mesh, materials, shape.held));
}

TetBody shape_body(const BodyCase& wanted, const TetModelPointer& model) {
  TetBodyOptions options;
  options.step = kRunStep;
  options.gravity = {0.0, 0.0, -9.81};
  options.beta = 0.01;
  options.degree.kind = wanted.kind;
  options.degree.error = wanted.error;
  return or_fail(TetBody::create(model, options));
}

double bent_share(const TetModel& model, const Eigen::VectorXd& x) {
  std::size_t bent = 0;
  for (std::size_t e = 0; e < model.edges(); ++e) {
    const MeshEdge& edge = model.edge(e);
    const Eigen::Vector3d off =
        x.segment<3>(3 * Eigen::Index{edge.point}) -
        0.5 * (x.segment<3>(3 * Eigen::Index{edge.a}) + x.segment<3>(3 * Eigen::Index{edge.b}));
    if (off.norm() > kBentEdge * model.edge_length(e)) ++bent;
  }
  return static_cast<double>(bent) / static_cast<double>(model.edges());
}

// One round of a case; the first also stores the positions of its points.
void run_once(const BodyCase& wanted, const TetModelPointer& model, const TetSurface& surface,
              BodyRun& run) {
  TetBody body = shape_body(wanted, model);
  std::vector<Eigen::Vector3d> places(surface.vertices());
  std::vector<Eigen::Vector3f> normals(surface.vertices());
  const bool first = run.seconds.empty();
  double seconds = 0.0;
  for (int k = 0; k < kRunSteps; ++k) {
    const double before = processor_time();
    const TetStepReport step = body.step();
    seconds += processor_time() - before;
    if (!first) continue;
    run.share += body.system().quadratic_share() / kRunSteps;
    run.bent += bent_share(*model, body.positions()) / kRunSteps;
    run.switched += static_cast<double>(step.switched);
    run.switch_energy += step.energy_of_switch;
    run.failed += step.converged && !step.linearised ? 0.0 : 1.0;
    surface.place(body.positions(), places, normals);
    for (const Eigen::Vector3d& x : places) run.points.insert(run.points.end(), x.begin(), x.end());
  }
  run.seconds.push_back(seconds);
  run.elements = static_cast<double>(model->elements().size());
  run.bytes = static_cast<double>(model->bytes() + body.bytes());
}

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

BodyRuns run_by_turns(const std::vector<BodyCase>& cases, int turns) {
  BodyRuns group;
  group.runs.resize(cases.size());
  const Shape shape = make_shape(cases.front().shape, cases.front().cells);
  const TetModelPointer model = shape_model(shape, cases.front().young);
  const TetSurface surface(model, shape.points);
  for (int turn = 0; turn < turns; ++turn)
    for (std::size_t i = 0; i < cases.size(); ++i)
      run_once(cases[i], model, surface, group.runs[i]);
  return group;
}

double run_distance(const BodyRun& a, const BodyRun& b, double size) {
  const Eigen::Index count = a.points.size();
  const Eigen::Map<const Eigen::VectorXd> one(a.points.data(), count);
  const Eigen::Map<const Eigen::VectorXd> other(b.points.data(), count);
  return std::sqrt((one - other).squaredNorm() / (static_cast<double>(count) / 3.0)) / size;
}

double middle_time(const BodyRun& run) {
  return middle_of(run.seconds);
}

double middle_ratio(const BodyRun& run, const BodyRun& to) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < run.seconds.size(); ++i)
    ratios.push_back(run.seconds[i] / to.seconds[i]);
  return middle_of(ratios);
}

}  // namespace tremolo::tets
