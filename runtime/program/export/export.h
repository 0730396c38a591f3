// `tremolo export`: a model in the formats of others.
#pragma once

#include <string>

namespace tremolo {

// Paths; empty: not requested.
struct ExportOptions {
  std::string model;
  std::string cub;  // VegaFEM's polynomials of the reduced forces
  std::string u;    // VegaFEM's basis: a row a dof of all the mesh's vertices, in the mesh's order
  std::string vtu;  // the modes on the surface, for ParaView and meshio
  std::string light;     // a basis file without the vertices inside (formats/basis/light_basis.h)
  std::string rescaled;  // a basis file of the material that `rescale` gives (run/rescale.h)
  std::string rescale;

  bool any() const {
    return !cub.empty() || !u.empty() || !vtu.empty() || !light.empty() || !rescaled.empty();
  }
};

// An imported model gives its original .cub and .U; another model gives its numbers, with zero rows
// for fixed vertices. Returns the exit code; errors are printed.
int export_command(const ExportOptions& options);

}  // namespace tremolo
