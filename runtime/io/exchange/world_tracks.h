// Records a world of bodies of all kinds, which may come and go between two frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_body.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/io/exchange/recording.h"
#include "runtime/world/world.h"

namespace tremolo {

// A body or a collider of a world in one frame. One of the pointers is not null.
struct RecordedThing {
  std::uint64_t id = 0;  // the same in all frames, and of nothing else
  std::string name;
  const Body* body = nullptr;  // reduced or rigid
  const TetsKind* kind = nullptr;
  const TetBody* tets = nullptr;  // of that kind
  const ClothBody* cloth = nullptr;
  const Collider* collider = nullptr;
  Pose pose = {};  // of the collider
};

// All that is in a world now: reduced and rigid bodies, colliders if requested, tetrahedra and
// cloths. The things refer to the world.
std::vector<RecordedThing> things_of(const World& world, bool colliders);
// The same of a world without changes. guests: null: there are none.
std::vector<RecordedThing> things_of(const SceneWorld& world, const WorldGuests* guests,
                                     bool colliders);

// The tracks of one world in a recording.
class WorldTracks {
 public:
  // Records the frame that was begun: adds tracks of what is new, ends those of what is gone. A
  // name that another track has gets "-2" appended, that of a collider "-collider". Errors of
  // Recording::record(), and of cloth_shape().
  Status record(const std::vector<RecordedThing>& things, Recording& recording);

  // Names of colliders without triangles, whose file has only distances: they are not recorded.
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  struct Track {
    std::size_t number = 0;
    bool drawn = true, seen = false;
    AnimatedShape shape = {};  // of tetrahedra and cloths: vertices that they are displaced from
  };

  Status add(const RecordedThing& thing, Recording& recording, Track& track);
  Status record_thing(const RecordedThing& thing, const Track& track, Recording& recording);

  std::map<std::uint64_t, Track> tracks_;  // by the ids of things
  // Shapes of tetrahedra by their surfaces, which are kept since a later one could have the
  // address.
  std::map<std::shared_ptr<const TetSurface>, std::size_t> shapes_;
  std::vector<std::string> left_out_;
  std::vector<double> displacements_;  // of one body
};

}  // namespace tremolo
