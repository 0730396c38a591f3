// Between C++ and Python: errors become exceptions, arrays of numpy become vectors and views.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "runtime/integrator.h"
#include "runtime/math/pose.h"

namespace tremolo::python {

namespace py = pybind11;

// Raises the class of tremolo.errors that belongs to the kind, with the engine's words.
[[noreturn]] void raise(const Error& error);
// Raises TypeError, for an argument of a type that cannot be converted.
[[noreturn]] void raise_type(const std::string& message);

inline void check(const Status& status) {
  if (!status) raise(status.error());
}
template <class T>
T unwrap(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(*result);
}

using Doubles = py::array_t<double, py::array::c_style>;
using Shape = std::vector<py::ssize_t>;

// str(object)
std::string text_of(py::handle object);
// Damping ratios as a text, a number or a list of numbers. Raises.
DampingRatios damping_ratios_of(py::handle object);
// Raises ContentError unless the state of a pickle begins with this name and version.
void check_pickle(const py::tuple& state, std::size_t size, const char* name, int version);

// Raises ContentError: a value of a pickle is not one that a pickle has.
[[noreturn]] void raise_damaged_pickle();
// One of `count` choices by its number in a pickle.
template <class Choice>
Choice choice_of(py::handle number, int count) {
  const int value = number.cast<int>();
  if (value < 0 || value >= count) raise_damaged_pickle();
  return static_cast<Choice>(value);
}
// make(state), whose errors for values of a wrong type are those of a damaged pickle.
template <class Make>
auto from_pickle(const Make& make) {
  return [make](const py::tuple& state) {
    try {
      return make(state);
    } catch (const py::cast_error&) {
      raise_damaged_pickle();
    } catch (py::error_already_set& error) {
      if (error.matches(PyExc_IndexError) || error.matches(PyExc_TypeError)) raise_damaged_pickle();
      throw;
    }
  };
}

// Refuses TYPE.__new__(TYPE) and TYPE(): an object without its contents. how: the call that makes
// one. The class is not one that Python constructs.
void refuse_construction(py::object type, const char* how);
// The pickle of an object is a call of the module's function `maker` with its state.
py::tuple reduced(const char* maker, const py::tuple& state);

// "(3, 4)"
std::string shape_text(const py::array& array);

// An array of numbers as float64 in C order, without a copy where it is one already. name: of the
// argument, for messages. Raises TypeError for anything that is not real numbers.
Doubles numbers(py::handle object, const char* name);
// The same with finite values.
Doubles finite_numbers(py::handle object, const char* name);
// One vector of `size` finite numbers.
Eigen::VectorXd vector(py::handle object, Eigen::Index size, const char* name);
Eigen::Vector3d vector3(py::handle object, const char* name);
// n x 3 finite numbers.
std::vector<Eigen::Vector3d> points(py::handle object, const char* name);
// Integers of any shape that fit a VertexId; TypeError for numbers that are not integers.
// Numbers that no VertexId is raise `kind`.
std::vector<VertexId> vertex_ids(py::handle object, const char* name,
                                 ErrorKind kind = ErrorKind::kContent);
// m x 4 integers.
std::vector<Tetrahedron> tetrahedra(py::handle object, const char* name);

// Checks an array that results are written into: its type, C order, its shape, that it can be
// written. Raises TypeError or ValueError otherwise.
template <class Number>
void check_out(const py::array& out, std::span<const py::ssize_t> shape);

// A view without a copy that cannot be written and keeps `owner` alive.
template <class Number>
py::array read_only_view(const Number* data, const Shape& shape, py::handle owner) {
  py::array_t<Number> view(shape, data, owner);
  py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return view;
}

template <int kRows>
py::array_t<double> array_of(const Eigen::Matrix<double, kRows, 1>& values) {
  return py::array_t<double>(values.size(), values.data());
}
// (position, rotation), the rotation as w, x, y, z.
py::tuple tuple_of(const Pose& pose);
// position: 3 numbers, m. rotation: w, x, y, z.
Pose pose_of(py::handle position, py::handle rotation);

// The text of a path: str, bytes or os.PathLike, in the file system's encoding. TypeError for
// anything else, ValueError for a path with a zero in it, UsageError for an empty one.
std::string path_text(py::handle path);

// Runs `action(k)` for k in [0, count) without the interpreter's lock, and looks for Ctrl-C about
// ten times a second. action returns false to stop. Returns how many were done; an exception of
// Python, such as KeyboardInterrupt, is raised between two of them.
template <class Action>
std::int64_t run_unlocked(std::int64_t count, const Action& action);

// Marks a body or a world as used by one call; a second one at the same time is refused.
class InUse {
 public:
  InUse(std::atomic<bool>& used, const char* thing) : used_(used) {
    if (used_.exchange(true, std::memory_order_acquire)) refuse(thing);
  }
  ~InUse() { used_.store(false, std::memory_order_release); }
  InUse(const InUse&) = delete;
  InUse& operator=(const InUse&) = delete;

 private:
  [[noreturn]] static void refuse(const char* thing);
  std::atomic<bool>& used_;
};

template <class Action>
std::int64_t run_unlocked(std::int64_t count, const Action& action) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kShort = std::chrono::milliseconds(5);
  constexpr auto kLong = std::chrono::milliseconds(100);
  std::int64_t done = 0;
  if (count <= 1) {
    const py::gil_scoped_release unlocked;
    while (done < count && action(done)) ++done;
    return done;
  }
  std::int64_t block = 1;
  bool goes_on = true;
  while (goes_on && done < count) {
    {
      const py::gil_scoped_release unlocked;
      const Clock::time_point begin = Clock::now();
      Clock::time_point now = begin;
      while (goes_on && done < count && now - begin < kLong) {
        const Clock::time_point before = now;
        for (std::int64_t k = 0; goes_on && k < block && done < count; ++k) {
          goes_on = action(done);
          if (goes_on) ++done;
        }
        now = Clock::now();
        if (now - before < kShort) block *= 2;
        if (now - before > 4 * kShort && block > 1) block /= 2;
      }
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  return done;
}

// A class of the module each.
void add_model(py::module_& module);
void add_body(py::module_& module);
void add_world(py::module_& module);
void add_recorder(py::module_& module);
void add_matrices(py::module_& module);

}  // namespace tremolo::python
