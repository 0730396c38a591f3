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

void limit_undamped(CurveOptions& options) {
  constexpr int kMostPoints = 500;
  options.stability = false;
  options.most_harmonics = options.harmonics;
  options.most_points = std::min(options.most_points, kMostPoints);
}

}  // namespace tremolo
