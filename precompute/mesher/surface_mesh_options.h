// Options for meshing a surface.
#pragma once

namespace tremolo {

struct SurfaceMeshOptions {
  double size = 0;           // longest edge requested, m; 0: by the count
  int tets = 0;              // requested number of tetrahedra; 0: 10 000, or more for thin walls
  double error = 0;          // requested distance between the surfaces, m; 0: 0.3 % of the diagonal
  double thicken = 0;        // m; above 0 the surface is a sheet of that thickness
  bool fill_holes = false;   // close holes of any size
  bool keep_crumbs = false;  // keep parts far smaller than the largest
};

}  // namespace tremolo
