#include "runtime/io/exchange/world_tracks.h"

#include <optional>
#include <span>
#include <string>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/io/exchange/nodal_tracks.h"

namespace tremolo {
namespace {

constexpr std::uint64_t kColliders = std::uint64_t{1} << 63;  // ids from here on
constexpr std::uint64_t kGuests = std::uint64_t{1} << 62;     // in worlds without changes

// own_id, guest_id: of a number in the world -> the id; kind: of a guest of tetrahedra.
template <class OwnId, class GuestId, class Kind>
std::vector<RecordedThing> list_things(const SceneWorld& world, bool colliders, const OwnId& own_id,
                                       const GuestId& guest_id, const Kind& kind) {
  std::vector<RecordedThing> things;
  for (std::size_t i = 0; i < world.size(); ++i)
    if (!world.removed(i))
      things.push_back({.id = own_id(i), .name = world.name(i), .body = &world.body(i)});
  for (std::size_t c = 0; colliders && c < world.colliders().size(); ++c) {
    if (world.collider_removed(c)) continue;
    // A collider is at the end of the last step; before the first step, at its start.
    const PlacedCollider& placed = world.colliders()[c];
    things.push_back({.id = kColliders + c,
                      .name = world.scene().colliders[c].name,
                      .collider = &placed.shape,
                      .pose = world.steps() == 0 ? placed.start : placed.end});
  }
  const MixedGuests* guests = guests_of(world);
  for (std::size_t i = 0; guests != nullptr && i < guests->size(); ++i) {
    if (guests->removed(i)) continue;
    RecordedThing thing{.id = guest_id(i), .name = guests->name(i)};
    if (const TetStep* tets = guests->tets(i)) {
      thing.kind = &kind(i);
      thing.tets = &tets->body();
    } else {
      thing.cloth = &guests->cloth(i)->body();
    }
    things.push_back(std::move(thing));
  }
  return things;
}

}  // namespace

std::vector<RecordedThing> things_of(const World& world, bool colliders) {
  const auto id = [](WorldBody body) { return (std::uint64_t{body.generation} << 32) | body.slot; };
  return list_things(
      world.own(), colliders, [&](std::size_t i) { return id(world.of_own(i)); },
      [&](std::size_t i) { return id(world.of_guest(i)); },
      [&](std::size_t i) -> const TetsKind& { return world.tets_kind(world.of_guest(i)); });
}

std::vector<RecordedThing> things_of(const SceneWorld& world, const WorldGuests* guests,
                                     bool colliders) {
  return list_things(
      world, colliders, [](std::size_t i) { return i; }, [](std::size_t i) { return kGuests + i; },
      [guests](std::size_t i) -> const TetsKind& { return guests->kind(i); });
}

Status WorldTracks::add(const RecordedThing& thing, Recording& recording, Track& track) {
  std::string name = thing.name;
  const char* more = thing.collider != nullptr ? "-collider" : "-2";
  while (recording.has_name(name)) name += more;
  if (thing.body != nullptr) return take(track.number, recording.add(*thing.body, name));
  if (thing.collider != nullptr) {
    std::optional<AnimatedShape> shape = collider_shape(*thing.collider, thing.name, 1.0);
    track.drawn = shape.has_value();
    if (shape) return take(track.number, recording.add(std::move(*shape), name));
    left_out_.push_back(thing.name);
    return Success{};
  }
  std::size_t shape = 0;
  if (thing.cloth != nullptr) {
    if (Status s = take(track.shape, cloth_shape(thing.cloth->cloth())); !s) return s;
    shape = recording.add_shape(track.shape);
  } else {
    track.shape = tets_shape(*thing.kind);
    const auto [known, is_new] = shapes_.try_emplace(thing.kind->surface, 0);
    if (is_new) known->second = recording.add_shape(track.shape);
    shape = known->second;
  }
  return take(track.number, recording.add_free(shape, name));
}

Status WorldTracks::record_thing(const RecordedThing& thing, const Track& track,
                                 Recording& recording) {
  if (!track.drawn) return Success{};
  if (thing.body != nullptr) return recording.record(track.number, *thing.body);
  if (thing.collider != nullptr)
    return recording.record(track.number, {}, std::span(&thing.pose, 1));
  displacements_.clear();
  Pose pose;
  if (thing.tets != nullptr)
    pose = tets_frame(*thing.kind, thing.tets->positions(), track.shape, displacements_);
  else
    cloth_frame(thing.cloth->model().parts(), thing.cloth->state().x, track.shape, displacements_);
  return recording.record_free(track.number, displacements_, pose);
}

Status WorldTracks::record(const std::vector<RecordedThing>& things, Recording& recording) {
  for (auto& [id, track] : tracks_) track.seen = false;
  for (const RecordedThing& thing : things) {
    const auto [known, is_new] = tracks_.try_emplace(thing.id);
    if (is_new)
      if (Status s = add(thing, recording, known->second); !s) {
        tracks_.erase(known);
        return s;
      }
    known->second.seen = true;
    if (Status s = record_thing(thing, known->second, recording); !s) return s;
  }
  for (auto track = tracks_.begin(); track != tracks_.end();) {
    const auto next = std::next(track);
    if (!track->second.seen) {
      if (track->second.drawn)
        if (Status s = recording.end(track->second.number); !s) return s;
      tracks_.erase(track);
    }
    track = next;
  }
  return Success{};
}

}  // namespace tremolo
