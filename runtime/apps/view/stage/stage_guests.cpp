// Stage: the guests of a world, cloths and bodies of tetrahedra.
#include <algorithm>

#include "runtime/apps/view/stage/stage.h"
#include "runtime/io/exchange/nodal_tracks.h"

namespace tremolo {

using Eigen::Vector3d;
using Eigen::Vector3f;

Status Stage::add_guests(const LiveGuests& guests, const std::vector<Vector3f>& paints) {
  for (std::size_t i = 0; i < guests.size(); ++i) {
    const std::span<const Triangle> all = guests.triangles(i);
    if (all.empty())
      return content_error("body '" + guests.name(i) +
                           "': its model has no surface, there is nothing to show");
    StagedBody staged;
    staged.colour = paints[bodies_.size()];
    staged.own_frame = false;
    staged.is_cloth = guests.is_cloth(i);
    staged.rest = guests.rest(i);
    staged.triangles.assign(all.begin(), all.end());
    std::vector<std::uint32_t> triangles;
    for (const Triangle& triangle : all)
      for (const VertexId v : triangle) triangles.push_back(static_cast<std::uint32_t>(v));
    staged.mesh = GpuMesh(triangles, std::vector<float>(3 * staged.rest.size()));
    staged.ranges = {{0, all.size(), 0}};
    staged.images.resize(1);
    bodies_.push_back(std::move(staged));
  }
  return Success{};
}

// The distances of a guest's vertices from where they would be without deformation.
void Stage::measure_guest(StagedBody& body) {
  places_.resize(body.rest.size());
  for (std::size_t v = 0; v < places_.size(); ++v)
    places_[v] = Eigen::Map<const Vector3f>(body.positions.data() + 3 * v).cast<double>();
  const Pose frame = nearest_pose(body.rest, places_);
  body.distances.resize(places_.size());
  for (std::size_t v = 0; v < places_.size(); ++v) {
    body.distances[v] = static_cast<float>((places_[v] - frame * body.rest[v]).norm());
    most_moved_ = std::max(most_moved_, body.distances[v]);
  }
}

bool Stage::knows_degrees() const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [](const StagedBody& body) { return !body.degrees.empty(); });
}

// The numbers of a guest that are its colours; null: it keeps its own colour.
const std::vector<float>* Stage::numbers_of(const StagedBody& body, ColourBy colour) {
  if (colour == ColourBy::kMoved && !body.distances.empty()) return &body.distances;
  if (colour == ColourBy::kDegree && !body.degrees.empty()) return &body.degrees;
  return nullptr;
}

}  // namespace tremolo
