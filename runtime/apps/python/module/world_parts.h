// The class tremolo.World: the world, and the objects of its bodies that Python has.
#pragma once

#include <atomic>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "runtime/apps/python/module/body_handle.h"
#include "runtime/apps/python/module/nodal_handle.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/world/world.h"

namespace tremolo::python {

// A body that is there. index: among the reduced and rigid bodies of the world, or its guests.
struct BodyNumber {
  bool guest = false;
  std::size_t index = 0;
};

// A call that changed what the world consists of, for copies and pickles. state: of the world
// before the call; empty: the call does not depend on it. after_step: the world took a step since
// the change before.
struct WorldChange {
  std::string call;
  py::tuple arguments;
  bool after_step = false;
  std::string state;
};

struct WorldParts {
  WorldParts(std::string scene_text, std::string scene_path, ClothScene surroundings,
             std::unique_ptr<World> made);

  // Bodies of the world come first, then guests, each in the order of their numbers in the engine.
  std::vector<BodyNumber> bodies() const;
  std::string name(BodyNumber body) const;
  std::optional<BodyNumber> find(const std::string& name) const;
  NodalSource& guest(BodyNumber body) { return guests.source(body.index); }
  WorldBody id(BodyNumber body) const {
    return body.guest ? all->of_guest(body.index) : all->of_own(body.index);
  }
  // The engine's number of a body that is not a guest. what: the refusal of a guest. Raises.
  std::size_t own_body(BodyNumber body, const char* what);
  // A body that was added: its model or source.
  void begin(BodyNumber body);
  // A body that is removed: its object in Python is of no body from now on.
  void end(BodyNumber body);

  void push_states();
  void pull_states();

  std::string text, path;  // of the scene file, for copies and pickles
  ClothScene around;       // of bodies that are added
  std::unique_ptr<World> all;
  SceneWorld& world;  // its reduced and rigid bodies
  NodalBodies guests;
  std::vector<PyModelPointer> models;              // of each body
  std::vector<std::weak_ptr<BodyHandle>> handles;  // that Python has
  std::vector<WorldEvent> events;                  // of the last call of step()
  std::vector<WorldChange> changes;
  bool stepped = false;               // the world took a step since the last one
  std::set<std::string> moved;        // bodies and colliders whose first move is among the changes
  std::exception_ptr filter_failure;  // of the last step; Python's exception
  std::atomic<bool> used = false;
};

struct PyWorld {
  std::shared_ptr<WorldParts> parts;
};

// The world for one call, with the states of the arrays of its bodies.
class WorldCall {
 public:
  explicit WorldCall(const PyWorld& self) : used_(self.parts->used, "world") {
    self.parts->push_states();
  }

 private:
  InUse used_;
};

// A world of the text of a scene file. Raises.
PyWorld make_world(std::string text, std::string path);

// A body by its name, its number in the order of names, or its object. Raises.
BodyNumber number_of(const PyWorld& self, py::handle body);
// The body's object, one at a time.
py::object object_of(const PyWorld& self, BodyNumber body);
py::bytes save_world(const PyWorld& self);
void restore_world(const PyWorld& self, const std::string& bytes);

// Notes a call that has changed the world. state: see WorldChange.
void note_change(const PyWorld& self, const char* call, py::tuple arguments,
                 std::string state = {});
// The changes for a pickle; makes those of a pickle again. stepped: WorldParts::stepped of the
// world that was pickled.
py::list pickled_changes(const PyWorld& self);
void make_changes(const PyWorld& self, py::handle changes, bool stepped);

using WorldClass = py::class_<PyWorld>;
// Functions that change the world.
void add_changes_of_world(WorldClass& c);

}  // namespace tremolo::python
