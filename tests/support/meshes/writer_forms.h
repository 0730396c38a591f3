// One bar with two regions and a named set, in the form of every program whose tetrahedra are read.
// Written from the forms of Gmsh 4.8, meshio 5.0 and the formats' manuals.
#pragma once

#include "tests/support/meshes/forms/deck_forms.h"
#include "tests/support/meshes/forms/msh_forms.h"
#include "tests/support/meshes/forms/vtk_forms.h"

namespace tremolo::testing {

inline std::vector<WriterForm> all_writer_forms() {
  std::vector<WriterForm> forms = msh_forms();
  for (const auto& more : {vtk_forms(), deck_forms()})
    forms.insert(forms.end(), more.begin(), more.end());
  return forms;
}

}  // namespace tremolo::testing
