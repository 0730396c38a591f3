#include "runtime/response/probe.h"

#include <algorithm>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

Result<Probe> moving_most(const Model& model, std::span<const VertexId> vertices,
                          Eigen::Index mode) {
  Probe probe;
  double best = -1.0;
  for (const VertexId vertex : vertices) {
    const Result<VertexRows> rows = model.vertex(vertex);
    if (!rows) return rows.error();
    probe.moves = probe.moves || !rows->rows.isZero(0.0);
    const double now = rows->rows.col(mode).norm();
    if (now <= best) continue;
    best = now;
    probe.vertex = vertex;
    probe.rows = rows->rows;
  }
  return probe;
}

double extent_of(const Model& model) {
  const BoundingBox box = bounding_box(model.drawn().rest);
  return (box.high - box.low).maxCoeff();
}

std::function<double(const FourierSeries&)> amplitude_of(const Probe& probe) {
  return [rows = probe.rows](const FourierSeries& motion) {
    return largest_over_period(rows, motion).value;
  };
}

Result<ProbeResponse> probe_response(const Model& model, VertexId vertex,
                                     const Eigen::VectorXd& forces, const FourierSeries& course,
                                     double static_scale) {
  ProbeResponse response;
  response.periodic = FourierSeries::Zero(3, course.cols());
  if (forces.size() == 0 || forces.isZero(0.0)) return response;
  const Result<VertexRows> rows = model.response(vertex);
  if (!rows) return rows.error();
  const Eigen::Vector3d displacement = rows->rows * forces;
  response.constant = static_scale * displacement;
  response.periodic = displacement * course;
  response.periodic.col(0).setZero();
  return response;
}

FourierSeries shown_motion(const Probe& probe, const ProbeResponse& response,
                           const FourierSeries& motion, double load) {
  FourierSeries shown = probe.rows * motion;
  if (response.none()) return shown;
  shown = with_harmonics(shown, std::max(harmonics_of(shown), harmonics_of(response.periodic)));
  shown.leftCols(response.periodic.cols()) += load * response.periodic;
  shown.col(0) += response.constant;
  return shown;
}

std::function<double(const FourierSeries&, double load)> loaded_amplitude_of(
    const Probe& probe, const ProbeResponse& response) {
  if (response.none()) return {};
  return [=](const FourierSeries& motion, double load) {
    return largest_over_period(Eigen::Matrix3d::Identity(),
                               shown_motion(probe, response, motion, load))
        .value;
  };
}

void limit_undamped(CurveOptions& options) {
  constexpr int kMostPoints = 500;
  options.stability = false;
  options.most_harmonics = options.harmonics;
  options.most_points = std::min(options.most_points, kMostPoints);
}

}  // namespace tremolo
