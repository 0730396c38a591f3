// The class tremolo.World: the bodies of a scene, stepped together.
#include <memory>
#include <utility>

#include "common/text.h"
#include "runtime/apps/python/module/world_parts.h"

namespace tremolo::python {
namespace {

constexpr int kPickleVersion = 2;
constexpr const char* kPickleName = "tremolo.World";

void step(const PyWorld& self, std::int64_t count) {
  if (count < 0) raise(usage_error("n: " + std::to_string(count) + ", must not be negative"));
  const WorldCall call(self);
  WorldParts& parts = *self.parts;
  parts.events.clear();
  parts.stepped = parts.stepped || count > 0;
  for (std::size_t i = 0; i < parts.guests.size(); ++i)
    if (parts.guests.has(i) && parts.guests.source(i).driven) parts.all->expect_energy(i);
  std::optional<Error> failed;
  try {
    run_unlocked(count, [&](std::int64_t) {
      const Status made = parts.all->step();
      parts.events.insert(parts.events.end(), parts.all->events().begin(),
                          parts.all->events().end());
      if (!made) failed = made.error();
      return !failed && !parts.filter_failure;
    });
  } catch (...) {
    parts.pull_states();
    throw;
  }
  parts.pull_states();
  if (parts.filter_failure)
    std::rethrow_exception(std::exchange(parts.filter_failure, std::exception_ptr()));
  if (failed) raise(*failed);
}

py::list events(const PyWorld& self) {
  const WorldCall call(self);
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
  const WorldBody known = self.parts->id(number_of(self, body));
  const WorldCall call(self);
  const World& world = *self.parts->all;
  const std::optional<std::size_t> collider = world.find_collider(other);
  std::optional<WorldBody> partner;
  if (!collider) partner = self.parts->id(number_of(self, py::str(other)));
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
  const WorldBody id = self.parts->id(number_of(self, body));
  const WorldCall call(self);
  const WorldAccount account = self.parts->all->account(id);
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
  const WorldCall call(self);
  const SceneWorld& world = self.parts->world;
  py::list list;
  for (std::size_t i = 0; i < world.scene().colliders.size(); ++i) {
    if (world.collider_removed(i)) continue;
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
  const WorldCall call(self);
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
  const WorldCall call(self);
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
  const WorldCall call(self);
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

py::tuple pickled(const PyWorld& self) {
  const py::bytes state = save_world(self);
  const WorldParts& parts = *self.parts;
  return py::make_tuple(kPickleName, kPickleVersion, parts.text, parts.path, pickled_changes(self),
                        parts.stepped, state);
}

PyWorld unpickled(const py::tuple& state) {
  check_pickle(state, 7, kPickleName, kPickleVersion);
  PyWorld made = make_world(state[2].cast<std::string>(), state[3].cast<std::string>());
  make_changes(made, state[4], state[5].cast<bool>());
  restore_world(made, state[6].cast<std::string>());
  return made;
}

py::list names(const PyWorld& self) {
  py::list list;
  for (const BodyNumber body : self.parts->bodies()) list.append(self.parts->name(body));
  return list;
}

py::object body_of(const PyWorld& self, py::handle name) {
  return object_of(self, number_of(self, name));
}

std::string describe(const PyWorld& self) {
  const SceneWorld& world = self.parts->world;
  std::size_t count = world.scene().colliders.size();
  for (std::size_t c = 0; c < world.scene().colliders.size(); ++c)
    if (world.collider_removed(c)) --count;
  return "<tremolo.World: " + std::to_string(self.parts->all->size()) + " bodies, " +
         std::to_string(count) + " colliders>";
}

py::tuple momenta_tuple(const Momenta& m) {
  return py::make_tuple(array_of<3>(m.linear), array_of<3>(m.angular));
}

// A property, and a function of one body, each one call on the world.
template <class Get>
void property(WorldClass& c, const char* name, const char* doc, const Get& get) {
  c.def_property_readonly(
      name,
      [get](const PyWorld& self) {
        const WorldCall call(self);
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
        const BodyNumber known = number_of(self, body);
        const WorldCall call(self);
        WorldParts& parts = *self.parts;
        return known.guest ? of_guest(parts.guest(known)) : get(parts.world, known.index);
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
  c.def("__len__", [](const PyWorld& self) { return self.parts->all->size(); });
  c.def(
      "step", &step, py::arg("n") = 1,
      "Takes n steps without the interpreter's lock. If a step of a body fails, SolverError or "
      "BoundError names it; the world continues without it at the next call. Ctrl-C ends the call "
      "between two steps.");
  add_queries(c);
  add_changes_of_world(c);
  c.def(
      "set_threads",
      [](const PyWorld& self, unsigned threads) {
        const WorldCall call(self);
        check(self.parts->world.set_threads(threads));
      },
      py::arg("threads"), "Threads of a step; 0: one per core. Results do not depend on it.");
  c.def("save", &save_world, "The state between steps, bytes, as `tremolo run --save` writes it.");
  c.def("restore", &restore_world, py::arg("bytes"),
        "Continues from save() of a world of this scene.");
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
