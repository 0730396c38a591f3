#include <cmath>
#include <limits>

#include "runtime/apps/python/module/surface_arrays.h"

namespace tremolo::python {
namespace {

const char* class_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kSystem:
      return "FileError";
    case ErrorKind::kUsage:
      return "UsageError";
    case ErrorKind::kContent:
      return "ContentError";
    case ErrorKind::kSolver:
      return "SolverError";
    case ErrorKind::kBound:
      return "BoundError";
    case ErrorKind::kCriterion:
      return "CriterionError";
  }
  return "Error";
}

std::string type_name(py::handle object) {
  return Py_TYPE(object.ptr())->tp_name;
}

// An array of numpy, without a copy where it is one. Raises TypeError where numpy makes none.
py::array as_array(py::handle object, const char* name) {
  if (py::isinstance<py::array>(object)) return py::reinterpret_borrow<py::array>(object);
  if (PyUnicode_Check(object.ptr()) || PyBytes_Check(object.ptr()) || object.is_none())
    raise_type(std::string(name) + ": expected numbers, found " + type_name(object));
  py::array made = py::array::ensure(object);
  if (!made) {
    PyErr_Clear();
    raise_type(std::string(name) + ": expected an array of numbers, found " + type_name(object));
  }
  return made;
}

Error wrong_shape(const char* name, const std::string& expected, const py::array& found) {
  return usage_error(std::string(name) + ": expected the shape " + expected + ", found " +
                     shape_text(found));
}

}  // namespace

void raise(const Error& error) {
  const py::object type = py::module_::import("tremolo.errors").attr(class_of(error.kind));
  PyErr_SetObject(type.ptr(), type(error.message).ptr());
  throw py::error_already_set();
}

void raise_type(const std::string& message) {
  throw py::type_error(message);
}

std::string text_of(py::handle object) {
  return py::str(object).cast<std::string>();
}

DampingRatios damping_ratios_of(py::handle object) {
  const bool one = py::isinstance<py::str>(object) || !py::isinstance<py::sequence>(object);
  if (one) return unwrap(parse_damping(text_of(object)));
  std::string text;
  for (const py::handle ratio : object) text += (text.empty() ? "" : ",") + text_of(ratio);
  return unwrap(parse_damping(text));
}

void check_pickle(const py::tuple& state, std::size_t size, const char* name, int version) {
  const std::string expected = std::string(name) + " of version " + std::to_string(version);
  if (state.size() < 2 || text_of(state[0]) != name)
    raise(content_error("the pickle is not one of a " + expected));
  if (text_of(state[1]) != std::to_string(version) || state.size() != size)
    raise(content_error("the pickle is one of a " + std::string(name) + " of version " +
                        text_of(state[1]) + ", not " + std::to_string(version) +
                        ": make it again with this version of Tremolo"));
}

void raise_damaged_pickle() {
  raise(content_error("the pickle is damaged: a value in it is not one that it can have"));
}

void refuse_construction(py::object type, const char* how) {
  const std::string message = text_of(type.attr("__name__")) + " has no constructor: " + how;
  const py::cpp_function refuse(
      [message](const py::args&, const py::kwargs&) -> py::object { raise_type(message); });
  type.attr("__new__") = py::module_::import("builtins").attr("staticmethod")(refuse);
}

py::tuple reduced(const char* maker, const py::tuple& state) {
  return py::make_tuple(py::module_::import("tremolo.pickles").attr(maker), py::make_tuple(state));
}

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

Doubles numbers(py::handle object, const char* name) {
  const py::array given = as_array(object, name);
  const char kind = given.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b')
    raise_type(std::string(name) + ": expected real numbers, found an array of type " +
               text_of(given.dtype()));
  Doubles made = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!made) throw py::error_already_set();
  return made;
}

Doubles finite_numbers(py::handle object, const char* name) {
  Doubles made = numbers(object, name);
  const double* data = made.data();
  for (py::ssize_t i = 0; i < made.size(); ++i)
    if (!std::isfinite(data[i]))
      raise(content_error(std::string(name) + ": number " + std::to_string(i) + " of " +
                          std::to_string(made.size()) + " is not finite"));
  return made;
}

Eigen::VectorXd vector(py::handle object, Eigen::Index size, const char* name) {
  const Doubles given = numbers(object, name);
  if (given.ndim() != 1 || given.shape(0) != size)
    raise(wrong_shape(name, "(" + std::to_string(size) + ",)", given));
  finite_numbers(given, name);
  return Eigen::Map<const Eigen::VectorXd>(given.data(), size);
}

Eigen::Vector3d vector3(py::handle object, const char* name) {
  return vector(object, 3, name);
}

std::vector<Eigen::Vector3d> points(py::handle object, const char* name) {
  const Doubles given = finite_numbers(object, name);
  if (given.ndim() != 2 || given.shape(1) != 3) raise(wrong_shape(name, "(n, 3)", given));
  std::vector<Eigen::Vector3d> made(static_cast<std::size_t>(given.shape(0)));
  for (std::size_t i = 0; i < made.size(); ++i) made[i] = Eigen::Vector3d(given.data() + 3 * i);
  return made;
}

std::vector<VertexId> vertex_ids(py::handle object, const char* name, ErrorKind kind) {
  const py::array given = as_array(object, name);
  const char type = given.dtype().kind();
  if (given.size() == 0) return {};
  if (type != 'i' && type != 'u')
    raise_type(std::string(name) + ": expected integers, found an array of type " +
               text_of(given.dtype()));
  const auto whole =
      py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!whole) throw py::error_already_set();
  std::vector<VertexId> made(static_cast<std::size_t>(whole.size()));
  for (std::size_t i = 0; i < made.size(); ++i) {
    const std::int64_t id = whole.data()[i];
    if (id < 0 || id > std::numeric_limits<VertexId>::max())
      raise(Error{kind,
                  std::string(name) + ": " + std::to_string(id) + " is not the index of a vertex"});
    made[i] = static_cast<VertexId>(id);
  }
  return made;
}

std::vector<Tetrahedron> tetrahedra(py::handle object, const char* name) {
  const py::array given = as_array(object, name);
  if (given.ndim() != 2 || given.shape(1) != 4) raise(wrong_shape(name, "(m, 4)", given));
  const std::vector<VertexId> ids = vertex_ids(given, name);
  std::vector<Tetrahedron> made(ids.size() / 4);
  for (std::size_t t = 0; t < made.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i) made[t][i] = ids[4 * t + i];
  return made;
}

template <class Number>
void check_out(const py::array& out, std::span<const py::ssize_t> shape) {
  // Read from the descriptor: comparing types takes as long as a small result.
  const auto* type = py::detail::array_descriptor_proxy(py::detail::array_proxy(out.ptr())->descr);
  if (type->type != (sizeof(Number) == 4 ? 'f' : 'd') || type->byteorder != '=')
    raise_type("out: expected an array of type " + text_of(py::dtype::of<Number>()) +
               ", found one of type " + text_of(out.dtype()));
  if (!std::equal(shape.begin(), shape.end(), out.shape(), out.shape() + out.ndim())) {
    std::string text = "(";
    for (std::size_t i = 0; i < shape.size(); ++i)
      text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
    raise(wrong_shape("out", text + (shape.size() == 1 ? ",)" : ")"), out));
  }
  if (!(out.flags() & py::array::c_style))
    raise(usage_error("out: expected an array in C order: numpy.ascontiguousarray makes one"));
  if (!out.writeable()) raise(usage_error("out: the array is read-only"));
  constexpr auto kAligned = py::detail::npy_api::NPY_ARRAY_ALIGNED_;
  if (!(out.flags() & kAligned)) raise(usage_error("out: the array is not aligned in memory"));
}
template void check_out<double>(const py::array& out, std::span<const py::ssize_t> shape);
template void check_out<float>(const py::array& out, std::span<const py::ssize_t> shape);

py::array places_array(std::size_t vertices, py::handle out, py::handle dtype) {
  const std::array<py::ssize_t, 2> shape = {static_cast<py::ssize_t>(vertices), 3};
  if (out.is_none()) {
    const py::dtype type = py::dtype::from_args(py::reinterpret_borrow<py::object>(dtype));
    if (type.equal(py::dtype::of<double>())) return py::array_t<double>(shape);
    if (type.equal(py::dtype::of<float>())) return py::array_t<float>(shape);
    raise_type("dtype: expected float64 or float32, found " + text_of(type));
  }
  if (!py::isinstance<py::array>(out)) raise_type("out: expected an array of numpy");
  auto target = py::reinterpret_borrow<py::array>(out);
  if (target.itemsize() == sizeof(float))
    check_out<float>(target, shape);
  else
    check_out<double>(target, shape);
  return target;
}

py::tuple tuple_of(const Pose& pose) {
  const Eigen::Vector4d rotation(pose.rotation.w(), pose.rotation.x(), pose.rotation.y(),
                                 pose.rotation.z());
  return py::make_tuple(array_of<3>(pose.position), array_of<4>(rotation));
}

Pose pose_of(py::handle position, py::handle rotation) {
  Pose pose;
  pose.position = vector3(position, "position");
  const Eigen::VectorXd turn = vector(rotation, 4, "rotation");
  pose.rotation = Eigen::Quaterniond(turn[0], turn[1], turn[2], turn[3]);
  return pose;
}

std::string path_text(py::handle path) {
  PyObject* bytes = nullptr;
  if (PyUnicode_FSConverter(path.ptr(), &bytes) == 0) throw py::error_already_set();
  std::string text(py::reinterpret_steal<py::bytes>(bytes));
  if (text.empty()) raise(usage_error("the path is empty: name a file"));
  return text;
}

void InUse::refuse(const char* thing) {
  raise(usage_error(std::string("the ") + thing +
                    " is used by another call at this time: give each thread one of its own, as "
                    "copy.copy makes"));
}

}  // namespace tremolo::python
