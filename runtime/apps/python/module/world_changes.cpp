// tremolo.World: what comes and goes between two steps, and a filter of contacts.
#include <memory>
#include <utility>

#include "runtime/apps/python/module/world_parts.h"
#include "runtime/io/scenes/added_tables.h"

namespace tremolo::python {
namespace {

// A dict as TOML, and the path that the paths in it are relative to.
struct Table {
  std::string text, path;
};

Table table_of(const PyWorld& self, py::handle dict, py::handle folder) {
  if (!py::hasattr(dict, "items"))
    raise_type("expected a dict, found " + text_of(py::type::of(dict).attr("__name__")));
  const py::module_ scenes = py::module_::import("tremolo.scenes");
  Table table{scenes.attr("scene_text")(dict).cast<std::string>(), self.parts->path};
  if (!folder.is_none()) table.path = scenes.attr("path_in")(folder).cast<std::string>();
  return table;
}

py::tuple tuple_of_table(const Table& table) {
  return py::make_tuple(table.text, table.path);
}

Table table_of_tuple(const py::tuple& arguments) {
  return {arguments[0].cast<std::string>(), arguments[1].cast<std::string>()};
}

BodyNumber add(const PyWorld& self, const Table& table) {
  const WorldCall call(self);
  WorldParts& parts = *self.parts;
  parts.around.options.step = parts.world.step_size();
  const MixedFile made = unwrap(parse_added_body(table.text, table.path, parts.around));
  Result<WorldBody> added = [&] {
    const py::gil_scoped_release unlocked;
    if (!made.tets.empty()) return parts.all->add(made.tets.front());
    if (!made.cloths.empty()) return parts.all->add(made.cloths.front());
    return parts.all->add(made.file.scene.bodies.front());
  }();
  if (!added) raise(error_of_file(table.path, added.error()));
  const BodyNumber body = *parts.find(parts.all->name(*added));
  parts.begin(body);
  note_change(self, "add", tuple_of_table(table));
  return body;
}

void remove(const PyWorld& self, BodyNumber body) {
  const WorldCall call(self);
  WorldParts& parts = *self.parts;
  const WorldBody id = parts.id(body);
  const std::string name = parts.name(body);
  parts.end(body);
  check(parts.all->remove(id));
  std::erase_if(parts.events,
                [id](const WorldEvent& event) { return event.body == id || event.other == id; });
  parts.moved.erase("body " + name);
  note_change(self, "remove", py::make_tuple(name));
}

void add_collider(const PyWorld& self, const Table& table) {
  const WorldCall call(self);
  const SceneCollider wanted = unwrap(parse_added_collider(table.text, table.path));
  const Result<std::size_t> added = self.parts->all->add_collider(wanted);
  if (!added) raise(error_of_file(table.path, added.error()));
  note_change(self, "add_collider", tuple_of_table(table));
}

std::size_t collider_of(const PyWorld& self, const std::string& name) {
  const auto collider = self.parts->all->find_collider(name);
  if (!collider) raise(usage_error("there is no collider '" + name + "'"));
  return *collider;
}

void remove_collider(const PyWorld& self, const std::string& name) {
  const WorldCall call(self);
  WorldParts& parts = *self.parts;
  const std::size_t collider = collider_of(self, name);
  check(parts.all->remove_collider(collider));
  std::erase_if(parts.events, [collider](const WorldEvent& event) {
    return !event.other && event.collider == collider;
  });
  parts.moved.erase("collider " + name);
  note_change(self, "remove_collider", py::make_tuple(name));
}

// The points that are joined depend on the state.
std::size_t add_joint(const PyWorld& self, const Table& table) {
  std::string state = save_world(self);
  const WorldCall call(self);
  SceneJoint wanted = unwrap(parse_added_joint(table.text, table.path));
  if (wanted.to == kWorldName && !self.parts->world.has_name(kWorldName)) wanted.to.clear();
  const Result<std::size_t> added = self.parts->all->add_joint(wanted);
  if (!added) raise(error_of_file(table.path, added.error()));
  note_change(self, "add_joint", tuple_of_table(table), std::move(state));
  return *added;
}

void remove_joint(const PyWorld& self, std::int64_t number) {
  const WorldCall call(self);
  if (number < 0) raise(usage_error("there is no joint " + std::to_string(number)));
  check(self.parts->all->remove_joint(static_cast<std::size_t>(number)));
  note_change(self, "remove_joint", py::make_tuple(number));
}

void add_load(const PyWorld& self, BodyNumber body, const Table& table) {
  const WorldCall call(self);
  const SceneLoad load = unwrap(parse_added_load(table.text, table.path));
  const Status added = self.parts->all->add_load(self.parts->id(body), load);
  if (!added) raise(error_of_file(table.path, added.error()));
  note_change(self, "add_load", py::make_tuple(self.parts->name(body), table.text, table.path));
}

// The poses of later calls are in the saved state.
void note_move(const PyWorld& self, const char* call, const std::string& name, const Pose& pose) {
  if (!self.parts->moved.insert(std::string(call) + " " + name).second) return;
  const py::tuple parts = tuple_of(pose);
  note_change(self, call, py::make_tuple(name, parts[0], parts[1]));
}

void move_collider(const PyWorld& self, const std::string& name, const Pose& pose) {
  const WorldCall call(self);
  check(self.parts->all->move_collider(collider_of(self, name), pose));
  note_move(self, "collider", name, pose);
}

void move_body(const PyWorld& self, BodyNumber body, const Pose& pose) {
  const WorldCall call(self);
  check(self.parts->all->move(self.parts->id(body), pose));
  note_move(self, "body", self.parts->name(body), pose);
}

void set_method(const PyWorld& self, BodyNumber body, const std::string& integrator) {
  const std::size_t i = self.parts->own_body(body, "its method is the scene's");
  const WorldCall call(self);
  check(self.parts->world.set_method(i, integrator));
  note_change(self, "set_method", py::make_tuple(self.parts->name(body), integrator));
}

void set_step(const PyWorld& self, double h) {
  const WorldCall call(self);
  check(self.parts->world.set_step(h));
  note_change(self, "set_step", py::make_tuple(h));
}

// A function of Python that lives as long as the engine has copies of it.
struct Filter {
  py::function ask;

  explicit Filter(py::function given) : ask(std::move(given)) {}
  ~Filter() {
    const py::gil_scoped_acquire locked;
    ask = py::function();
  }
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;
};

void set_filter(const PyWorld& self, const py::object& given) {
  const WorldCall call(self);
  WorldParts& parts = *self.parts;
  if (given.is_none()) {
    parts.all->set_filter({});
    return;
  }
  if (PyCallable_Check(given.ptr()) == 0) raise_type("filter: expected a function or None");
  const auto filter = std::make_shared<Filter>(py::reinterpret_borrow<py::function>(given));
  parts.all->set_filter([filter, known = &parts](WorldBody a, WorldBody b) {
    if (known->filter_failure) return true;
    const py::gil_scoped_acquire locked;
    try {
      const py::object answer = filter->ask(known->all->name(a), known->all->name(b));
      const int yes = PyObject_IsTrue(answer.ptr());
      if (yes < 0) throw py::error_already_set();
      return yes != 0;
    } catch (...) {
      known->filter_failure = std::current_exception();
      return true;
    }
  });
}

// Makes one change of a pickle again.
void make_change(const PyWorld& self, const std::string& call, const py::tuple& of) {
  const auto name = [&of] { return of[0].cast<std::string>(); };
  const auto body = [&self, &of] { return number_of(self, of[0]); };
  if (call == "add")
    (void)add(self, table_of_tuple(of));
  else if (call == "remove")
    remove(self, body());
  else if (call == "add_collider")
    add_collider(self, table_of_tuple(of));
  else if (call == "remove_collider")
    remove_collider(self, name());
  else if (call == "add_joint")
    (void)add_joint(self, table_of_tuple(of));
  else if (call == "remove_joint")
    remove_joint(self, of[0].cast<std::int64_t>());
  else if (call == "add_load")
    add_load(self, body(), {of[1].cast<std::string>(), of[2].cast<std::string>()});
  else if (call == "collider")
    move_collider(self, name(), pose_of(of[1], of[2]));
  else if (call == "body")
    move_body(self, body(), pose_of(of[1], of[2]));
  else if (call == "set_method")
    set_method(self, body(), of[1].cast<std::string>());
  else if (call == "set_step")
    set_step(self, of[0].cast<double>());
  else
    raise_damaged_pickle();
}

}  // namespace

void note_change(const PyWorld& self, const char* call, py::tuple arguments, std::string state) {
  WorldParts& parts = *self.parts;
  parts.changes.push_back({call, std::move(arguments), parts.stepped, std::move(state)});
  parts.stepped = false;
}

py::list pickled_changes(const PyWorld& self) {
  py::list list;
  for (const WorldChange& change : self.parts->changes)
    list.append(
        py::make_tuple(change.call, change.arguments, change.after_step, py::bytes(change.state)));
  return list;
}

void make_changes(const PyWorld& self, py::handle changes, bool stepped) {
  WorldParts& parts = *self.parts;
  parts.all->begin_replay();
  for (const py::handle each : changes) {
    const auto change = each.cast<py::tuple>();
    const auto after_step = change[2].cast<bool>();
    auto state = change[3].cast<std::string>();
    if (after_step) parts.all->replay_step();
    if (!state.empty()) restore_world(self, state);
    make_change(self, change[0].cast<std::string>(), change[1].cast<py::tuple>());
    parts.changes.back().after_step = after_step;
    parts.changes.back().state = std::move(state);
  }
  if (stepped) parts.all->replay_step();
  parts.all->end_replay();
  parts.stepped = stepped;
}

void add_changes_of_world(WorldClass& c) {
  const auto no_turn = py::make_tuple(1.0, 0.0, 0.0, 0.0);
  c.def(
      "add",
      [](const PyWorld& self, py::handle body, py::handle folder) {
        return object_of(self, add(self, table_of(self, body, folder)));
      },
      py::arg("body"), py::kw_only(), py::arg("folder") = py::none(),
      "Adds a body of any kind between two steps and returns it. body: a dict, as one of `bodies` "
      "of tremolo.world(), without `copies`; paths in it are relative to the scene, or to folder. "
      "Its loads begin now. It has the bits of one of the scene. A cloth passes through other "
      "cloths. Errors, which leave the world unchanged, as for tremolo.world(); UsageError after "
      "the first step: a body with a motion, which move() replaces.");
  c.def(
      "remove", [](const PyWorld& self, py::handle body) { remove(self, number_of(self, body)); },
      py::arg("body"),
      "Removes a body with its hands, grabs and joints. What it touched wakes; its contacts end "
      "without an event. Its name is free; its object raises UsageError from now on, and bodies "
      "that were added later have other numbers.");
  c.def(
      "add_collider",
      [](const PyWorld& self, py::handle collider, py::handle folder) {
        add_collider(self, table_of(self, collider, folder));
      },
      py::arg("collider"), py::kw_only(), py::arg("folder") = py::none(),
      "Adds a collider between two steps: a dict as one of `colliders` of tremolo.world(). "
      "ContentError: a body is inside it by more than its margin.");
  c.def("remove_collider", &remove_collider, py::arg("name"),
        "Removes a collider. All bodies wake; contacts with it end without an event. Its name is "
        "free.");
  c.def(
      "add_joint",
      [](const PyWorld& self, py::handle joint) {
        return add_joint(self, table_of(self, joint, py::none()));
      },
      py::arg("joint"),
      "Joins bodies of any kind where they are now: a dict as one of `joints` of tremolo.world(). "
      "Returns its number in `joints`.");
  c.def("remove_joint", &remove_joint, py::arg("number"),
        "Ends a joint by its number in `joints`, where it remains as one that does not hold.");
  c.def(
      "add_load",
      [](const PyWorld& self, py::handle body, py::handle load, py::handle folder) {
        add_load(self, number_of(self, body), table_of(self, load, folder));
      },
      py::arg("body"), py::arg("load"), py::kw_only(), py::arg("folder") = py::none(),
      "Adds a force in time to a body of any kind: a dict as one of `loads` of a body in "
      "tremolo.world(): at, force, and load or signal, frequency, sweep, load_duration, scale. Its "
      "times are on the body's clock, which began when the body was added and stands still while "
      "it sleeps.");
  c.def(
      "move_collider",
      [](const PyWorld& self, const std::string& name, py::handle position, py::handle rotation) {
        move_collider(self, name, pose_of(position, rotation));
      },
      py::arg("name"), py::arg("position"), py::arg("rotation") = no_turn,
      "The collider goes to that pose (m; w, x, y, z) in the next step, carries what lies on it, "
      "and rests there until the next call.");
  c.def(
      "move",
      [](const PyWorld& self, py::handle body, py::handle position, py::handle rotation) {
        move_body(self, number_of(self, body), pose_of(position, rotation));
      },
      py::arg("body"), py::arg("position"), py::arg("rotation") = no_turn,
      "The same for the frame of a driven body.");
  c.def(
      "set_method",
      [](const PyWorld& self, py::handle body, const std::string& integrator) {
        set_method(self, number_of(self, body), integrator);
      },
      py::arg("body"), py::arg("integrator"), "Another method of one body.");
  c.def("set_step", &set_step, py::arg("step"), "Another step of all bodies, s.");
  c.def("set_filter", &set_filter, py::arg("filter"),
        "filter(a, b), with the names of two bodies that come near each other in a step, returns "
        "False if they pass through each other; None: no two do. It must not call the world. An "
        "exception in it ends step(), which raises it. Copies and pickles do not have it.");
}

}  // namespace tremolo::python
