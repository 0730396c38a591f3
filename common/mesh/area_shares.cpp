#include "common/mesh/area_shares.h"

#include <algorithm>
#include <cstddef>

namespace tremolo {

std::vector<double> area_shares(std::span<const VertexId> chosen,
                                std::span<const VertexId> vertex_ids,
                                std::span<const Triangle> triangles,
                                std::span<const Eigen::Vector3d> rest) {
  std::vector<double> area(vertex_ids.size(), 0.0);
  std::vector<bool> is_chosen(vertex_ids.size(), false);
  const auto row_of = [&](VertexId id) {
    return std::lower_bound(vertex_ids.begin(), vertex_ids.end(), id) - vertex_ids.begin();
  };
  const auto is_there = [&](std::ptrdiff_t row, VertexId id) {
    return static_cast<std::size_t>(row) < vertex_ids.size() && vertex_ids[row] == id;
  };
  for (const VertexId id : chosen)
    if (const std::ptrdiff_t row = row_of(id); is_there(row, id)) is_chosen[row] = true;
  double total = 0.0;
  for (const Triangle& t : triangles) {
    if (!is_chosen[t[0]] || !is_chosen[t[1]] || !is_chosen[t[2]]) continue;
    const double twice = (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]).norm();
    for (const VertexId corner : t) area[corner] += twice / 6.0;
    total += twice / 2.0;
  }
  std::vector<double> shares(chosen.size(), 1.0 / static_cast<double>(chosen.size()));
  if (!(total > 0.0)) return shares;
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    const std::ptrdiff_t row = row_of(chosen[n]);
    shares[n] = is_there(row, chosen[n]) ? area[row] / total : 0.0;
  }
  return shares;
}

}  // namespace tremolo
