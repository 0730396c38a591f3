// The class tremolo.OwnBody.
#pragma once

#include "runtime/apps/python/module/convert.h"

namespace tremolo::python {

void add_own(py::module_& module);

}  // namespace tremolo::python
