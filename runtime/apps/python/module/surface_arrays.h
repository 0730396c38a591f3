// Positions of a surface's vertices as an array of numpy.
#pragma once

#include <span>

#include "runtime/apps/python/module/convert.h"

namespace tremolo::python {

// The array that results are written into: `out`, checked, or without one a new one of type dtype.
py::array places_array(std::size_t vertices, py::handle out, py::handle dtype);

// out: an array with 3 numbers a vertex, whose type decides between write32(span<float>) and
// write64(span<double>), which return a Status and run without the interpreter's lock.
template <class Write32, class Write64>
py::array write_places(std::size_t vertices, py::handle out, py::handle dtype,
                       const Write32& write32, const Write64& write64) {
  py::array target = places_array(vertices, out, dtype);
  void* data = target.mutable_data();
  const bool is_float = target.itemsize() == sizeof(float);
  const Status written = [&]() -> Status {
    const py::gil_scoped_release unlocked;
    if (is_float) return write32(std::span(static_cast<float*>(data), 3 * vertices));
    return write64(std::span(static_cast<double*>(data), 3 * vertices));
  }();
  check(written);
  return target;
}

}  // namespace tremolo::python
