// Loads, forces and grabs of tremolo.Body.
#include <utility>

#include "runtime/apps/python/module/body_handle.h"
#include "runtime/scene/selection.h"

namespace tremolo::python {
namespace {

// The `signal` argument: a name, or (times, values).
BodyLoad load_in_time(py::handle signal, double start, py::handle duration, py::handle frequency,
                      py::handle sweep) {
  BodyLoad load;
  if (PyUnicode_Check(signal.ptr())) {
    load.signal = unwrap(parse_signal(signal.cast<std::string>()));
  } else {
    if (!py::isinstance<py::sequence>(signal) || py::len(signal) != 2)
      raise_type("signal: expected a name or (times, values)");
    const auto pair = py::reinterpret_borrow<py::sequence>(signal);
    const Doubles times = finite_numbers(py::object(pair[0]), "signal, times");
    const Doubles values = finite_numbers(py::object(pair[1]), "signal, values");
    auto table = std::make_shared<SignalTable>();
    table->times.assign(times.data(), times.data() + times.size());
    table->values.assign(values.data(), values.data() + values.size());
    if (const std::string problem = table_problem(*table); !problem.empty())
      raise(content_error("signal: " + problem));
    load.table = std::move(table);
    load.signal.kind = SignalKind::kTable;
    load.signal.table = load.table.get();
  }
  SignalShape shape;
  if (!duration.is_none()) shape.duration = duration.cast<double>();
  if (!frequency.is_none()) shape.frequency = frequency.cast<double>();
  if (!sweep.is_none()) {
    const Eigen::VectorXd both = vector(sweep, 2, "sweep");
    shape.sweep = py::str("{!r},{!r}").format(both[0], both[1]).cast<std::string>();
  }
  check(shape_signal(shape, load.signal));
  if (!std::isfinite(start)) raise(content_error("start: the time is not finite"));
  load.signal.start = start;
  return load;
}

DefaultLoad forces_at(py::handle at, py::handle force, const Model& model) {
  const std::vector<VertexId> ids = vertices_at(at, model);
  const Doubles given = finite_numbers(force, "force");
  if (given.ndim() == 1) return shared_by_area(ids, vector3(given, "force"), model);
  DefaultLoad load{ids, points(given, "force")};
  if (load.forces.size() != ids.size())
    raise(usage_error("force: " + std::to_string(load.forces.size()) + " forces for " +
                      std::to_string(ids.size()) + " vertices"));
  return load;
}

void add_load(BodyHandle& self, py::handle at, py::handle force, py::handle reduced,
              py::handle signal, double scale, double start, py::handle duration,
              py::handle frequency, py::handle sweep) {
  const BodyHandle::Call call(self);
  self.refuse_in_world("its loads in time are those of the scene; apply_force acts on it");
  BodyLoad load = load_in_time(signal, start, duration, frequency, sweep);
  const Model& model = self.body().model();
  if (!std::isfinite(scale)) raise(content_error("scale: the number is not finite"));
  if (!reduced.is_none()) {
    if (!at.is_none() || !force.is_none())
      raise(usage_error("a load is either `reduced` or `force` at vertices"));
    load.force = Eigen::VectorXd(scale * vector(reduced, model.modes(), "reduced"));
  } else if (at.is_none() && force.is_none()) {
    load.force = scale;
  } else {
    if (at.is_none() || force.is_none())
      raise(usage_error("a load on vertices needs both `at` and `force`"));
    DefaultLoad forces = forces_at(at, force, model);
    for (Eigen::Vector3d& each : forces.forces) each *= scale;
    load.force = std::move(forces);
  }
  self.add_load(load);
}

void apply_force(BodyHandle& self, py::handle at, py::handle force, int steps) {
  const BodyHandle::Call call(self);
  if (steps < 1) raise(usage_error("steps: " + std::to_string(steps) + ", must be at least 1"));
  const DefaultLoad forces = forces_at(at, force, self.body().model());
  for (std::size_t i = 0; i < forces.vertices.size(); ++i)
    check(self.body().apply_force(forces.vertices[i], forces.forces[i], steps));
}

// Grabs.

// One vertex, by its index or a selector of one vertex.
VertexId vertex_at(py::handle at, const Model& model) {
  std::vector<VertexId> ids;
  if (PyLong_Check(at.ptr()))
    ids = vertex_ids(at, "at", ErrorKind::kUsage);
  else
    ids = vertices_at(at, model);
  if (ids.size() != 1)
    raise(usage_error("at: expected one vertex, found " + std::to_string(ids.size())));
  return ids.front();
}

std::size_t grab(BodyHandle& self, py::handle at, double stiffness, double damping) {
  const BodyHandle::Call call(self);
  const VertexId vertex = vertex_at(at, self.body().model());
  return self.grab([&](ContactBody& body) { return body.grab(vertex, stiffness, damping); });
}

std::size_t pin(BodyHandle& self, py::handle at) {
  const BodyHandle::Call call(self);
  const VertexId vertex = vertex_at(at, self.body().model());
  return self.grab([&](ContactBody& body) { return body.pin(vertex); });
}

void move_grab(BodyHandle& self, std::size_t number, py::handle position) {
  const BodyHandle::Call call(self);
  check(self.body().move_hand(number, vector3(position, "position")));
}

py::array_t<double> grab_force(BodyHandle& self, std::size_t number) {
  const BodyHandle::Call call(self);
  return array_of<3>(self.body().hand_force(number));
}

void release(BodyHandle& self, std::size_t number) {
  const BodyHandle::Call call(self);
  check(self.body().release(number));
}

}  // namespace

py::tuple tuple_of_load(const BodyLoad& load) {
  const Signal& s = load.signal;
  py::object table = py::none();
  if (load.table) {
    py::list times, values;
    for (const double t : load.table->times) times.append(t);
    for (const double v : load.table->values) values.append(v);
    table = py::make_tuple(times, values);
  }
  py::object force;
  if (const auto* reduced = std::get_if<Eigen::VectorXd>(&load.force)) {
    force = py::make_tuple("reduced", array_of<Eigen::Dynamic>(*reduced));
  } else if (const auto* forces = std::get_if<DefaultLoad>(&load.force)) {
    py::list ids, each;
    for (const VertexId id : forces->vertices) ids.append(id);
    for (const Eigen::Vector3d& f : forces->forces) each.append(array_of<3>(f));
    force = py::make_tuple("forces", ids, each);
  } else {
    force = py::make_tuple("default", std::get<double>(load.force));
  }
  return py::make_tuple(static_cast<int>(s.kind), s.start, s.duration, s.frequency,
                        s.last_frequency, table, force);
}

BodyLoad load_of_tuple(const py::tuple& tuple) {
  BodyLoad load;
  load.signal.kind = choice_of<SignalKind>(tuple[0], 8);
  load.signal.start = tuple[1].cast<double>();
  load.signal.duration = tuple[2].cast<double>();
  load.signal.frequency = tuple[3].cast<double>();
  load.signal.last_frequency = tuple[4].cast<double>();
  if (!tuple[5].is_none()) {
    const auto pair = tuple[5].cast<py::tuple>();
    auto table = std::make_shared<SignalTable>();
    for (const py::handle t : pair[0]) table->times.push_back(t.cast<double>());
    for (const py::handle v : pair[1]) table->values.push_back(v.cast<double>());
    if (!table_problem(*table).empty()) raise_damaged_pickle();
    load.table = std::move(table);
  }
  if ((load.signal.kind == SignalKind::kTable) != (load.table != nullptr)) raise_damaged_pickle();
  const auto force = tuple[6].cast<py::tuple>();
  const auto kind = force[0].cast<std::string>();
  if (kind == "reduced") {
    const Doubles reduced = finite_numbers(force[1], "a load of the pickle");
    load.force = Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(reduced.data(), reduced.size()));
  } else if (kind == "forces") {
    DefaultLoad forces;
    forces.vertices = vertex_ids(py::object(force[1]), "a load of the pickle");
    for (const py::handle f : force[2]) forces.forces.push_back(vector3(f, "a load of the pickle"));
    if (forces.forces.size() != forces.vertices.size()) raise_damaged_pickle();
    load.force = std::move(forces);
  } else {
    load.force = force[1].cast<double>();
  }
  return load;
}

void add_loads_of_body(BodyClass& c) {
  c.def("add_load", &add_load, py::arg("at") = py::none(), py::arg("force") = py::none(),
        py::kw_only(), py::arg("reduced") = py::none(), py::arg("signal") = "constant",
        py::arg("scale") = 1.0, py::arg("start") = 0.0, py::arg("duration") = py::none(),
        py::arg("frequency") = py::none(), py::arg("sweep") = py::none(),
        "Adds a load in time. at: an index of a vertex, an array of indices or a selector; force: "
        "(3,), N, shared by the vertices, or one for each, (k, 3), along the world's axes. Or "
        "reduced: (r,). With neither the load is the model's default load. scale multiplies it. "
        "signal: \"impulse\", \"square\", \"sine\", \"chirp\", \"ramp\", \"constant\", or (times, "
        "values), s. start, duration: s. frequency: Hz, of a sine; sweep: (F1, F2), Hz, of a "
        "chirp.");
  c.def(
      "clear_loads",
      [](BodyHandle& self) {
        const BodyHandle::Call call(self);
        self.refuse_in_world("its loads in time are those of the scene");
        self.clear_loads();
      },
      "Removes the loads of add_load.");
  c.def("apply_force", &apply_force, py::arg("at"), py::arg("force"), py::arg("steps") = 1,
        "A force at vertices, as in add_load, that is constant over the next `steps` steps.");
  c.def(
      "clear_forces",
      [](BodyHandle& self) {
        const BodyHandle::Call call(self);
        self.body().clear_forces();
      },
      "Removes the forces of apply_force that still act.");
  c.def(
      "grab", &grab, py::arg("at"), py::arg("stiffness"), py::arg("damping") = 0.0,
      "Grabs a vertex, by its index or a selector of one vertex, with a spring (N/m) and a damper "
      "(N s/m) to a point that move_grab moves; it starts at the vertex. Returns the grab's "
      "number. Needs one of the methods avf, ep2, ep4 where the frame moves.");
  c.def("pin", &pin, py::arg("at"),
        "Holds a vertex where it is, or where move_grab moves it, by the stiffest spring that the "
        "step can solve. Returns the grab's number.");
  c.def("move_grab", &move_grab, py::arg("number"), py::arg("position"),
        "Sets the position of the grab's point at the end of the next step, (3,), m, world.");
  c.def("grab_force", &grab_force, py::arg("number"),
        "The force of the grab on the body in the last step, (3,), N, world.");
  c.def("release", &release, py::arg("number"), "Ends a grab; the others keep their numbers.");
}

}  // namespace tremolo::python
