#include "runtime/apps/python/module/model_class.h"

#include <cstring>
#include <filesystem>
#include <span>
#include <utility>

#include "common/packed_index.h"
#include "formats/basis/basis_reader.h"
#include "runtime/scene/selection.h"

namespace tremolo::python {

std::unique_ptr<PotentialScratch> ScratchPool::take(const Potential& potential, unsigned uses) {
  {
    const std::scoped_lock lock(mutex_);
    if (!free_.empty()) {
      std::unique_ptr<PotentialScratch> scratch = std::move(free_.back());
      free_.pop_back();
      return scratch;
    }
  }
  return std::make_unique<PotentialScratch>(
      PotentialScratch{potential.make_workspace(uses), potential.make_evaluation(),
                       Eigen::VectorXd::Zero(potential.size())});
}

void ScratchPool::give_back(std::unique_ptr<PotentialScratch> scratch) {
  const std::scoped_lock lock(mutex_);
  free_.push_back(std::move(scratch));
}

PyModelPointer load_model(const std::string& path, const ModelOptions& options) {
  Result<Model::Pointer> model = [&] {
    const py::gil_scoped_release unlocked;
    return Model::load(path, options);
  }();
  auto made = std::make_shared<PyModel>();
  made->model = unwrap(std::move(model));
  made->options = options;
  made->path = std::filesystem::absolute(path).string();
  return made;
}

PyModelPointer load_model_of_bytes(std::string bytes, const ModelOptions& options) {
  Result<Model::Pointer> model = [&] {
    const py::gil_scoped_release unlocked;
    return Model::load_from_memory(std::as_bytes(std::span(bytes.data(), bytes.size())), options);
  }();
  auto made = std::make_shared<PyModel>();
  made->model = unwrap(std::move(model));
  made->options = options;
  made->bytes = std::move(bytes);
  return made;
}

std::vector<VertexId> vertices_at(py::handle at, const Model& model) {
  if (PyUnicode_Check(at.ptr())) return unwrap(vertices_of(at.cast<std::string>(), model));
  return vertex_ids(at, "at", ErrorKind::kUsage);
}

namespace {

constexpr int kPickleVersion = 1;

Shape shape_of(std::initializer_list<std::size_t> sizes) {
  Shape shape;
  for (const std::size_t size : sizes) shape.push_back(static_cast<py::ssize_t>(size));
  return shape;
}

// Of `self`, which keeps the memory alive.
const Model& model_of(py::handle self) {
  return *self.cast<const PyModel&>().model;
}

py::array places_view(const std::vector<Eigen::Vector3d>& places, py::handle owner) {
  return read_only_view(places.empty() ? nullptr : places.front().data(),
                        shape_of({places.size(), 3}), owner);
}
py::array triangles_view(const std::vector<Triangle>& triangles, py::handle owner) {
  return read_only_view(triangles.empty() ? nullptr : triangles.front().data(),
                        shape_of({triangles.size(), 3}), owner);
}
py::array rows_view(const BasisRows& rows, py::handle owner) {
  return read_only_view(
      rows.data(),
      shape_of({static_cast<std::size_t>(rows.rows()), static_cast<std::size_t>(rows.cols())}),
      owner);
}

// C_ijk of all indices, r x r x r; zeros for a linear model.
py::array_t<double> dense_cubic(const PyModel& self) {
  const std::span<const double> packed = self.model->cubic();
  const auto r = static_cast<std::size_t>(self.model->modes());
  py::array_t<double> dense(shape_of({r, r, r}));
  double* out = dense.mutable_data();
  for (std::size_t i = 0; i < r; ++i)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t k = 0; k < r; ++k)
        *out++ = packed.empty() ? 0.0 : packed[triple_index_any(i, j, k)];
  return dense;
}

py::array_t<double> dense_quartic(const PyModel& self) {
  const std::span<const double> packed = self.model->quartic();
  const auto r = static_cast<std::size_t>(self.model->modes());
  constexpr std::size_t kMost = 100;
  if (r > kMost)
    raise(usage_error("a dense array of " + std::to_string(r) +
                      "^4 numbers is too large: use `quartic`, which has each of them once"));
  py::array_t<double> dense(shape_of({r, r, r, r}));
  double* out = dense.mutable_data();
  for (std::size_t i = 0; i < r; ++i)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t k = 0; k < r; ++k)
        for (std::size_t l = 0; l < r; ++l)
          *out++ = packed.empty() ? 0.0 : packed[quad_index_any(i, j, k, l)];
  return dense;
}

// Evaluates `want` for one q (r) or many (n x r). size: numbers of one result. read(result, out)
// copies it.
template <class Read>
py::object evaluate(PyModel& self, py::handle given, py::handle out, Shape result_shape,
                    unsigned want, const Read& read) {
  const Potential& potential = self.model->potential();
  const Eigen::Index r = potential.size();
  const Doubles q = numbers(given, "q");
  if ((q.ndim() != 1 && q.ndim() != 2) || q.shape(q.ndim() - 1) != r)
    raise(usage_error("q: expected the shape (" + std::to_string(r) + ",) or (n, " +
                      std::to_string(r) + "), found " + shape_text(q)));
  const std::int64_t count = q.ndim() == 1 ? 1 : q.shape(0);
  std::size_t size = 1;
  for (const py::ssize_t extent : result_shape) size *= static_cast<std::size_t>(extent);
  if (q.ndim() == 2) result_shape.insert(result_shape.begin(), q.shape(0));
  py::array_t<double> results;
  if (out.is_none()) {
    results = py::array_t<double>(result_shape);
  } else {
    if (!py::isinstance<py::array>(out)) raise_type("out: expected an array of numpy");
    check_out<double>(py::reinterpret_borrow<py::array>(out), result_shape);
    results = py::reinterpret_borrow<py::array_t<double>>(out);
  }
  ScratchPool& pool = (want & kWantTangent) != 0 ? self.tangents : self.points;
  std::unique_ptr<PotentialScratch> scratch =
      pool.take(potential, (want & kWantTangent) != 0 ? kUseTangent : kUsePoint);
  const double* from = q.data();
  double* to = results.mutable_data();
  run_unlocked(count, [&](std::int64_t k) {
    scratch->q = Eigen::Map<const Eigen::VectorXd>(from + k * r, r);
    potential.evaluate(scratch->q, want, scratch->workspace, scratch->result);
    read(scratch->result, to + static_cast<std::size_t>(k) * size);
    return true;
  });
  pool.give_back(std::move(scratch));
  if (out.is_none() && results.ndim() == 0) return py::float_(*results.data());
  return results;
}

py::object energy(PyModel& self, py::handle q, py::handle out) {
  return evaluate(self, q, out, {}, kWantEnergy,
                  [](const Evaluation& result, double* to) { *to = result.energy; });
}
py::object force(PyModel& self, py::handle q, py::handle out) {
  return evaluate(self, q, out, {self.model->modes()}, kWantForce,
                  [](const Evaluation& result, double* to) {
                    std::memcpy(to, result.force.data(), sizeof(double) * result.force.size());
                  });
}
py::object tangent(PyModel& self, py::handle q, py::handle out) {
  return evaluate(self, q, out, {self.model->modes(), self.model->modes()}, kWantTangent,
                  [](const Evaluation& result, double* to) {
                    std::memcpy(to, result.tangent.data(), sizeof(double) * result.tangent.size());
                  });
}

// Rest positions and rows of all vertices of the mesh, in the order of their ids.
py::tuple whole_mesh(const PyModel& self) {
  const Model& model = *self.model;
  const Result<const VertexBlock*> interior = [&] {
    const py::gil_scoped_release unlocked;
    return model.interior();
  }();
  if (!interior) raise(interior.error());
  const auto r = static_cast<std::size_t>(model.modes());
  py::array_t<double> rest(shape_of({model.vertex_count(), 3}));
  py::array_t<double> rows(shape_of({3 * model.vertex_count(), r}));
  std::memset(rest.mutable_data(), 0, sizeof(double) * rest.size());
  std::memset(rows.mutable_data(), 0, sizeof(double) * rows.size());
  for (const VertexBlock* block : {&model.surface(), *interior})
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i) {
      const auto id = static_cast<std::size_t>(block->vertex_ids[i]);
      std::memcpy(rest.mutable_data() + 3 * id, block->rest[i].data(), 3 * sizeof(double));
      std::memcpy(rows.mutable_data() + 3 * id * r, block->rows.data() + 3 * i * r,
                  3 * r * sizeof(double));
    }
  return py::make_tuple(rest, rows);
}

py::array_t<VertexId> edges_of(const PyModel& self) {
  const std::vector<MeshEdge>& edges = self.model->edges();
  py::array_t<VertexId> made(shape_of({edges.size(), 3}));
  VertexId* out = made.mutable_data();
  for (const MeshEdge& edge : edges)
    for (const VertexId id : {edge.point, edge.a, edge.b}) *out++ = id;
  return made;
}

py::tuple default_load(const PyModel& self) {
  const DefaultLoad& load = self.model->default_load();
  py::array_t<VertexId> ids(static_cast<py::ssize_t>(load.vertices.size()), load.vertices.data());
  py::array_t<double> forces(shape_of({load.forces.size(), 3}));
  for (std::size_t i = 0; i < load.forces.size(); ++i)
    std::memcpy(forces.mutable_data() + 3 * i, load.forces[i].data(), 3 * sizeof(double));
  return py::make_tuple(ids, forces);
}

py::array_t<VertexId> select(const PyModel& self, const std::string& selector) {
  const std::vector<VertexId> ids = unwrap(vertices_of(selector, *self.model));
  return py::array_t<VertexId>(static_cast<py::ssize_t>(ids.size()), ids.data());
}

// U_v^T F summed over the vertices.
py::array_t<double> reduced_force(const PyModel& self, py::handle at, py::handle forces) {
  const std::vector<VertexId> ids = vertices_at(at, *self.model);
  const Doubles given = finite_numbers(forces, "force");
  if (given.ndim() == 1)
    return array_of<Eigen::Dynamic>(unwrap(
        reduce_load(*self.model, shared_by_area(ids, vector3(given, "force"), *self.model))));
  const std::vector<Eigen::Vector3d> each = points(given, "force");
  if (each.size() != ids.size())
    raise(usage_error("force: " + std::to_string(each.size()) + " forces for " +
                      std::to_string(ids.size()) + " vertices"));
  return array_of<Eigen::Dynamic>(unwrap(reduce_load(*self.model, {ids, each})));
}

py::bytes file_bytes(const PyModel& self) {
  if (!self.bytes.empty()) return py::bytes(self.bytes);
  const py::object file = py::module_::import("builtins").attr("open")(self.path, "rb");
  const py::bytes bytes = file.attr("read")();
  file.attr("close")();
  return bytes;
}

py::tuple pickled(const PyModel& self) {
  return py::make_tuple("tremolo.Model", kPickleVersion, self.path, py::bytes(self.bytes),
                        self.options.modes, self.options.linear, self.options.hull,
                        self.model->content_hash());
}

PyModelPointer unpickled(const py::tuple& state) {
  check_pickle(state, 8, "tremolo.Model", kPickleVersion);
  const ModelOptions options{state[4].cast<int>(), state[5].cast<bool>(), state[6].cast<bool>()};
  const auto path = state[2].cast<std::string>();
  PyModelPointer made = path.empty() ? load_model_of_bytes(state[3].cast<std::string>(), options)
                                     : load_model(path, options);
  if (made->model->content_hash() != state[7].cast<std::uint64_t>())
    raise(content_error(path + ": the model is not the one that was pickled: its values differ"));
  return made;
}

std::string describe(const PyModel& self) {
  const Model& model = *self.model;
  return "<tremolo.Model: " + std::to_string(model.modes()) + " coordinates, " +
         std::to_string(model.vertex_count()) + " vertices, " +
         std::to_string(model.tetrahedron_count()) + " tetrahedra>";
}

using PyModelClass = py::class_<PyModel, PyModelPointer>;

// Views of the model's memory.
template <class Get>
void view(PyModelClass& model, const char* name, const char* doc, const Get& get) {
  model.def_property_readonly(
      name, [get](py::object self) { return py::object(get(model_of(self), self)); }, doc);
}

void add_views(PyModelClass& c) {
  view(c, "Lambda", "Squares of the angular frequencies, (r,), (rad/s)^2, ascending. Read-only.",
       [](const Model& m, py::handle self) {
         return read_only_view(m.lambda().data(), {m.modes()}, self);
       });
  view(c, "cubic",
       "Unique entries of C, (r(r+1)(r+2)/6,), packed with i <= j <= k in colexicographic order: "
       "that of (i, j, k) is at k(k+1)(k+2)/6 + j(j+1)/2 + i. Empty for a linear model. Read-only.",
       [](const Model& m, py::handle self) {
         return read_only_view(m.cubic().data(), shape_of({m.cubic().size()}), self);
       });
  view(c, "quartic",
       "Unique entries of Q, (r(r+1)(r+2)(r+3)/24,), packed as `cubic`. Empty for a linear model. "
       "Read-only.",
       [](const Model& m, py::handle self) {
         return read_only_view(m.quartic().data(), shape_of({m.quartic().size()}), self);
       });
  view(c, "U",
       "Rows of the basis at the vertices of the boundary, (3 s, r), kg^-1/2: row 3 i + axis is "
       "that of vertex_ids[i]. Displacements are (U @ q).reshape(-1, 3), m. Read-only.",
       [](const Model& m, py::handle self) { return rows_view(m.surface().rows, self); });
  view(c, "vertices", "Rest positions of the boundary's vertices, (s, 3), m. Read-only.",
       [](const Model& m, py::handle self) { return places_view(m.surface().rest, self); });
  view(c, "vertex_ids", "Indices in the mesh of the boundary's vertices, (s,), int32. Read-only.",
       [](const Model& m, py::handle self) {
         return read_only_view(m.surface().vertex_ids.data(),
                               shape_of({m.surface().vertex_ids.size()}), self);
       });
  view(c, "triangles", "Triangles of the boundary, (t, 3), int32, into `vertices`. Read-only.",
       [](const Model& m, py::handle self) { return triangles_view(m.triangles(), self); });
  view(c, "drawn_U", "Rows of the drawn surface, (3 d, r), as `U`. Read-only.",
       [](const Model& m, py::handle self) { return rows_view(m.drawn().rows, self); });
  view(c, "drawn_vertices",
       "Rest positions of the drawn surface, (d, 3), m: the render surface if the model has one, "
       "else the boundary. Read-only.",
       [](const Model& m, py::handle self) { return places_view(m.drawn().rest, self); });
  view(c, "drawn_triangles", "Triangles of the drawn surface, (t, 3), int32. Read-only.",
       [](const Model& m, py::handle self) { return triangles_view(m.drawn().triangles, self); });
}

void add_values(PyModelClass& c) {
  c.def_property_readonly(
      "modes", [](const PyModel& self) { return self.model->modes(); },
      "Number of coordinates, r.");
  c.def_property_readonly(
      "frequencies",
      [](const PyModel& self) { return array_of<Eigen::Dynamic>(self.model->frequencies_hz()); },
      "sqrt(Lambda) / 2 pi, (r,), Hz.");
  c.def_property_readonly(
      "vertex_count", [](const PyModel& self) { return self.model->vertex_count(); },
      "Number of vertices of the mesh, n, edge points of quadratic elements included.");
  c.def_property_readonly(
      "tetrahedron_count", [](const PyModel& self) { return self.model->tetrahedron_count(); },
      "Number of tetrahedra of the mesh.");
  c.def_property_readonly(
      "linear", [](const PyModel& self) { return self.model->potential().linear(); },
      "True if the energy is 1/2 q.Lambda q alone.");
  c.def_property_readonly(
      "is_free", [](const PyModel& self) { return self.model->rigid_mode_count() > 0; },
      "True if the solid has no support: its bodies are free.");
  c.def_property_readonly(
      "explicit_step_limit", [](const PyModel& self) { return self.model->explicit_step_limit(); },
      "2 / omega of the highest coordinate, s: explicit methods are linearly stable below.");
  c.def_property_readonly("edges", &edges_of,
                          "Of quadratic elements: the vertex in the middle of an edge and the "
                          "edge's two ends, (e, 3), int32, if the file has the tetrahedra "
                          "(keep_elements=True); (0, 3) otherwise.");
  c.def_property_readonly(
      "default_load", &default_load,
      "The default load: indices of vertices, (k,), and a force on each, (k, 3), N. May be empty.");
  c.def_property_readonly(
      "path",
      [](const PyModel& self) -> py::object {
        if (self.path.empty()) return py::none();
        return py::str(self.path);
      },
      "Path of the basis file; None for a model in memory.");
  c.def_property_readonly(
      "content_hash", [](const PyModel& self) { return self.model->content_hash(); },
      "A hash of all values that affect motion, int.");
}

void add_functions(PyModelClass& c) {
  c.def("energy", &energy, py::arg("q"), py::arg("out") = py::none(),
        "V(q), J, of one q (r,), a float, or of many (n, r), an array (n,). out: float64 for the "
        "result. Other threads run meanwhile.");
  c.def("force", &force, py::arg("q"), py::arg("out") = py::none(),
        "R(q) = grad V(q) of one q (r,) or of many (n, r), in the shape of q; J per unit of q, "
        "with the sign of the gradient. out: float64 for the result. Other threads run meanwhile.");
  c.def("tangent", &tangent, py::arg("q"), py::arg("out") = py::none(),
        "K(q) = grad R(q), (r, r), or (n, r, r) for many q (n, r); symmetric, (rad/s)^2. out: "
        "float64 for the result. Other threads run meanwhile.");
  c.def("cubic_dense", &dense_cubic, "C, (r, r, r), symmetric: V has the term C_ijk q_i q_j q_k.");
  c.def("quartic_dense", &dense_quartic,
        "Q, (r, r, r, r), symmetric: V has the term Q_ijkl q_i q_j q_k q_l.");
  c.def("whole_mesh", &whole_mesh,
        "(rest, U) of all n vertices of the mesh in their order: rest (n, 3), m, and U (3 n, r), "
        "kg^-1/2, zero for fixed vertices. Reads the vertices inside from the file; new arrays.");
  c.def("select", &select, py::arg("selector"),
        "Indices of the vertices on the boundary that a selector such as \"x<0.1\" chooses, "
        "ascending, int32.");
  c.def("reduced_force", &reduced_force, py::arg("at"), py::arg("force"),
        "U^T F, (r,). at: an index, an array of indices or a selector. force: one force (3,), N, "
        "shared by the vertices, or one for each, (k, 3).");
  c.def("file_bytes", &file_bytes, "The basis file, bytes.");
  c.def("__reduce__", [](const PyModel& self) { return reduced("model_of", pickled(self)); });
  c.def("__copy__", [](py::object self) { return self; });
  c.def("__deepcopy__", [](py::object self, const py::object&) { return self; });
  c.def("__repr__", &describe);
}

}  // namespace

void add_model(py::module_& module) {
  PyModelClass c(module, "Model",
                 "One precomputed solid: immutable, shared by any number of bodies and threads. "
                 "tremolo.load and tremolo.precompute make it. A pickle has the path of its file, "
                 "or the file itself if it is in memory.");
  add_views(c);
  add_values(c);
  add_functions(c);
  add_curves(c);
  refuse_construction(c, "tremolo.load and tremolo.precompute make one");
  module.def("_model_of", from_pickle(&unpickled), py::arg("state"),
             "A model of its pickle's state.");
  module.def(
      "load",
      [](py::handle path, int modes, bool linear, bool hull) {
        return load_model(path_text(path), ModelOptions{modes, linear, hull});
      },
      py::arg("path"), py::kw_only(), py::arg("modes") = 0, py::arg("linear") = false,
      py::arg("hull") = false,
      "Loads a basis file. modes: number of leading coordinates that are kept; 0 keeps all. "
      "linear: V = 1/2 q.Lambda q, without the cubic and quartic terms. hull: the boundary is "
      "drawn, also where the file has a render surface.");
  module.def(
      "load_bytes",
      [](const py::bytes& bytes, int modes, bool linear, bool hull) {
        return load_model_of_bytes(bytes, ModelOptions{modes, linear, hull});
      },
      py::arg("bytes"), py::kw_only(), py::arg("modes") = 0, py::arg("linear") = false,
      py::arg("hull") = false, "The same for a basis file in memory.");
}

}  // namespace tremolo::python
