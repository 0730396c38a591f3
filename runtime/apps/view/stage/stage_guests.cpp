// Stage: the guests of a world, cloths and bodies of tetrahedra.
#include <algorithm>

#include "runtime/apps/view/stage/stage.h"

namespace tremolo {

using Eigen::Vector3f;

Status Stage::add_guests(const LiveGuests& guests, const std::vector<Vector3f>& paints) {
  for (std::size_t i = 0; i < guests.size(); ++i) {
    const std::span<const Triangle> all = guests.triangles(i);
    if (all.empty())
      return content_error("body '" + guests.name(i) +
                           "': its model has no surface, there is nothing to show");
    const Vector3f& colour = paints[bodies_.size()];
    StagedBody& staged = bodies_.emplace_back();
    staged.name = guests.name(i);
    staged.colour = colour;
    staged.own_frame = false;
    staged.is_cloth = guests.is_cloth(i);
    staged.rest = guests.rest(i);
    staged.ranges = {{0, all.size(), 0}};
    staged.sheet = CreasedSheet(staged.rest, all);
    add_mesh(staged, staged.rest, guests.uvs(i));
    const std::vector<std::optional<Material>> materials = guests.materials(i);
    if (materials.empty()) continue;
    staged.stress.emplace(staged.rest, all, materials);
    if (staged.stress->empty()) staged.stress.reset();
  }
  return Success{};
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
