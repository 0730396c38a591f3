#include "tests/lab/tets/bar_runs.h"

#include <cmath>

#include <Eigen/LU>

#include "common/processor_time.h"
#include "runtime/tets/contact/tet_surface.h"
#include "runtime/tets/motion/tet_body.h"
#include "tests/lab/work/failure.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo::tets {
namespace {

constexpr double kBarLength = 0.4, kBarWidth = 0.1;  // m

// The points of the bar that are compared, each in a tetrahedron that contains it.
TetsSurface bar_points(const TetMesh& mesh) {
  TetsSurface points;
  for (int i = 0; i <= 16; ++i)
    for (int j = 0; j <= 2; ++j)
      for (int k = 0; k <= 2; ++k)
        points.vertices.emplace_back(kBarLength * i / 16, kBarWidth * j / 2, kBarWidth * k / 2);
  for (const Eigen::Vector3d& x : points.vertices) {
    double best = -1e9;
    points.tetrahedra.push_back(0);
    points.weights.emplace_back(1, 0, 0, 0);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
      Eigen::Matrix4d corners;
      for (int c = 0; c < 4; ++c) {
        const VertexId v = mesh.tetrahedra[t][static_cast<std::size_t>(c)];
        corners.col(c) << mesh.vertices[static_cast<std::size_t>(v)], 1.0;
      }
      const Eigen::Vector4d w = corners.inverse() * Eigen::Vector4d(x.x(), x.y(), x.z(), 1.0);
      if (w.minCoeff() <= best) continue;
      best = w.minCoeff();
      points.tetrahedra.back() = static_cast<std::uint32_t>(t);
      points.weights.back() = w;
    }
  }
  return points;
}

TetBody bar_body(const BarCase& wanted, const TetModelPointer& model) {
  TetBodyOptions options;
  options.step = kBarStep;
  options.gravity = {0.0, 0.0, -9.81};
  options.beta = 0.01;
  options.degree.kind = wanted.kind;
  options.degree.upper = wanted.upper;
  options.degree.lower = wanted.lower;
  return or_fail(TetBody::create(model, options));
}

}  // namespace

BarRun run_bar(const BarCase& wanted) {
  const int m = wanted.cells;
  const TetMesh mesh = testing::box_mesh({4 * m, m, m}, {kBarLength, kBarWidth, kBarWidth});
  const MaterialTable materials{{{"rubber", {wanted.young, 0.4, 1000.0}}}, {}};
  const TetModelPointer model =
      or_fail(TetModel::create(mesh, materials, testing::vertices_on_plane(mesh, 0, 0.0)));
  const TetSurface surface(model, bar_points(mesh));
  TetBody body = bar_body(wanted, model);
  std::vector<Eigen::Vector3d> places(surface.vertices());
  std::vector<Eigen::Vector3f> normals(surface.vertices());
  BarRun run;
  run.elements = static_cast<double>(model->elements().size());
  run.bytes = static_cast<double>(model->bytes() + body.bytes());
  for (int k = 0; k < kBarSteps; ++k) {
    const double before = processor_time();
    const TetStepReport step = body.step();
    run.seconds += processor_time() - before;
    run.share += body.system().quadratic_share() / kBarSteps;
    run.switched += static_cast<double>(step.switched);
    run.switch_energy += step.energy_of_switch;
    run.failed += step.converged && !step.linearised ? 0.0 : 1.0;
    surface.place(body.positions(), places, normals);
    for (const Eigen::Vector3d& x : places) run.points.insert(run.points.end(), x.begin(), x.end());
  }
  return run;
}

double bar_error(const BarRun& run, const BarRun& reference) {
  const Eigen::Map<const Eigen::VectorXd> a(run.points.data(),
                                            static_cast<Eigen::Index>(run.points.size()));
  const Eigen::Map<const Eigen::VectorXd> b(reference.points.data(), a.size());
  return std::sqrt((a - b).squaredNorm() / (static_cast<double>(a.size()) / 3.0)) / kBarLength;
}

}  // namespace tremolo::tets
