// The module _tremolo: a thin face on the engine, which the package `tremolo` presents.
#include "runtime/apps/python/module/nodal_handle.h"
#include "runtime/apps/python/module/own_class.h"

namespace tremolo::python {
namespace {

py::list names_of_integrators() {
  py::list names;
  for (const std::string_view name : integrator_names()) names.append(py::str(name));
  return names;
}

}  // namespace

PYBIND11_MODULE(_tremolo, module) {
  module.doc() = "Deformable solids in reduced coordinates: the engine of the package `tremolo`.";
  module.attr("__version__") = TREMOLO_VERSION;
  module.def("integrators", &names_of_integrators,
             "The names of the integration methods, a list of str.");
  add_model(module);
  add_body(module);
  add_nodal(module);
  add_world(module);
  add_nodal_scene(module);
  add_recorder(module);
  add_matrices(module);
  add_own(module);
}

}  // namespace tremolo::python
