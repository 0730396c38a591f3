// The class tremolo.NodalBody.
#include <algorithm>
#include <utility>

#include "runtime/apps/python/module/body_handle.h"
#include "runtime/apps/python/module/nodal_handle.h"
#include "runtime/apps/python/module/surface_arrays.h"

namespace tremolo::python {

std::optional<std::size_t> NodalBodies::find(const std::string& name) const {
  for (std::size_t i = 0; i < sources_.size(); ++i)
    if (has(i) && sources_[i]->name() == name) return i;
  return std::nullopt;
}

void NodalBodies::put(std::size_t i, std::unique_ptr<NodalSource> source) {
  if (i >= sources_.size()) {
    sources_.resize(i + 1);
    handles_.resize(i + 1);
  }
  sources_[i] = std::move(source);
  handles_[i].reset();
}

void NodalBodies::end(std::size_t i) {
  if (const NodalPointer known = handles_[i].lock()) {
    known->ended = sources_[i]->name();
    known->source = nullptr;
  }
  put(i, nullptr);
}

NodalPointer NodalBodies::handle(std::size_t i, const std::shared_ptr<void>& owner,
                                 std::atomic<bool>& used) {
  if (NodalPointer known = handles_[i].lock()) return known;
  auto made = std::make_shared<NodalHandle>(NodalHandle{owner, &used, sources_[i].get()});
  handles_[i] = made;
  return made;
}

namespace {

// The body for one call, which refuses all others on its world or scene meanwhile.
class Call {
 public:
  explicit Call(const NodalHandle& self) : used_(*self.used, "world") {
    if (self.source == nullptr) refuse_removed(self.ended);
  }

 private:
  InUse used_;
};

template <class Number>
Status copy_places(std::span<const Eigen::Vector3d> places, std::span<Number> out) {
  for (std::size_t v = 0; v < places.size(); ++v)
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[3 * v + axis] = static_cast<Number>(places[v][static_cast<Eigen::Index>(axis)]);
  return Success{};
}

py::array at_surface(const NodalHandle& self, py::handle out, py::handle dtype, bool velocities) {
  const Call call(self);
  NodalSource& source = *self.source;
  const Eigen::VectorXd& values = velocities ? source.velocities() : source.points();
  return write_places(
      source.drawn(), out, dtype,
      [&](std::span<float> places) { return copy_places(source.place(values), places); },
      [&](std::span<double> places) { return copy_places(source.place(values), places); });
}

py::array_t<double> rows_of_three(const Eigen::VectorXd& values) {
  return py::array_t<double>(Shape{values.size() / 3, 3}, values.data());
}

// (n, 3) finite numbers, or without an array the values that are there.
Eigen::VectorXd state_of(py::handle given, const Eigen::VectorXd& now, const char* name) {
  if (given.is_none()) return now;
  const std::vector<Eigen::Vector3d> rows = points(given, name);
  if (std::cmp_not_equal(3 * rows.size(), now.size()))
    raise(usage_error(std::string(name) + ": expected the shape (" +
                      std::to_string(now.size() / 3) + ", 3), found (" +
                      std::to_string(rows.size()) + ", 3)"));
  Eigen::VectorXd all(now.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = rows[i];
  return all;
}

void set_state(const NodalHandle& self, py::handle given, py::handle velocities) {
  const Call call(self);
  NodalSource& source = *self.source;
  const Eigen::VectorXd x = state_of(given, source.points(), "points");
  const Eigen::VectorXd v = state_of(velocities, source.velocities(), "velocities");
  check(source.set_state(x, v));
  source.driven = true;
}

py::dict energy(const NodalHandle& self) {
  const Call call(self);
  const NodalEnergy now = self.source->energy();
  py::dict dict;
  dict["kinetic"] = now.kinetic;
  dict["potential"] = now.potential;
  dict["gravity"] = now.gravity;
  if (now.contact) dict["contact"] = *now.contact;
  return dict;
}

std::optional<double> number_or_none(py::handle given) {
  return given.is_none() ? std::nullopt : std::optional(given.cast<double>());
}

std::size_t drawn_vertex(const NodalHandle& self, std::int64_t vertex) {
  if (vertex < 0 || std::cmp_greater_equal(vertex, self.source->drawn()))
    raise(usage_error("vertex " + std::to_string(vertex) + " does not exist: the surface has " +
                      std::to_string(self.source->drawn())));
  return static_cast<std::size_t>(vertex);
}

std::size_t grab(const NodalHandle& self, std::int64_t vertex, py::handle stiffness,
                 py::handle damping) {
  const Call call(self);
  const auto made = unwrap(self.source->grab(drawn_vertex(self, vertex), number_or_none(stiffness),
                                             number_or_none(damping)));
  self.source->driven = true;
  return made;
}

std::size_t grab_number(std::int64_t number) {
  if (number < 0) raise(usage_error("there is no grab " + std::to_string(number)));
  return static_cast<std::size_t>(number);
}

std::string describe(const NodalHandle& self) {
  if (self.source == nullptr) return "<tremolo.NodalBody: '" + self.ended + "', removed>";
  return std::string("<tremolo.NodalBody: ") + self.source->kind() + ", " +
         std::to_string(self.source->points().size() / 3) + " points>";
}

using NodalClass = py::class_<NodalHandle, NodalPointer>;

template <class Get>
void property(NodalClass& c, const char* name, const char* doc, const Get& get) {
  c.def_property_readonly(
      name,
      [get](const NodalHandle& self) {
        const Call call(self);
        return get(*self.source);
      },
      doc);
}

void add_values(NodalClass& c) {
  property(c, "name", "Its name in the scene.", [](NodalSource& s) { return s.name(); });
  property(c, "kind", "\"tets\" or \"cloth\".", [](NodalSource& s) { return s.kind(); });
  property(c, "mass", "kg.", [](NodalSource& s) { return s.mass(); });
  property(c, "asleep", "True if it is at rest and not stepped until something wakes it.",
           [](NodalSource& s) { return s.asleep(); });
  property(c, "failed", "True if a step of it failed in a world: it is not stepped again.",
           [](NodalSource& s) { return s.failed(); });
  property(c, "points",
           "Its points, (n, 3), m, a copy: the particles of a cloth; of tetrahedra the vertices of "
           "the mesh and then a control point x_ab for each edge, whose middle is at "
           "(x_a + 2 x_ab + x_b) / 4.",
           [](NodalSource& s) { return rows_of_three(s.points()); });
  property(c, "point_velocities", "Velocities of `points`, (n, 3), m/s, a copy.",
           [](NodalSource& s) { return rows_of_three(s.velocities()); });
  property(c, "held", "True for points that do not move freely, (n,).", [](NodalSource& s) {
    py::array_t<bool> flags(static_cast<py::ssize_t>(s.held().size()));
    std::transform(s.held().begin(), s.held().end(), flags.mutable_data(),
                   [](std::uint8_t flag) { return flag != 0; });
    return flags;
  });
  property(c, "triangles", "Triangles of the drawn surface, (t, 3), int32, a copy.",
           [](NodalSource& s) {
             const std::vector<Triangle>& list = s.triangles();
             py::array_t<std::int32_t> made(Shape{static_cast<py::ssize_t>(list.size()), 3});
             std::int32_t* next = made.mutable_data();
             for (const Triangle& t : list)
               for (const auto v : t) *next++ = static_cast<std::int32_t>(v);
             return made;
           });
  c.def_property_readonly(
      "energy", &energy,
      "Energies now, J, a dict: kinetic, potential (elastic), gravity; in a world also contact.");
  property(c, "linear_momentum", "(3,), kg m/s.",
           [](NodalSource& s) { return array_of<3>(s.momenta().linear); });
  property(c, "angular_momentum", "About the world's origin, (3,), N m s.",
           [](NodalSource& s) { return array_of<3>(s.momenta().angular); });
}

}  // namespace

void add_nodal(py::module_& module) {
  NodalClass c(module, "NodalBody",
               "A body that moves by its points, tetrahedra or a cloth, of a world or of a scene "
               "of its kind, which steps it and which it keeps alive.");
  add_values(c);
  c.def(
      "positions",
      [](const NodalHandle& self, py::handle out, py::handle dtype) {
        return at_surface(self, out, dtype, false);
      },
      py::arg("out") = py::none(), py::kw_only(), py::arg("dtype") = py::dtype::of<double>(),
      "Positions of the drawn surface's vertices, (d, 3), m. out: a float64 or float32 array for "
      "them; without it a new one of type dtype.");
  c.def(
      "velocities",
      [](const NodalHandle& self, py::handle out, py::handle dtype) {
        return at_surface(self, out, dtype, true);
      },
      py::arg("out") = py::none(), py::kw_only(), py::arg("dtype") = py::dtype::of<double>(),
      "Velocities of the drawn surface's vertices, (d, 3), m/s; out and dtype as for positions.");
  c.def("set_state", &set_state, py::arg("points") = py::none(), py::arg("velocities") = py::none(),
        "Sets all points and their velocities, (n, 3) each; None leaves one as it is. Tetrahedra "
        "put control points of linear edges at the middle of the ends.");
  c.def(
      "grab", &grab, py::arg("vertex"), py::kw_only(), py::arg("stiffness") = py::none(),
      py::arg("damping") = py::none(),
      "Grabs a vertex of the drawn surface where it is and returns the grab's number. "
      "It is pulled by a spring (N/m) with a damper (N s/m), by default such as suit the place. A "
      "particle of a scene of cloth alone is held instead. In a world the vertex may be the next "
      "one that contact knows.");
  c.def(
      "move_grab",
      [](const NodalHandle& self, std::int64_t number, py::handle position) {
        const Call call(self);
        check(self.source->move_grab(grab_number(number), vector3(position, "position")));
      },
      py::arg("number"), py::arg("position"),
      "Sets the position of the grab's point at the end of the next step, (3,), m.");
  c.def(
      "release",
      [](const NodalHandle& self, std::int64_t number) {
        const Call call(self);
        check(self.source->release(grab_number(number)));
      },
      py::arg("number"), "Ends a grab.");
  c.def(
      "apply_force",
      [](const NodalHandle& self, std::int64_t vertex, py::handle force, int steps) {
        const Call call(self);
        check(self.source->apply_force(drawn_vertex(self, vertex), vector3(force, "force"), steps));
      },
      py::arg("vertex"), py::arg("force"), py::arg("steps") = 1,
      "A force on a vertex of the drawn surface, (3,), N, along the world's axes, constant over "
      "the "
      "next `steps` steps; in a world, where the vertex may be the next one that contact knows.");
  refuse_construction(c, "a world or a scene has it");
  c.def("__reduce__", [](const NodalHandle&) -> py::object {
    raise_type("a body of tetrahedra or cloth is neither copied nor pickled");
  });
  c.def("__repr__", &describe);
}

}  // namespace tremolo::python
