// Bodies of tetrahedra and cloths in a SceneWorld.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/mixed/mixed_guests.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Energies of a guest, J. gravity: less the work of gravity; of tetrahedra 0 at the world's origin,
// of a cloth at its start.
struct GuestEnergy {
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0;
};
GuestEnergy energy_of(const MixedGuests& guests, std::size_t guest);

// The guests of a world: bodies of tetrahedra, then cloths.
struct WorldGuests {
  std::vector<TetsKind> kinds;
  std::vector<std::size_t> kind_of;   // one per body of tetrahedra
  MixedGuests* guests = nullptr;      // the world owns them
  std::vector<GuestEnergy> at_start;  // of each guest

  const TetsKind& kind(std::size_t body) const { return kinds[kind_of[body]]; }
  std::size_t tets() const { return kind_of.size(); }
  std::size_t cloths() const { return guests == nullptr ? 0 : guests->size() - tets(); }
  // The number of a cloth among the guests.
  std::size_t of_cloth(std::size_t cloth) const { return tets() + cloth; }
};

// The identity of each guest in a saved world, as scene_parts(). placed, guests: of the same
// bodies, in their order.
std::vector<SavedPart> guest_parts(std::span<const TetSceneBody> tets, const PlacedTets& placed,
                                   std::span<const ClothSceneBody> cloths,
                                   const MixedGuests& guests);
SavedPart cloth_part(const ClothSceneBody& cloth, const ClothStep& step);

// Reads the files, moves the bodies to their positions and adds them to a world that was created
// for guests. path: of the scene, for errors; empty: it has none. Errors: those of
// make_tets_bodies(), ClothBody::create() and MixedGuests::add(); kContent for a body that begins
// inside a collider or another body by more than its margin.
Result<WorldGuests> add_guests(std::span<const TetSceneBody> tets,
                               std::span<const ClothSceneBody> cloths, const std::string& path,
                               SceneWorld& world);

// A guest that was added to a world between two steps.
struct AddedGuest {
  std::size_t number = 0;
  std::optional<TetsKind> kind;  // of tetrahedra
};

// Add a body of another kind to a world, which may have none yet. Errors: as for add_guests();
// kContent: a name that another body has.
Result<AddedGuest> add_guest(const TetSceneBody& body, const std::string& path, SceneWorld& world);
Result<AddedGuest> add_guest(const ClothSceneBody& body, const std::string& path,
                             SceneWorld& world);
// The guests of the world; null: there are none.
MixedGuests* guests_of(const SceneWorld& world);

}  // namespace tremolo
