#include "precompute/modes/mode_clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/text.h"
#include "common/units.h"
#include "precompute/dense/dense_decompositions.h"

namespace tremolo {
namespace {

// S = 1 + sum a sin(w.x + phase) d d^T, with x from the centre of the bounding box in units of its
// diagonal. The numbers are arbitrary, chosen so that no rotation or reflection of a body leaves S
// unchanged. Long and short waves are both needed: modes of a ring with n waves require 2n of them.
struct Wave {
  Eigen::Vector3d direction;  // d, normalised in block_at
  Eigen::Vector3d wave;       // w, radians a diagonal
  double phase;
};
const Wave kWaves[] = {{{7, 2, -3}, {1.1, -0.7, 0.9}, 1.3},
                       {{-2, 9, 5}, {-3.1, 2.3, 4.7}, 0.8},
                       {{1, -4, 11}, {7.9, 6.1, -5.3}, 2.1},
                       {{8, 5, 6}, {-13.7, 17.3, 11.9}, 0.4}};
constexpr double kSize = 0.4;  // amplitude a of a wave: S stays definite nearly everywhere

Eigen::Matrix3d block_at(const Eigen::Vector3d& x) {
  Eigen::Matrix3d block = Eigen::Matrix3d::Identity();
  for (const Wave& wave : kWaves) {
    const Eigen::Vector3d d = wave.direction.normalized();
    block += kSize * std::sin(wave.wave.dot(x) + wave.phase) * d * d.transpose();
  }
  return block;
}

Columns marked(const Marker& marker, const Columns& vectors) {
  Columns result(vectors.rows(), vectors.cols());
  for (std::size_t node = 0; node < marker.blocks.size(); ++node) {
    const auto row = 3 * static_cast<Eigen::Index>(node);
    result.middleRows<3>(row) = marker.blocks[node] * vectors.middleRows<3>(row);
  }
  return result;
}

}  // namespace

bool Nearness::operator()(double a, double b) const {
  constexpr double kMost = 1e-3;  // relative; values farther apart have well-determined vectors
  const double distance = std::abs(a - b), larger = std::max(std::abs(a), std::abs(b));
  return distance <= std::min(std::max(relative * larger, absolute), kMost * larger);
}

Nearness nearness(double lowest, double cancellation) {
  // Measured noise is a tenth of eps / c, so this bound leaves a margin of a thousand.
  constexpr double kNoise = 100.0 * std::numeric_limits<double>::epsilon();
  return {kClusterGap, cancellation > 0 ? kNoise * lowest / cancellation : 0.0};
}

std::vector<Cluster> find_clusters(const Eigen::VectorXd& values, const Nearness& near) {
  std::vector<Cluster> clusters;
  for (Eigen::Index first = 0, end = 0; first < values.size(); first = end) {
    end = first + 1;
    while (end < values.size() && near(values[end - 1], values[end])) ++end;
    if (end - first > 1) clusters.push_back({first, end - first});
  }
  return clusters;
}

Cluster cluster_at_cut(const Eigen::VectorXd& values, Eigen::Index count, const Nearness& near) {
  for (const Cluster& cluster : find_clusters(values, near))
    if (cluster.first < count && count < cluster.first + cluster.count) return cluster;
  return {};
}

Marker make_marker(const TetMesh& mesh, const std::vector<int>& part_of_vertex,
                   const LocalDofs& local) {
  std::vector<Eigen::Vector3d> used;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (part_of_vertex[v] >= 0) used.push_back(mesh.vertices[v]);
  const BoundingBox box = bounding_box(used);
  const Eigen::Vector3d middle = 0.5 * (box.low + box.high);
  Marker marker;
  marker.blocks.resize(local.nodes);
  for (std::size_t i = 0; i < local.vertices.size(); ++i)
    if (const int row = local.row_of_vertex[i]; row >= 0)
      marker.blocks[row / 3] =
          block_at((mesh.vertices[local.vertices[i]] - middle) / box.diagonal());
  return marker;
}

Eigen::MatrixXd canonical_rotation(Mat mass, const Marker& marker, const Columns& vectors) {
  const Columns x = marked(marker, vectors);
  const Eigen::MatrixXd products = inner_products(x, multiply(mass, x));
  Eigen::MatrixXd rotation = eigenpairs(products).vectors;
  // Processors of different kinds may round differently, so all ranks use the result of rank 0.
  MPI_Bcast(rotation.data(), static_cast<int>(rotation.size()), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  return rotation;
}

void make_canonical(Mat mass, const Marker& marker, const std::vector<Cluster>& clusters,
                    Columns& vectors) {
  for (const Cluster& cluster : clusters) {
    const Columns old = vectors.middleCols(cluster.first, cluster.count);
    vectors.middleCols(cluster.first, cluster.count) = old * canonical_rotation(mass, marker, old);
  }
}

namespace {

// Returns the squared frequencies and the first one without a vector, if there is one.
Eigen::VectorXd all_values(const Modes& modes) {
  Eigen::VectorXd values = modes.squared_frequencies;
  if (modes.next_squared_frequency > 0) {
    values.conservativeResize(values.size() + 1);
    values[values.size() - 1] = modes.next_squared_frequency;
  }
  return values;
}

// The eigensolver's residuals hold for the span of a cluster: each member gets the largest.
void share_residuals(const std::vector<Cluster>& clusters, Eigen::VectorXd& residuals) {
  for (const Cluster& cluster : clusters) {
    auto own = residuals.segment(cluster.first, cluster.count);
    own.setConstant(own.maxCoeff());
  }
}

void keep_first(Eigen::Index kept, const Eigen::VectorXd& values, Modes& modes) {
  modes.squared_frequencies = values.head(kept);
  modes.vectors.conservativeResize(Eigen::NoChange, kept);
  modes.residuals.conservativeResize(kept);
  modes.left_out.assign(values.begin() + kept, values.end());
  modes.next_squared_frequency = modes.left_out.empty() ? 0.0 : modes.left_out.front();
}

std::string note_on_cut(const Cluster& cluster, bool whole, Eigen::Index count, Eigen::Index kept,
                        double frequency) {
  const auto end = static_cast<int>(cluster.first + cluster.count);
  const bool two = cluster.count == 2;
  const std::string same =
      text("modes %d %s %d have the same frequency (%.6g Hz)", static_cast<int>(cluster.first + 1),
           two ? "and" : "to", end, frequency);
  if (!whole)
    return same +
           ", and perhaps more: which of them are in the model is left to chance; take "
           "fewer or more --linear-modes";
  if (kept == end) return text("%d linear modes, not %d: ", end, static_cast<int>(count)) + same;
  return same + text("; --linear-modes %d takes %s", end, two ? "both" : "all of them");
}

}  // namespace

ModeCut cut_of(const Modes& modes, int count, int available) {
  ModeCut cut;
  cut.values = all_values(modes);
  cut.near = nearness(cut.values[0], modes.cancellation);
  cut.cluster = cluster_at_cut(cut.values, count, cut.near);
  cut.whole =
      cut.cluster.first + cut.cluster.count < cut.values.size() || cut.values.size() >= available;
  return cut;
}

WholeModes make_whole(Mat mass, const Marker& marker, int count, int available, bool extend,
                      Modes modes) {
  const auto [values, near, cluster, whole] = cut_of(modes, count, available);
  const std::vector<Cluster> clusters = find_clusters(modes.squared_frequencies, near);
  share_residuals(clusters, modes.residuals);
  make_canonical(mass, marker, clusters, modes.vectors);
  Eigen::Index kept = count;
  const Eigen::Index end = cluster.first + cluster.count;
  if (extend && whole && end > count && end - count <= kMostAdded) kept = end;
  keep_first(kept, values, modes);
  WholeModes result{std::move(modes), ""};
  if (cluster.count > 0)
    result.note = note_on_cut(cluster, whole, count, kept, hertz(values[cluster.first]));
  return result;
}

}  // namespace tremolo
