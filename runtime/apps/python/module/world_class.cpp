// The class tremolo.World: the bodies of a scene, stepped together.
#include <atomic>
#include <memory>
#include <set>
#include <utility>

#include "common/text.h"
#include "runtime/apps/python/module/body_handle.h"
#include "runtime/apps/python/module/nodal_handle.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/world/world.h"

namespace tremolo::python {
namespace {

constexpr int kPickleVersion = 1;
constexpr const char* kPickleName = "tremolo.World";

struct WorldParts {
  std::string text, path;  // of the scene file, for copies and pickles
  std::unique_ptr<World> all;
  SceneWorld& world;  // its reduced and rigid bodies
  NodalBodies guests;
  std::vector<PyModelPointer> models;             // of each body
  std::vector<std::weak_ptr<BodyHandle>> bodies;  // handles that Python has
  std::vector<WorldEvent> events;                 // of the last call of step()
  std::atomic<bool> used = false;

  WorldParts(std::string scene_text, std::string scene_path, std::unique_ptr<World> made)
      : text(std::move(scene_text)),
        path(std::move(scene_path)),
        all(std::move(made)),
        world(all->own()) {}

  // Bodies of the world come first, then guests, in the scene's order.
  std::size_t size() const { return world.size() + guests.size(); }
  std::string name(std::size_t i) const {
    return is_guest(i) ? guests.source(i - world.size()).name() : world.name(i);
  }
  bool is_guest(std::size_t i) const { return i >= world.size(); }
  NodalSource& guest(std::size_t i) { return guests.source(i - world.size()); }
  WorldBody body_at(std::size_t i) const {
    return is_guest(i) ? all->of_guest(i - world.size()) : all->of_own(i);
  }
  std::optional<std::size_t> find(const std::string& text_of_name) const {
    if (const auto found = world.find(text_of_name)) return found;
    if (const auto found = guests.find(text_of_name)) return world.size() + *found;
    return std::nullopt;
  }
  // The world's number of a body that is not a guest. Raises.
  std::size_t own_body(std::size_t i, const char* what) {
    if (is_guest(i))
      raise(usage_error("body '" + name(i) + "' is of kind \"" + guest(i).kind() + "\": " + what));
    return i;
  }

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
  const MixedFile mixed = unwrap(parse_mixed(text, path));
  Result<std::unique_ptr<World>> made = [&] {
    const py::gil_scoped_release unlocked;
    return World::create({path, mixed.file.scene, mixed.tets, mixed.cloths});
  }();
  if (!made) raise(error_of_file(path, made.error()));
  PyWorld world{std::make_shared<WorldParts>(std::move(text), std::move(path), std::move(*made))};
  WorldParts& parts = *world.parts;
  for (std::size_t i = 0; i < parts.world.size(); ++i) {
    auto model = std::make_shared<PyModel>();
    model->model = parts.world.body(i).model().shared_from_this();
    model->options = parts.world.scene().bodies[i].model_options;
    model->path = parts.world.scene().bodies[i].model;
    parts.models.push_back(std::move(model));
  }
  parts.bodies.resize(parts.world.size());
  if (MixedGuests* guests = guests_of(parts.world))
    parts.guests = NodalBodies(sources_of(*guests, [&parts](std::size_t i) -> const TetsKind& {
      return parts.all->tets_kind(parts.all->of_guest(i));
    }));
  return world;
}

std::size_t index_of(const PyWorld& self, py::handle name) {
  const WorldParts& parts = *self.parts;
  return number_of_body(
      name, parts.size(), [&](const std::string& text) { return parts.find(text); },
      [&](std::size_t i) { return parts.name(i); }, "world");
}

py::object body_of(const PyWorld& self, py::handle name) {
  const std::size_t i = index_of(self, name);
  WorldParts& parts = *self.parts;
  if (parts.is_guest(i))
    return py::cast(parts.guests.handle(i - parts.world.size(), self.parts, parts.used));
  if (BodyPointer known = parts.bodies[i].lock()) return py::cast(known);
  const Call call(self);
  auto made =
      std::make_shared<BodyHandle>(parts.models[i], self.parts, parts.world.body(i), parts.used);
  parts.bodies[i] = made;
  return py::cast(made);
}

void step(const PyWorld& self, std::int64_t count) {
  if (count < 0) raise(usage_error("n: " + std::to_string(count) + ", must not be negative"));
  const Call call(self);
  WorldParts& parts = *self.parts;
  parts.events.clear();
  for (std::size_t i = 0; i < parts.guests.size(); ++i)
    if (parts.guests.source(i).driven) parts.all->expect_energy(i);
  std::optional<Error> failed;
  try {
    run_unlocked(count, [&](std::int64_t) {
      const Status made = parts.all->step();
      parts.events.insert(parts.events.end(), parts.all->events().begin(),
                          parts.all->events().end());
      if (!made) failed = made.error();
      return !failed;
    });
  } catch (...) {
    parts.pull_states();
    throw;
  }
  parts.pull_states();
  if (failed) raise(*failed);
}

py::list events(const PyWorld& self) {
  const Call call(self);
  const World& world = *self.parts->all;
  py::list list;
  for (const WorldEvent& event : self.parts->events) {
    py::dict dict;
    dict["time"] = event.time;
    dict["kind"] = event.kind == ContactEvent::Kind::kBegin ? "begin" : "end";
    dict["body"] = world.name(event.body);
    dict["other"] =
        event.other ? world.name(*event.other) : world.own().scene().colliders[event.collider].name;
    dict["with_body"] = event.other.has_value();
    dict["impulse"] = event.place.impulse;
    dict["push"] = array_of<3>(event.place.push);
    dict["position"] = array_of<3>(event.place.position);
    dict["normal"] = array_of<3>(event.place.normal);
    list.append(dict);
  }
  return list;
}

py::list contact_points(const PyWorld& self, py::handle body, const std::string& other) {
  const WorldBody known = self.parts->body_at(index_of(self, body));
  const Call call(self);
  const World& world = *self.parts->all;
  const std::optional<std::size_t> collider = world.find_collider(other);
  std::optional<WorldBody> partner;
  if (!collider) partner = self.parts->body_at(index_of(self, py::str(other)));
  py::list list;
  for (const ContactedPoint& point : world.points(known, partner, collider.value_or(0))) {
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
  const WorldAccount account = self.parts->all->account(self.parts->body_at(i));
  const EnergyAccount& a = account.sums;
  py::dict dict;
  dict["kinetic"] = a.kinetic;
  dict["potential"] = a.potential;
  dict["contact"] = a.contact;
  dict["at_start"] = a.at_start;
  dict["load"] = a.load;
  dict["support"] = a.support;
  dict["gravity"] = a.gravity;
  dict["wind"] = account.wind;
  dict["contact_given"] = a.contact_given;
  dict["restitution"] = a.restitution;
  dict["friction"] = a.friction;
  dict["hand"] = a.hand;
  dict["joint"] = a.joint;
  dict["damping"] = a.damping;
  dict["method"] = account.method;
  dict["total"] = a.total();
  dict["given"] = a.given() + account.wind + account.method;
  dict["remainder"] = account.remainder;
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
    dict["to"] = wanted.to.empty() ? kWorldName : wanted.to;
    dict["kind"] = wanted.weld ? "weld" : "point";
    dict["points"] = world.joint_points(i);
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
  const World& world = *self.parts->all;
  const auto found = unwrap(world.pick(vector3(origin, "origin"), vector3(direction, "direction")));
  if (!found) return py::none();
  py::dict dict;
  dict["body"] = world.name(found->site.body);
  if (found->vertex >= 0) dict["vertex"] = found->vertex;
  dict["triangle"] = found->site.triangle;
  dict["weights"] = array_of<3>(found->site.weights);
  dict["distance"] = found->distance;
  dict["point"] = array_of<3>(found->point);
  return dict;
}

void move_collider(const PyWorld& self, const std::string& name, py::handle position,
                   py::handle rotation) {
  const Pose pose = pose_of(position, rotation);
  const Call call(self);
  const auto collider = self.parts->all->find_collider(name);
  if (!collider) raise(usage_error("there is no collider '" + name + "'"));
  check(self.parts->all->move_collider(*collider, pose));
}

void move_body(const PyWorld& self, py::handle body, py::handle position, py::handle rotation) {
  const Pose pose = pose_of(position, rotation);
  const std::size_t i = index_of(self, body);
  const Call call(self);
  check(self.parts->all->move(self.parts->body_at(i), pose));
}

py::bytes save(const PyWorld& self) {
  const Call call(self);
  const std::vector<std::byte> bytes = self.parts->world.save();
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void restore(const PyWorld& self, const std::string& bytes) {
  const Call call(self);
  check(self.parts->all->restore(std::as_bytes(std::span(bytes.data(), bytes.size()))));
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
  for (std::size_t i = 0; i < self.parts->size(); ++i) list.append(self.parts->name(i));
  return list;
}

std::string describe(const PyWorld& self) {
  return "<tremolo.World: " + std::to_string(self.parts->size()) + " bodies, " +
         std::to_string(self.parts->world.scene().colliders.size()) + " colliders>";
}

py::tuple momenta_tuple(const Momenta& m) {
  return py::make_tuple(array_of<3>(m.linear), array_of<3>(m.angular));
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
template <class Get, class OfGuest>
void of_body(WorldClass& c, const char* name, const char* doc, const Get& get,
             const OfGuest& of_guest) {
  c.def(
      name,
      [get, of_guest](const PyWorld& self, py::handle body) {
        const std::size_t i = index_of(self, body);
        const Call call(self);
        WorldParts& parts = *self.parts;
        return parts.is_guest(i) ? of_guest(parts.guest(i)) : get(parts.world, i);
      },
      py::arg("body"), doc);
}

void add_queries(WorldClass& c) {
  property(c, "time", "s.", [](const SceneWorld& w) { return w.time(); });
  property(c, "steps", "Number of steps taken.", [](const SceneWorld& w) { return w.steps(); });
  property(c, "step_size", "h, s.", [](const SceneWorld& w) { return w.step_size(); });
  property(c, "duration", "Of the scene, s.",
           [](const SceneWorld& w) { return w.scene().duration; });
  of_body(
      c, "failed", "True if a step of the body failed: it is not stepped again.",
      [](const SceneWorld& w, std::size_t i) { return w.failed(i); },
      [](NodalSource& s) { return s.failed(); });
  of_body(
      c, "asleep", "True if the body is at rest and not stepped until something wakes it.",
      [](const SceneWorld& w, std::size_t i) { return w.asleep(i); },
      [](NodalSource& s) { return s.asleep(); });
  of_body(
      c, "contacts", "Number of contacts of the body that began.",
      [](const SceneWorld& w, std::size_t i) { return w.contacts(i); },
      [](NodalSource& s) { return s.contacts(); });
  of_body(
      c, "penetration",
      "The largest depth of its contact points so far, as a fraction of its size.",
      [](const SceneWorld& w, std::size_t i) { return w.penetration_max(i); },
      [](NodalSource& s) { return s.penetration_max() / s.size(); });
  of_body(
      c, "momenta", "(linear (3,), kg m/s; angular (3,) about the origin, N m s).",
      [](const SceneWorld& w, std::size_t i) { return momenta_tuple(w.momenta(i)); },
      [](NodalSource& s) { return momenta_tuple(s.momenta()); });
  c.def(
      "account", &account, py::arg("body"),
      "The energy balance of a body, J, a dict: kinetic, potential, contact, total; at_start; "
      "given since then by load, support, gravity, wind, contact_given, restitution, friction, "
      "hand, joint, damping, method, which are 0 where a body of its kind has no such cause; "
      "remainder, which has no known cause. method: of tetrahedra and cloth, given by the method, "
      "and by the damping of tetrahedra.");
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
  c.def_property_readonly(
      "joints", &joints,
      "A list of dicts: body, to, kind, points, holds, force (3,), N, energy, J.");
  c.def_property_readonly("hands", &hands,
                          "A list of dicts: body, vertex, holds, force on the body (3,), N.");
  c.def(
      "pick", &pick, py::arg("origin"), py::arg("direction"),
      "The first hit of a ray (m, world) on a drawn surface: a dict of body, triangle, weights of "
      "its corners (3,), distance, point, and vertex for bodies with a basis; or None.");
  c.def("move_collider", &move_collider, py::arg("name"), py::arg("position"),
        py::arg("rotation") = py::make_tuple(1.0, 0.0, 0.0, 0.0),
        "The collider goes to that pose (m; w, x, y, z) in the next step, carries what lies on it, "
        "and rests there until the next call. A pickle or copy needs the same call before.");
  c.def("move", &move_body, py::arg("body"), py::arg("position"),
        py::arg("rotation") = py::make_tuple(1.0, 0.0, 0.0, 0.0),
        "The same for the frame of a driven body.");
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
  c.def_property_readonly("names", &names,
                          "Names of the bodies, a list of str, tetrahedra and cloths last.");
  c.def(
      "body", &body_of, py::arg("name"),
      "A body by its name or number, in the order of `names`: a tremolo.Body, or of tetrahedra or "
      "cloth a tremolo.NodalBody, that the world steps. It keeps the world alive.");
  c.def("__getitem__", &body_of, py::arg("name"));
  c.def("__len__", [](const PyWorld& self) { return self.parts->size(); });
  c.def(
      "step", &step, py::arg("n") = 1,
      "Takes n steps without the interpreter's lock. If a step of a body fails, SolverError or "
      "BoundError names it; the world continues without it at the next call. Ctrl-C ends the call "
      "between two steps.");
  add_queries(c);
  c.def(
      "set_method",
      [](const PyWorld& self, py::handle body, const std::string& integrator) {
        const std::size_t i =
            self.parts->own_body(index_of(self, body), "its method is the scene's");
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
  module.def("_world_of", from_pickle(&unpickled), py::arg("state"),
             "A world of its pickle's state.");
  c.def("__copy__", [](const PyWorld& self) { return unpickled(pickled(self)); });
  c.def("__deepcopy__",
        [](const PyWorld& self, const py::object&) { return unpickled(pickled(self)); });
  c.def("__repr__", &describe);
}

}  // namespace tremolo::python
