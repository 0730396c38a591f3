#include "runtime/apps/view/shape/moved_by.h"

#include <algorithm>
#include <cmath>

#include "runtime/io/exchange/nodal_tracks.h"

namespace tremolo {

using Eigen::Vector3d;

float moved_by(const std::vector<Vector3d>& rest, std::span<const float> positions,
               std::vector<float>& out) {
  constexpr double kRounded = 1e-6;
  std::vector<Vector3d> places(rest.size());
  double reach = 0.0;  // the largest coordinate, m
  for (std::size_t v = 0; v < places.size(); ++v) {
    places[v] = Eigen::Map<const Eigen::Vector3f>(positions.data() + 3 * v).cast<double>();
    reach = std::max({reach, places[v].cwiseAbs().maxCoeff(), rest[v].cwiseAbs().maxCoeff()});
  }
  const Pose frame = nearest_pose(rest, places);
  double most = 0.0;
  out.resize(places.size());
  for (std::size_t v = 0; v < places.size(); ++v) {
    const double distance = (places[v] - frame * rest[v]).norm();
    most = std::max(most, distance);
    out[v] = static_cast<float>(distance);
  }
  if (most > kRounded * reach) return static_cast<float>(most);
  out.assign(places.size(), 0.0f);
  return 0.0f;
}

}  // namespace tremolo
