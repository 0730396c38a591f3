// The class tremolo.Body.
#include <span>
#include <utility>

#include "common/material.h"
#include "runtime/apps/python/module/body_handle.h"
#include "runtime/apps/python/module/surface_arrays.h"
#include "runtime/bodies/reduced/surface_velocity.h"

namespace tremolo::python {
namespace {

constexpr int kPickleVersion = 1;
constexpr const char* kPickleName = "tremolo.Body";

FrameKind frame_of(const std::string& name) {
  if (name == "fixed") return FrameKind::kFixed;
  if (name == "driven") return FrameKind::kDriven;
  if (name == "free") return FrameKind::kFree;
  raise(usage_error("unknown frame '" + name + "'; known: fixed driven free"));
}
const char* name_of(FrameKind frame) {
  switch (frame) {
    case FrameKind::kFixed:
      return "fixed";
    case FrameKind::kDriven:
      return "driven";
    case FrameKind::kFree:
      return "free";
  }
  return "";
}

SplitOptions split_of(py::handle split, double safety) {
  SplitOptions options = unwrap(parse_split(text_of(split)));
  options.safety = safety;
  return options;
}

BodyPointer body_of_model(const PyModelPointer& model, const std::string& integrator, double step,
                          double alpha, double beta, py::handle damping_ratio, py::object frame,
                          py::handle split, double safety, double newmark_beta,
                          double newmark_gamma, double tolerance, int max_iterations,
                          int halvings) {
  BodyOptions options;
  options.integrator = integrator;
  options.method.step = step;
  options.method.alpha = alpha;
  options.method.beta = beta;
  if (!damping_ratio.is_none()) {
    if (alpha != 0.0 || beta != 0.0)
      raise(usage_error("damping_ratio gives the damping: leave alpha and beta out"));
    put_damping(damping_ratios_of(damping_ratio), options.method);
  }
  options.method.split = split_of(split, safety);
  options.method.newmark_beta = newmark_beta;
  options.method.newmark_gamma = newmark_gamma;
  options.method.tolerance = tolerance;
  options.method.max_iterations = max_iterations;
  options.method.halvings = halvings;
  const bool is_free = model->model->rigid_mode_count() > 0;
  options.frame = frame.is_none() ? (is_free ? FrameKind::kFree : FrameKind::kFixed)
                                  : frame_of(frame.cast<std::string>());
  return make_body(model, options);
}

void step(BodyHandle& self, std::int64_t count) {
  const BodyHandle::Call call(self);
  self.refuse_in_world("world.step() steps it");
  if (count < 0) raise(usage_error("n: " + std::to_string(count) + ", must not be negative"));
  ContactBody& body = self.body();
  StepReport report;
  try {
    run_unlocked(count, [&](std::int64_t) {
      report = body.step();
      return report.converged;
    });
  } catch (...) {
    self.pull_state();
    throw;
  }
  self.last_report = report;
  self.pull_state();
  if (!report.converged) raise({error_kind(report.failure), failure_message(report, body.time())});
}

py::array positions(BodyHandle& self, py::handle out, py::handle dtype) {
  const BodyHandle::Call call(self);
  const ContactBody& body = self.body();
  return write_places(
      body.model().drawn().rest.size(), out, dtype,
      [&](std::span<float> places) { return body.surface(places); },
      [&](std::span<double> places) { return body.surface_positions(places); });
}

// positions() as a function of C: pybind11 needs 0.6 us to sort arguments with names, which is a
// fiftieth of the time of 10 000 vertices.
constexpr const char* kPositionsDoc =
    "positions(self: tremolo._tremolo.Body, out: object = None, *, dtype: object = "
    "dtype('float64')) -> numpy.ndarray\n\n"
    "Positions of the drawn surface's vertices in the world, (d, 3), m. out: a float64 or float32 "
    "array for them; without it a new one of type dtype.";

py::object positions_of_arguments(PyObject* self, PyObject* const* values, Py_ssize_t count,
                                  PyObject* names) {
  if (count > 1) raise_type("positions() takes one argument without a name, `out`");
  py::handle out = count == 1 ? values[0] : Py_None;
  py::object dtype;
  const Py_ssize_t named = names == nullptr ? 0 : PyTuple_GET_SIZE(names);
  for (Py_ssize_t k = 0; k < named; ++k) {
    PyObject* name = PyTuple_GET_ITEM(names, k);
    const py::handle value = values[count + k];
    if (PyUnicode_CompareWithASCIIString(name, "out") == 0 && count == 0)
      out = value;
    else if (PyUnicode_CompareWithASCIIString(name, "dtype") == 0)
      dtype = py::reinterpret_borrow<py::object>(value);
    else
      raise_type("positions() has the arguments out and dtype once, found another '" +
                 text_of(name) + "'");
  }
  if (!dtype) dtype = out.is_none() ? py::object(py::dtype::of<double>()) : py::none();
  return positions(py::cast<BodyHandle&>(py::handle(self)), out, dtype);
}

PyObject* call_positions(PyObject* self, PyObject* const* values, Py_ssize_t count,
                         PyObject* names) {
  try {
    return positions_of_arguments(self, values, count, names).release().ptr();
  } catch (py::error_already_set& error) {
    error.restore();
  } catch (const py::builtin_exception& error) {
    error.set_error();
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
  }
  return nullptr;
}

void add_positions(const BodyClass& c) {
  // The cast is that of CPython's own tables: the flags say which function it is.
  static PyMethodDef method = {
      "positions", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&call_positions)),
      METH_FASTCALL | METH_KEYWORDS, kPositionsDoc};
  PyObject* made = PyDescr_NewMethod(reinterpret_cast<PyTypeObject*>(c.ptr()), &method);
  if (made == nullptr) throw py::error_already_set();
  c.attr("positions") = py::reinterpret_steal<py::object>(made);
}

py::array boundary_positions(BodyHandle& self, py::handle out) {
  const BodyHandle::Call call(self);
  const ContactBody& body = self.body();
  if (!out.is_none() && py::isinstance<py::array_t<float>>(out))
    raise_type("out: expected an array of type float64, found one of type float32");
  return write_places(
      body.model().surface().rest.size(), out, py::dtype::of<double>(),
      [](std::span<float>) -> Status { return Success{}; },
      [&](std::span<double> places) {
        return body.surface_positions(places, tremolo::SurfaceKind::kBoundary);
      });
}

py::tuple positions_and_normals(BodyHandle& self) {
  const BodyHandle::Call call(self);
  const ContactBody& body = self.body();
  const auto s = static_cast<py::ssize_t>(body.model().drawn().rest.size());
  py::array_t<float> places(Shape{s, 3}), normals(Shape{s, 3});
  const std::size_t count = 3 * static_cast<std::size_t>(s);
  check(body.surface(std::span(places.mutable_data(), count),
                     std::span(normals.mutable_data(), count)));
  return py::make_tuple(places, normals);
}

// Velocities of the boundary's or the drawn surface's vertices relative to the frame, U p, and with
// the frame's own motion for a free body.
py::array_t<double> velocities(BodyHandle& self) {
  const BodyHandle::Call call(self);
  const ContactBody& body = self.body();
  const auto s = static_cast<py::ssize_t>(body.model().drawn().rest.size());
  py::array_t<double> made(Shape{s, 3});
  check(surface_velocities(body, std::span(made.mutable_data(), 3 * static_cast<std::size_t>(s))));
  return made;
}

py::dict energy(BodyHandle& self) {
  const BodyHandle::Call call(self);
  const ContactBody& body = self.body();
  const Energy now = body.energy();
  py::dict dict;
  dict["kinetic"] = now.kinetic;
  dict["potential"] = now.potential;
  dict["total"] = now.total();
  dict["high_band"] = now.high_band;
  dict["work"] = body.sums().work;
  dict["dissipated"] = body.sums().dissipated;
  dict["support"] = body.sums().support;
  dict["gravity"] = body.sums().gravity;
  const ContactSums& sums = body.contact_sums();
  dict["contact"] = sums.work;
  dict["restitution"] = -sums.lost;
  dict["friction"] = -sums.friction_loss;
  dict["grabs"] = sums.hand;
  dict["joints"] = sums.joint;
  return dict;
}

py::object pick(BodyHandle& self, py::handle origin, py::handle direction) {
  const BodyHandle::Call call(self);
  const std::optional<SurfaceHit> hit =
      unwrap(self.body().pick(vector3(origin, "origin"), vector3(direction, "direction")));
  if (!hit) return py::none();
  py::dict dict;
  dict["vertex"] = hit->vertex;
  dict["triangle"] = hit->place.triangle;
  dict["weights"] = array_of<3>(hit->place.weights);
  dict["distance"] = hit->distance;
  dict["point"] = array_of<3>(hit->point);
  return dict;
}

py::bytes save(BodyHandle& self) {
  const BodyHandle::Call call(self);
  const std::vector<std::byte> bytes = self.body().save();
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void restore(BodyHandle& self, const std::string& bytes) {
  const BodyHandle::Call call(self);
  check(self.body().restore(std::as_bytes(std::span(bytes.data(), bytes.size()))));
  self.pull_state();
}

// The bytes that make the body again, with its method, damping, gravity and loads as they are now.
py::tuple pickled(BodyHandle& self) {
  self.refuse_in_world("copy or pickle the world");
  const py::bytes saved = save(self);
  const BodyHandle::Call call(self);
  const ContactBody& body = self.body();
  const IntegratorOptions& m = self.options().method;
  py::list loads;
  for (const BodyLoad& load : self.loads()) loads.append(tuple_of_load(load));
  const py::tuple method = py::make_tuple(
      std::string(body.integrator().name()), body.options().step, body.options().alpha,
      body.options().beta, m.newmark_beta, m.newmark_gamma, static_cast<int>(m.split.rule),
      m.split.count, m.split.safety, m.tolerance, m.max_iterations, m.halvings);
  return py::make_tuple(kPickleName, kPickleVersion, self.model(), method,
                        static_cast<int>(body.frame()), self.has_grabs_enabled(), loads, saved);
}

BodyPointer unpickled(const py::tuple& state) {
  check_pickle(state, 8, kPickleName, kPickleVersion);
  BodyOptions options;
  IntegratorOptions& m = options.method;
  const auto method = state[3].cast<py::tuple>();
  options.integrator = method[0].cast<std::string>();
  m.step = method[1].cast<double>();
  m.alpha = method[2].cast<double>();
  m.beta = method[3].cast<double>();
  m.newmark_beta = method[4].cast<double>();
  m.newmark_gamma = method[5].cast<double>();
  m.split.rule = choice_of<SplitRule>(method[6], 3);
  m.split.count = method[7].cast<int>();
  m.split.safety = method[8].cast<double>();
  m.tolerance = method[9].cast<double>();
  m.max_iterations = method[10].cast<int>();
  m.halvings = method[11].cast<int>();
  options.frame = choice_of<FrameKind>(state[4], 3);
  const auto model = state[2].cast<PyModelPointer>();
  if (!model) raise_damaged_pickle();
  BodyPointer made = make_body(model, options);
  if (state[5].cast<bool>()) made->enable_grabs();
  for (const py::handle load : state[6]) made->add_load(load_of_tuple(load.cast<py::tuple>()));
  restore(*made, state[7].cast<std::string>());
  return made;
}

BodyPointer copied(BodyHandle& self) {
  return unpickled(pickled(self));
}

void set_damping(BodyHandle& self, double alpha, double beta, py::handle damping_ratio) {
  DampingRatios damping{{alpha, beta}, {}, {}};
  if (!damping_ratio.is_none()) {
    if (alpha != 0.0 || beta != 0.0)
      raise(usage_error("damping_ratio gives the damping: leave alpha and beta out"));
    damping = damping_ratios_of(damping_ratio);
  }
  const BodyHandle::Call call(self);
  check(self.body().set_damping(damping));
}

void set_method(BodyHandle& self, const std::string& integrator, double step_size) {
  const BodyHandle::Call call(self);
  self.refuse_in_world("world.set_method() and world.set_step() change it");
  check(self.body().set_method(integrator, step_size));
}

void set_state(BodyHandle& self, py::handle q, py::handle p) {
  const BodyHandle::Call call(self);
  const Eigen::Index r = self.body().model().modes();
  const State& now = self.body().state();
  const Eigen::VectorXd new_q = q.is_none() ? now.q : vector(q, r, "q");
  const Eigen::VectorXd new_p = p.is_none() ? now.p : vector(p, r, "p");
  check(self.body().set_state(new_q, new_p));
  self.pull_state();
}

// Frame.

void set_pose(BodyHandle& self, py::handle position, py::handle rotation) {
  const BodyHandle::Call call(self);
  check(self.body().set_pose(pose_of(position, rotation)));
}
void move_to(BodyHandle& self, py::handle position, py::handle rotation) {
  const BodyHandle::Call call(self);
  check(self.body().move_to(pose_of(position, rotation)));
}
void set_motion(BodyHandle& self, py::handle velocity, py::handle spin) {
  const BodyHandle::Call call(self);
  check(self.body().set_motion(vector3(velocity, "velocity"), vector3(spin, "spin")));
}

std::string describe(BodyHandle& self) {
  if (!self.ended().empty()) return "<tremolo.Body: '" + self.ended() + "', removed>";
  ContactBody& body = self.body();
  return std::string("<tremolo.Body: ") + name_of(body.frame()) + ", " +
         std::to_string(body.model().modes()) + " coordinates>";
}

// A property whose getter makes one call on the body.
template <class Get>
void property(BodyClass& c, const char* name, const char* doc, const Get& get) {
  c.def_property_readonly(
      name,
      [get](BodyHandle& self) {
        const BodyHandle::Call call(self);
        return get(self.body());
      },
      doc);
}

void add_state(BodyClass& c) {
  c.def_property(
      "q", &BodyHandle::q, [](BodyHandle& self, py::handle q) { set_state(self, q, py::none()); },
      "Coordinates, (r,), kg^1/2 m. A live array: steps change it, and what is written into it is "
      "the body's state at the next call. body.q.copy() keeps a moment.");
  c.def_property(
      "p", &BodyHandle::p, [](BodyHandle& self, py::handle p) { set_state(self, py::none(), p); },
      "Momenta, (r,), kg^1/2 m/s, live as `q`; the mass matrix is the identity, so they are the "
      "velocities of the coordinates.");
  c.def("set_state", &set_state, py::arg("q") = py::none(), py::arg("p") = py::none(),
        "Sets q and p, (r,) each; None leaves one as it is.");
  c.def("step", &step, py::arg("n") = 1,
        "Takes n steps without the interpreter's lock: bodies of several threads step at the same "
        "time. A failed step raises SolverError and leaves the state before it, or BoundError, and "
        "q and p are those of the last energy check (every 8 steps) that was sound. time and steps "
        "are always those before the failed step: to go on, set a state or restore a saved one. "
        "Ctrl-C ends the call between two steps.");
  property(c, "time", "steps times step_size, s.", [](ContactBody& b) { return b.time(); });
  property(c, "steps", "Number of steps taken.", [](ContactBody& b) { return b.counts().steps; });
  property(c, "step_size", "h, s.", [](ContactBody& b) { return b.options().step; });
  property(c, "integrator", "Name of the method.",
           [](ContactBody& b) { return std::string(b.integrator().name()); });
  property(c, "alpha", "Rayleigh damping by mass, 1/s.",
           [](ContactBody& b) { return b.options().alpha; });
  property(c, "beta", "Rayleigh damping by stiffness, s.",
           [](ContactBody& b) { return b.options().beta; });
  property(c, "iterations", "Linear systems solved in all steps.",
           [](ContactBody& b) { return b.counts().iterations; });
  c.def_property_readonly(
      "report", [](BodyHandle& self) { return report_dict(self.last_report); },
      "The last step: iterations, residual, converged, dissipated (J), parts. A dict.");
  c.def_property_readonly("energy", &energy,
                          "Energies, J, a dict. Now: kinetic, potential, total, high_band. Since "
                          "the start: work (of all forces, with support, gravity, contact, grabs, "
                          "joints), dissipated (by damping), restitution and friction (never "
                          "positive).");
  c.def("set_damping", &set_damping, py::arg("alpha") = 0.0, py::arg("beta") = 0.0, py::kw_only(),
        py::arg("damping_ratio") = py::none(),
        "Rayleigh damping, 1/s and s, or a ratio as in Model.body, from the next step on, in place "
        "of all damping before.");
  c.def("set_method", &set_method, py::arg("integrator"), py::arg("step"),
        "Another method and step (s) from the next step on.");
}

void add_surface(BodyClass& c) {
  add_positions(c);
  c.def("boundary_positions", &boundary_positions, py::arg("out") = py::none(),
        "Positions of the boundary's vertices in the world, (s, 3), m, float64.");
  c.def("positions_and_normals", &positions_and_normals,
        "Positions (m) and unit normals of the drawn surface, two arrays (d, 3), float32.");
  c.def("velocities", &velocities,
        "Velocities of the drawn surface's vertices in the world, (d, 3), m/s, of a fixed or a "
        "free body.");
  c.def(
      "position",
      [](BodyHandle& self, VertexId vertex) {
        const BodyHandle::Call call(self);
        return array_of<3>(unwrap(self.body().position(vertex)));
      },
      py::arg("vertex"), "Position of a vertex of the mesh, also inside, (3,), m, world.");
  c.def(
      "displacement",
      [](BodyHandle& self, VertexId vertex) {
        const BodyHandle::Call call(self);
        return array_of<3>(unwrap(self.body().displacement(vertex)));
      },
      py::arg("vertex"), "U q of a vertex of the mesh, (3,), m, along the frame's axes.");
  c.def("pick", &pick, py::arg("origin"), py::arg("direction"),
        "The first hit of a ray (m, world) on the deformed drawn surface: a dict of vertex, "
        "triangle, weights, distance and point; None if it misses.");
}

void add_frame(BodyClass& c) {
  property(c, "frame", "\"fixed\", \"driven\" or \"free\".",
           [](ContactBody& b) { return std::string(name_of(b.frame())); });
  property(c, "pose",
           "(position (3,), m; rotation (4,), w x y z) of the frame: vertices are at "
           "position + rotation (X + U q).",
           [](ContactBody& b) { return tuple_of(b.pose()); });
  const auto no_turn = py::make_tuple(1.0, 0.0, 0.0, 0.0);
  c.def("set_pose", &set_pose, py::arg("position"), py::arg("rotation") = no_turn,
        "Moves a driven or free body at once, without an impulse.");
  c.def("move_to", &move_to, py::arg("position"), py::arg("rotation") = no_turn,
        "The pose of a driven body's frame at the end of the next step; without a call the frame "
        "is at rest.");
  c.def("set_motion", &set_motion, py::arg("velocity"),
        py::arg("spin") = py::make_tuple(0.0, 0.0, 0.0),
        "Of a free body: velocity of the centre of mass, m/s, world, and spin, rad/s, along the "
        "body's axes.");
  property(c, "velocity", "Of a free body's centre of mass, (3,), m/s, world; else zeros.",
           [](ContactBody& b) { return array_of<3>(b.rigid_state().velocity); });
  property(c, "spin", "Of a free body, (3,), rad/s, along its axes; else zeros.",
           [](ContactBody& b) { return array_of<3>(b.rigid_state().spin); });
  property(c, "linear_momentum", "(3,), kg m/s.",
           [](ContactBody& b) { return array_of<3>(b.momentum().linear); });
  property(c, "angular_momentum", "About the world's origin, (3,), N m s.",
           [](ContactBody& b) { return array_of<3>(b.momentum().angular); });
  c.def_property(
      "gravity",
      [](BodyHandle& self) {
        const BodyHandle::Call call(self);
        return array_of<3>(self.body().gravity());
      },
      [](BodyHandle& self, py::handle gravity) {
        const BodyHandle::Call call(self);
        self.refuse_in_world("gravity is the scene's");
        check(self.body().set_gravity(vector3(gravity, "gravity")));
      },
      "Gravity, (3,), m/s^2, world.");
}

}  // namespace

void add_body(py::module_& module) {
  BodyClass c(module, "Body",
              "A model with its motion and loads; model.body() makes it. Calls of two threads at "
              "the same time on one body are refused (UsageError). copy.copy and pickle keep the "
              "whole state: the copy's next steps have the same bits.");
  add_state(c);
  add_surface(c);
  add_frame(c);
  add_loads_of_body(c);
  c.def_property_readonly("model", &BodyHandle::model, "The body's tremolo.Model.");
  c.def("save", &save, "The whole state between steps, bytes; loads in time are not in it.");
  c.def("restore", &restore, py::arg("bytes"),
        "Continues from save() of a body of the same model, method, frame and loads.");
  c.def("__reduce__", [](BodyHandle& self) { return reduced("body_of", pickled(self)); });
  refuse_construction(c, "model.body() makes one");
  module.def("_body_of", from_pickle(&unpickled), py::arg("state"),
             "A body of its pickle's state.");
  c.def("__copy__", &copied);
  c.def("__deepcopy__", [](BodyHandle& self, const py::object&) { return copied(self); });
  c.def("__repr__", &describe);

  auto model = module.attr("Model").cast<py::class_<PyModel, PyModelPointer>>();
  model.def("body", &body_of_model, py::kw_only(), py::arg("integrator") = "ep4",
            py::arg("step") = 3e-3, py::arg("alpha") = 0.0, py::arg("beta") = 0.0,
            py::arg("damping_ratio") = py::none(), py::arg("frame") = py::none(),
            py::arg("split") = "default", py::arg("safety") = 0.9, py::arg("newmark_beta") = 0.25,
            py::arg("newmark_gamma") = 0.5, py::arg("tolerance") = 1e-6,
            py::arg("max_iterations") = 20, py::arg("halvings") = 6,
            "A body of this model at rest, at time 0. integrator: one of integrators(). step: h, "
            "s. alpha (1/s), beta (s): Rayleigh damping; or damping_ratio, the fraction of "
            "critical damping of every mode, \"2%\" or 0.02, of each mode, \"2%,1%\" or a list, "
            "at two frequencies (Hz), \"1:2%,30:5%\", or a table of more. frame: \"fixed\", "
            "\"driven\" (follows move_to) or \"free\"; by default as the model is held. split, "
            "safety: of the imexv methods. tolerance, max_iterations: of the solve in a step.");
}

}  // namespace tremolo::python
