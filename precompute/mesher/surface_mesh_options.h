// How a surface is to be cut.
#pragma once

namespace tremolo {

// size: longest wanted edge, m; 0: by the count. tets: wanted number of tetrahedra; 0: 10 000 or as
// many as thin walls ask for. error: wanted distance between the surfaces, m; 0: 0.3 % of the
// diagonal. thicken: m; above 0 the surface is taken for a sheet of that thickness. fill_holes:
// close holes however large they are. keep_crumbs: keep parts far smaller than the largest.
struct SurfaceMeshOptions {
  double size = 0;
  int tets = 0;
  double error = 0;
  double thicken = 0;
  bool fill_holes = false;
  bool keep_crumbs = false;
};

}  // namespace tremolo
