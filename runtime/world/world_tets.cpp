#include "runtime/world/world_tets.h"

#include <memory>
#include <utility>

#include "common/text.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

// The shapes that bodies of tetrahedra must not begin in, with their names.
struct Solids {
  std::vector<PlacedCollider> shapes;
  std::vector<std::string> names;
};

Solids solids_of(const SceneWorld& world) {
  Solids solids;
  for (std::size_t c = 0; c < world.colliders().size(); ++c) {
    solids.shapes.push_back(world.colliders()[c]);
    solids.names.push_back("collider '" + world.scene().colliders[c].name + "'");
  }
  for (std::size_t i = 0; i < world.size(); ++i) {
    const ContactStep* contact = world.body(i).contact();
    if (contact == nullptr || contact->shape() == nullptr) continue;
    const Pose pose = world.body(i).pose();
    solids.shapes.push_back({*contact->shape(), pose, pose});
    solids.names.push_back("body '" + world.name(i) + "'");
  }
  return solids;
}

Status check_apart(const TetGuests& guests, std::size_t i, const Solids& solids) {
  for (std::size_t k = 0; k < solids.shapes.size(); ++k) {
    const double depth = guests.deepest_in(i, std::span(&solids.shapes[k], 1));
    if (depth > guests.margin(i))
      return content_error("it begins " + number_text(depth) + " m inside " + solids.names[k] +
                           ", more than its contact-margin of " + number_text(guests.margin(i)) +
                           " m: put one of them elsewhere");
  }
  return Success{};
}

}  // namespace

Result<WorldTets> add_tets(std::span<const TetSceneBody> bodies, const std::string& path,
                           SceneWorld& world) {
  Result<PlacedTets> placed = place_tets(bodies, path);
  if (!placed) return placed.error();
  auto guests = std::make_unique<TetGuests>(world.step_size());
  const Solids solids = solids_of(world);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (const auto added = guests->add(bodies[i].name, std::move(placed->bodies[i]),
                                       bodies[i].contact, placed->kinds[placed->kind_of[i]].hull);
        !added)
      return error_of_file(path, added.error());
    if (Status s = check_apart(*guests, i, solids); !s)
      return error_of_file(
          path, Error{s.error().kind, "body '" + bodies[i].name + "': " + s.error().message});
  }
  WorldTets tets{std::move(placed->kinds), std::move(placed->kind_of), guests.get()};
  world.set_guests(std::move(guests));
  return tets;
}

}  // namespace tremolo
