#include "runtime/world/world_guests.h"

#include <memory>
#include <utility>

#include "common/text.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/guest_links.h"
#include "runtime/world/guest_loads.h"

namespace tremolo {
namespace {

// The shapes that guests must not begin in, with their names.
struct Solids {
  std::vector<PlacedCollider> shapes;
  std::vector<std::string> names;
  std::vector<PresentPlace> places;  // of bodies
};

// None while the world's changes are made again (SceneWorld::set_replaying()).
Solids solids_of(const SceneWorld& world) {
  Solids solids;
  if (world.replaying()) return solids;
  for (std::size_t c = 0; c < world.colliders().size(); ++c) {
    solids.shapes.push_back(world.colliders()[c]);
    solids.names.push_back("collider '" + world.scene().colliders[c].name + "'");
    solids.places.emplace_back();
  }
  for (std::size_t i = 0; i < world.size(); ++i) {
    const ContactStep* contact = world.body(i).contact();
    if (contact == nullptr || !contact->surface().shape) continue;
    const Pose pose = world.body(i).pose();
    solids.shapes.push_back({*contact->surface().shape, pose, pose});
    solids.names.push_back("body '" + world.name(i) + "'");
    solids.places.push_back(world.body(i).present_place());
  }
  return solids;
}

// margin_name: the key of the scene.
Status check_apart(const MixedGuests& guests, std::size_t i, const Solids& solids,
                   const char* margin_name) {
  for (std::size_t k = 0; k < solids.shapes.size(); ++k) {
    const double depth = solids.places[k].bones || solids.places[k].points
                             ? guests.deepest_in(i, solids.shapes[k].shape, solids.places[k])
                             : guests.deepest_in(i, std::span(&solids.shapes[k], 1));
    if (depth > guests.margin(i))
      return content_error("body '" + guests.name(i) + "': it begins " + number_text(depth) +
                           " m inside " + solids.names[k] + ", more than its " + margin_name +
                           " of " + number_text(guests.margin(i)) +
                           " m: put one of them elsewhere");
  }
  return Success{};
}

// path: empty: the scene has no file.
Error of_file(const std::string& path, const Error& error) {
  return path.empty() ? error : error_of_file(path, error);
}

// The world gets room for a guest of that name.
Status begin_adding(const std::string& name, SceneWorld& world) {
  if (world.has_name(name)) return content_error("two bodies are called '" + name + "'");
  if (world.guests() != nullptr) return Success{};
  if (Status s = world.expect_guests(); !s) return s;
  auto guests = std::make_unique<MixedGuests>(world.step_size());
  Result<std::unique_ptr<GuestLinks>> links = make_guest_links(world, *guests);
  if (!links) return links.error();
  world.set_guests(std::move(guests), std::move(*links), {});
  return Success{};
}

// An error of a load is one of the scene, which has it.
Status take_loads(MixedGuests& guests, std::size_t guest, std::span<const SceneLoad> loads) {
  const Status taken = add_guest_loads(guests, guest, loads);
  return taken ? taken : Status(content_error(taken.error().message));
}

// A value out of range is an error of the scene, which has it.
Error of_scene(Error error) {
  if (error.kind == ErrorKind::kUsage) error.kind = ErrorKind::kContent;
  return error;
}

// Runs add(MixedGuests) -> Result<AddedGuest>. If it fails, the world is as it was before.
template <class Add>
Result<AddedGuest> add_or_take_back(const std::string& name, const std::string& path,
                                    SceneWorld& world, const Add& add) {
  const SceneWorld::BeforeChange before = world.before_change();
  const auto added = [&]() -> Result<AddedGuest> {
    if (Status s = begin_adding(name, world); !s) return of_file(path, s.error());
    return add(*guests_of(world));
  }();
  if (!added) world.take_back(before);
  return added;
}

// The start of a guest. margin_name: the key of the scene. settled: in equilibrium under its loads.
struct GuestStart {
  const char* margin_name;
  std::span<const SceneLoad> loads;
  bool settled;
};

GuestStart start_of(const TetSceneBody& body) {
  return {"contact-margin", body.loads, body.settled};
}
GuestStart start_of(const ClothSceneBody& body) {
  return {"thickness", body.loads, body.cloth().settled};
}

// Gives the guest its loads and puts it into its equilibrium, which must be apart from the solids.
Status place_guest(MixedGuests& guests, std::size_t guest, const Solids& solids,
                   const GuestStart& start) {
  if (Status s = take_loads(guests, guest, start.loads); !s) return s;
  if (start.settled)
    if (Status s = guests.settle(guest); !s) return s;
  return check_apart(guests, guest, solids, start.margin_name);
}

// The rest of adding a body that is among the guests already. count: their number before. If the
// body cannot stay, it is not among them afterwards.
Status begin_guest(MixedGuests& guests, std::size_t guest, std::size_t count,
                   const SceneWorld& world, const GuestStart& start) {
  const Status good = place_guest(guests, guest, solids_of(world), start);
  if (!good) guests.take_back(guest, count);
  return good;
}

}  // namespace

GuestEnergy energy_of(const MixedGuests& guests, std::size_t guest) {
  if (const TetStep* tets = guests.tets(guest)) {
    TetBody& body = tets->body();
    return {body.kinetic_energy(), body.elastic_energy(), body.gravity_energy()};
  }
  const ClothBody& cloth = guests.cloth(guest)->body();
  const double elastic = cloth.elastic_energy();
  return {cloth.kinetic_energy(), elastic, 0.0 - cloth.work().gravity};
}

Result<WorldGuests> add_guests(std::span<const TetSceneBody> tets,
                               std::span<const ClothSceneBody> cloths, const std::string& path,
                               SceneWorld& world) {
  Result<PlacedTets> placed = place_tets(tets, path);
  if (!placed) return placed.error();
  auto guests = std::make_unique<MixedGuests>(world.step_size());
  const Solids solids = solids_of(world);
  for (std::size_t i = 0; i < tets.size(); ++i) {
    if (const auto added = guests->add(tets[i].name, std::move(placed->bodies[i]), tets[i].contact,
                                       placed->kinds[placed->kind_of[i]].hull);
        !added)
      return of_file(path, added.error());
    if (Status s = place_guest(*guests, i, solids, start_of(tets[i])); !s)
      return of_file(path, s.error());
  }
  for (const ClothSceneBody& cloth : cloths) {
    Result<ClothBody> body = ClothBody::create(cloth.scene, cloth.velocity, cloth.spin);
    if (!body) return of_file(path, of_scene(body.error()));
    const Result<std::size_t> added = guests->add(std::move(*body), cloth.contact);
    if (!added) return of_file(path, of_scene(added.error()));
    if (Status s = place_guest(*guests, *added, solids, start_of(cloth)); !s)
      return of_file(path, s.error());
  }
  Result<std::unique_ptr<GuestLinks>> links = make_guest_links(world, *guests);
  if (!links) return of_file(path, links.error());
  std::vector<SavedPart> identity = guest_parts(tets, *placed, cloths, *guests);
  WorldGuests made{std::move(placed->kinds), std::move(placed->kind_of), guests.get(), {}};
  for (std::size_t i = 0; i < guests->size(); ++i) made.at_start.push_back(energy_of(*guests, i));
  world.set_guests(std::move(guests), std::move(*links), std::move(identity));
  return made;
}

MixedGuests* guests_of(const SceneWorld& world) {
  // A SceneWorld has guests by add_guests() and add_guest() alone.
  return static_cast<MixedGuests*>(world.guests());
}

Result<AddedGuest> add_guest(const TetSceneBody& body, const std::string& path, SceneWorld& world) {
  const auto add = [&](MixedGuests& guests) -> Result<AddedGuest> {
    Result<PlacedTets> placed = place_tets(std::span(&body, 1), path);
    if (!placed) return placed.error();
    const std::size_t count = guests.size();
    const auto added =
        guests.add(body.name, std::move(placed->bodies[0]), body.contact, placed->kinds[0].hull);
    if (!added) return of_file(path, added.error());
    if (Status s = begin_guest(guests, *added, count, world, start_of(body)); !s)
      return of_file(path, s.error());
    world.note_guest(body.name, guest_parts(std::span(&body, 1), *placed, {}, guests)[0]);
    return AddedGuest{*added, std::move(placed->kinds[0])};
  };
  return add_or_take_back(body.name, path, world, add);
}

Result<AddedGuest> add_guest(const ClothSceneBody& body, const std::string& path,
                             SceneWorld& world) {
  const auto add = [&](MixedGuests& guests) -> Result<AddedGuest> {
    Result<ClothBody> cloth = ClothBody::create(body.scene, body.velocity, body.spin);
    if (!cloth) return of_file(path, of_scene(cloth.error()));
    const std::size_t count = guests.size();
    const Result<std::size_t> added = guests.add(std::move(*cloth), body.contact);
    if (!added) return of_file(path, of_scene(added.error()));
    if (Status s = begin_guest(guests, *added, count, world, start_of(body)); !s)
      return of_file(path, s.error());
    world.note_guest(body.name(), cloth_part(body, *guests.cloth(*added)));
    return AddedGuest{*added, std::nullopt};
  };
  return add_or_take_back(body.name(), path, world, add);
}

}  // namespace tremolo
