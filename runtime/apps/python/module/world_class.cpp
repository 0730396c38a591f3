// The class tremolo.World: the bodies of a scene, stepped together.
#include <atomic>
#include <memory>
#include <set>
#include <utility>

#include "runtime/apps/python/module/body_handle.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/world/scene_world.h"

namespace tremolo::python {
namespace {

constexpr int kPickleVersion = 1;
constexpr const char* kPickleName = "tremolo.World";

// An event and the time at the end of its step, s.
struct TimedEvent {
  ContactEvent event;
  double time = 0.0;
};

struct WorldParts {
  std::string text, path;  // of the scene file, for copies and pickles
  SceneWorld world;
  std::vector<PyModelPointer> models;             // of each body
  std::vector<std::weak_ptr<BodyHandle>> bodies;  // handles that Python has
  std::vector<TimedEvent> events;                 // of the last call of step()
  std::atomic<bool> used = false;

  WorldParts(std::string scene_text, std::string scene_path, SceneWorld made)
      : text(std::move(scene_text)), path(std::move(scene_path)), world(std::move(made)) {}

  void push_states() {
    for (const std::weak_ptr<BodyHandle>& body : bodies)
      if (const BodyPointer known = body.lock()) known->push_state();
  }
  void pull_states() {
    for (const std::weak_ptr<BodyHandle>& body : bodies)
      if (const BodyPointer known = body.lock()) known->pull_state();
  }
};

struct PyWorld {
  std::shared_ptr<WorldParts> parts;
};

// The world for one call, with the states of the arrays of its bodies.
class Call {
 public:
  explicit Call(const PyWorld& self) : used_(self.parts->used, "world") {
    self.parts->push_states();
  }

 private:
  InUse used_;
};

PyWorld make_world(std::string text, std::string path) {
  struct Made {
    Result<SceneWorld> world;
    std::vector<PyModelPointer> models;
  };
  const SceneFile file = unwrap(parse_world(text, path));
  Made made = [&]() -> Made {
    const py::gil_scoped_release unlocked;
    return {SceneWorld::create(file.scene), {}};
  }();
  if (!made.world) raise(error_of_file(path, made.world.error()));
  PyWorld world{
      std::make_shared<WorldParts>(std::move(text), std::move(path), std::move(*made.world))};
  WorldParts& parts = *world.parts;
  for (std::size_t i = 0; i < parts.world.size(); ++i) {
    auto model = std::make_shared<PyModel>();
    model->model = parts.world.body(i).model().shared_from_this();
    model->options = parts.world.scene().bodies[i].model_options;
    model->path = parts.world.scene().bodies[i].model;
    parts.models.push_back(std::move(model));
  }
  parts.bodies.resize(parts.world.size());
  return world;
}

std::size_t index_of(const PyWorld& self, py::handle name) {
  const SceneWorld& world = self.parts->world;
  if (PyLong_Check(name.ptr())) {
    const auto i = name.cast<std::int64_t>();
    if (i < 0 || std::cmp_greater_equal(i, world.size()))
      raise(usage_error("there is no body " + std::to_string(i) + ": the world has " +
                        std::to_string(world.size())));
    return static_cast<std::size_t>(i);
  }
  if (!PyUnicode_Check(name.ptr())) raise_type("expected the name or the number of a body");
  const auto text = name.cast<std::string>();
  const std::optional<std::size_t> found = world.find(text);
  if (found) return *found;
  std::string known;
  for (std::size_t i = 0; i < world.size() && i < 20; ++i) known += " " + world.name(i);
  raise(usage_error("there is no body '" + text + "'; known:" + known));
}

BodyPointer body_of(const PyWorld& self, py::handle name) {
  const std::size_t i = index_of(self, name);
  WorldParts& parts = *self.parts;
  if (BodyPointer known = parts.bodies[i].lock()) return known;
  const Call call(self);
  auto made =
      std::make_shared<BodyHandle>(parts.models[i], self.parts, parts.world.body(i), parts.used);
  parts.bodies[i] = made;
  return made;
}

void step(const PyWorld& self, std::int64_t count) {
  if (count < 0) raise(usage_error("n: " + std::to_string(count) + ", must not be negative"));
  const Call call(self);
  WorldParts& parts = *self.parts;
  SceneWorld& world = parts.world;
  parts.events.clear();
  std::string failed;
  ErrorKind kind = ErrorKind::kSolver;
  try {
    run_unlocked(count, [&](std::int64_t) {
      for (const SceneWorld::Failure& failure : world.step()) {
        kind = error_kind(failure.report.failure);
        if (!failed.empty()) failed += "; ";
        failed += world.name(failure.body) + ": " + why_not_made(failure.report, world.time());
      }
      for (const ContactEvent& event : world.events())
        parts.events.push_back({event, world.time()});
      return failed.empty();
    });
  } catch (...) {
    parts.pull_states();
    throw;
  }
  parts.pull_states();
  if (!failed.empty()) raise({kind, failed});
}

std::string name_of_other(const SceneWorld& world, const ContactEvent& event) {
  return event.other != ContactEvent::kNone ? world.name(event.other)
                                            : world.scene().colliders[event.collider].name;
}

py::list events(const PyWorld& self) {
  const Call call(self);
  const SceneWorld& world = self.parts->world;
  py::list list;
  for (const auto& [event, time] : self.parts->events) {
    py::dict dict;
    dict["time"] = time;
    dict["kind"] = event.kind == ContactEvent::Kind::kBegin ? "begin" : "end";
    dict["body"] = world.name(event.body);
    dict["other"] = name_of_other(world, event);
    dict["with_body"] = event.other != ContactEvent::kNone;
    dict["impulse"] = event.place.impulse;
    dict["push"] = array_of<3>(event.place.push);
    dict["position"] = array_of<3>(event.place.position);
    dict["normal"] = array_of<3>(event.place.normal);
    list.append(dict);
  }
  return list;
}

std::optional<std::size_t> find_collider(const SceneWorld& world, const std::string& name) {
  for (std::size_t i = 0; i < world.scene().colliders.size(); ++i)
    if (world.scene().colliders[i].name == name) return i;
  return std::nullopt;
}

py::list contact_points(const PyWorld& self, py::handle body, const std::string& other) {
  const std::size_t i = index_of(self, body);
  const Call call(self);
  const SceneWorld& world = self.parts->world;
  ContactEvent pair;
  pair.body = i;
  if (const auto collider = find_collider(world, other))
    pair.collider = *collider;
  else
    pair.other = index_of(self, py::str(other));
  py::list list;
  for (const ContactedPoint& point : world.points_of(pair)) {
    py::dict dict;
    dict["vertex"] = point.vertex;
    dict["on_body"] = point.on_body;
    dict["position"] = array_of<3>(point.position);
    dict["normal"] = array_of<3>(point.normal);
    dict["impulse"] = array_of<3>(point.impulse);
    list.append(dict);
  }
  return list;
}

py::dict account(const PyWorld& self, py::handle body) {
  const std::size_t i = index_of(self, body);
  const Call call(self);
  const EnergyAccount a = self.parts->world.account(i);
  py::dict dict;
  dict["kinetic"] = a.kinetic;
  dict["potential"] = a.potential;
  dict["contact"] = a.contact;
  dict["at_start"] = a.at_start;
  dict["load"] = a.load;
  dict["support"] = a.support;
  dict["gravity"] = a.gravity;
  dict["contact_given"] = a.contact_given;
  dict["restitution"] = a.restitution;
  dict["friction"] = a.friction;
  dict["hand"] = a.hand;
  dict["joint"] = a.joint;
  dict["damping"] = a.damping;
  dict["total"] = a.total();
  dict["given"] = a.given();
  dict["remainder"] = a.remainder();
  return dict;
}

py::list colliders(const PyWorld& self) {
  const Call call(self);
  const SceneWorld& world = self.parts->world;
  py::list list;
  for (std::size_t i = 0; i < world.scene().colliders.size(); ++i) {
    const PlacedCollider& placed = world.colliders()[i];
    py::dict dict;
    dict["name"] = world.scene().colliders[i].name;
    dict["shape"] = shape_name(placed.shape);
    dict["position"] = array_of<3>(placed.end.position);
    dict["rotation"] = tuple_of(placed.end)[1];
    list.append(dict);
  }
  return list;
}

py::list joints(const PyWorld& self) {
  const Call call(self);
  const SceneWorld& world = self.parts->world;
  py::list list;
  for (std::size_t i = 0; i < world.scene().joints.size(); ++i) {
    const SceneJoint& wanted = world.scene().joints[i];
    const Joint* joint = world.joint(i);
    py::dict dict;
    dict["body"] = wanted.body;
    dict["to"] = wanted.to;
    dict["holds"] = joint != nullptr;
    dict["force"] = joint ? array_of<3>(joint->force) : array_of<3>(Eigen::Vector3d::Zero());
    dict["energy"] = joint ? joint->energy : 0.0;
    list.append(dict);
  }
  return list;
}

py::list hands(const PyWorld& self) {
  const Call call(self);
  const SceneWorld& world = self.parts->world;
  py::list list;
  for (std::size_t i = 0; i < world.scene().hands.size(); ++i) {
    py::dict dict;
    dict["body"] = world.scene().hands[i].body;
    dict["vertex"] = world.hand(i).vertex();
    dict["holds"] = world.hand(i).holds();
    dict["force"] = array_of<3>(world.hand_force(i));
    list.append(dict);
  }
  return list;
}

py::object pick(const PyWorld& self, py::handle origin, py::handle direction) {
  const Call call(self);
  const auto found =
      unwrap(self.parts->world.pick(vector3(origin, "origin"), vector3(direction, "direction")));
  if (!found) return py::none();
  py::dict dict;
  dict["body"] = self.parts->world.name(found->body);
  dict["vertex"] = found->hit.vertex;
  dict["distance"] = found->hit.distance;
  dict["point"] = array_of<3>(found->hit.point);
  return dict;
}

py::bytes save(const PyWorld& self) {
  const Call call(self);
  const std::vector<std::byte> bytes = self.parts->world.save();
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void restore(const PyWorld& self, const std::string& bytes) {
  const Call call(self);
  check(self.parts->world.restore(std::as_bytes(std::span(bytes.data(), bytes.size()))));
  self.parts->events.clear();
  self.parts->pull_states();
}

py::tuple pickled(const PyWorld& self) {
  return py::make_tuple(kPickleName, kPickleVersion, self.parts->text, self.parts->path,
                        save(self));
}

PyWorld unpickled(const py::tuple& state) {
  check_pickle(state, 5, kPickleName, kPickleVersion);
  PyWorld made = make_world(state[2].cast<std::string>(), state[3].cast<std::string>());
  restore(made, state[4].cast<std::string>());
  return made;
}

py::list names(const PyWorld& self) {
  py::list list;
  for (std::size_t i = 0; i < self.parts->world.size(); ++i) list.append(self.parts->world.name(i));
  return list;
}

std::string describe(const PyWorld& self) {
  return "<tremolo.World: " + std::to_string(self.parts->world.size()) + " bodies, " +
         std::to_string(self.parts->world.scene().colliders.size()) + " colliders>";
}

using WorldClass = py::class_<PyWorld>;

// A property, and a function of one body, each one call on the world.
template <class Get>
void property(WorldClass& c, const char* name, const char* doc, const Get& get) {
  c.def_property_readonly(
      name,
      [get](const PyWorld& self) {
        const Call call(self);
        return get(self.parts->world);
      },
      doc);
}
template <class Get>
void of_body(WorldClass& c, const char* name, const char* doc, const Get& get) {
  c.def(
      name,
      [get](const PyWorld& self, py::handle body) {
        const std::size_t i = index_of(self, body);
        const Call call(self);
        return get(self.parts->world, i);
      },
      py::arg("body"), doc);
}

void add_queries(WorldClass& c) {
  property(c, "time", "s.", [](const SceneWorld& w) { return w.time(); });
  property(c, "steps", "Number of steps taken.", [](const SceneWorld& w) { return w.steps(); });
  property(c, "step_size", "h, s.", [](const SceneWorld& w) { return w.step_size(); });
  property(c, "duration", "Of the scene, s.",
           [](const SceneWorld& w) { return w.scene().duration; });
  of_body(c, "failed", "True if a step of the body failed: it is not stepped again.",
          [](const SceneWorld& w, std::size_t i) { return w.failed(i); });
  of_body(c, "asleep", "True if the body is at rest and not stepped until something wakes it.",
          [](const SceneWorld& w, std::size_t i) { return w.asleep(i); });
  of_body(c, "contacts", "Number of contacts of the body that began.",
          [](const SceneWorld& w, std::size_t i) { return w.contacts(i); });
  of_body(c, "penetration",
          "The largest depth of its contact points so far, as a fraction of its size.",
          [](const SceneWorld& w, std::size_t i) { return w.penetration_max(i); });
  of_body(c, "momenta", "(linear (3,), kg m/s; angular (3,) about the origin, N m s).",
          [](const SceneWorld& w, std::size_t i) {
            const Momenta m = w.momenta(i);
            return py::make_tuple(array_of<3>(m.linear), array_of<3>(m.angular));
          });
  c.def("account", &account, py::arg("body"),
        "The energy balance of a body, J, a dict: kinetic, potential, contact, total; at_start; "
        "given since then by load, support, gravity, contact_given, restitution, friction, hand, "
        "joint, damping; remainder, which has no known cause.");
  c.def_property_readonly(
      "events", &events,
      "Contacts that began or ended in the last call of step(), a list of dicts: time (s), kind "
      "(\"begin\", \"end\"), body, other, with_body, impulse (N s), push (3,), position (3,), m, "
      "and normal (3,).");
  c.def("contact_points", &contact_points, py::arg("body"), py::arg("other"),
        "The points of a body in contact with a collider or another body in the last step, a list "
        "of dicts: vertex, position (m), normal, impulse (N s), on_body.");
  c.def_property_readonly("colliders", &colliders,
                          "A list of dicts: name, shape, position (3,), rotation (4,).");
  c.def_property_readonly("joints", &joints,
                          "A list of dicts: body, to, holds, force (3,), N, energy, J.");
  c.def_property_readonly("hands", &hands,
                          "A list of dicts: body, vertex, holds, force on the body (3,), N.");
  c.def("pick", &pick, py::arg("origin"), py::arg("direction"),
        "The first hit of a ray (m, world): a dict of body, vertex, distance, point; or None.");
}

}  // namespace

void add_world(py::module_& module) {
  WorldClass c(module, "World",
               "The bodies of a scene, stepped together: contact with colliders and with each "
               "other, hands, joints, gravity, sleep. tremolo.world() makes it of a dict or a "
               "file. copy.copy and pickle keep the whole state.");
  module.def(
      "world_of_text",
      [](std::string text, py::handle path) {
        return make_world(std::move(text), path_text(path));
      },
      py::arg("text"), py::arg("path"),
      "A world of the text of a scene file (TOML). path: where it would be, for the paths inside.");
  c.def_property_readonly("names", &names, "Names of the bodies, a list of str.");
  c.def("body", &body_of, py::arg("name"),
        "A body by its name or number: a tremolo.Body that the world steps. It keeps the world "
        "alive.");
  c.def("__getitem__", &body_of, py::arg("name"));
  c.def("__len__", [](const PyWorld& self) { return self.parts->world.size(); });
  c.def("step", &step, py::arg("n") = 1,
        "Takes n steps without the interpreter's lock. If a step of a body fails, SolverError or "
        "BoundError names it; the world goes on without it at the next call. Ctrl-C ends the call "
        "between two steps.");
  add_queries(c);
  c.def(
      "set_method",
      [](const PyWorld& self, py::handle body, const std::string& integrator) {
        const std::size_t i = index_of(self, body);
        const Call call(self);
        check(self.parts->world.set_method(i, integrator));
      },
      py::arg("body"), py::arg("integrator"), "Another method of one body.");
  c.def(
      "set_step",
      [](const PyWorld& self, double h) {
        const Call call(self);
        check(self.parts->world.set_step(h));
      },
      py::arg("step"), "Another step of all bodies, s.");
  c.def(
      "set_threads",
      [](const PyWorld& self, unsigned threads) {
        const Call call(self);
        check(self.parts->world.set_threads(threads));
      },
      py::arg("threads"), "Threads of a step; 0: one per core. Results do not depend on it.");
  c.def("save", &save, "The state between steps, bytes, as `tremolo run --save` writes it.");
  c.def("restore", &restore, py::arg("bytes"), "Continues from save() of a world of this scene.");
  c.def("__reduce__", [](const PyWorld& self) { return reduced("world_of", pickled(self)); });
  refuse_construction(c, "tremolo.world() makes one");
  module.def("_world_of", &unpickled, py::arg("state"), "A world of its pickle's state.");
  c.def("__copy__", [](const PyWorld& self) { return unpickled(pickled(self)); });
  c.def("__deepcopy__",
        [](const PyWorld& self, const py::object&) { return unpickled(pickled(self)); });
  c.def("__repr__", &describe);
}

}  // namespace tremolo::python
