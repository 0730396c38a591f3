#include "precompute/fem/assembly.h"

#include <numeric>

namespace tremolo {

double total_mass(const Solid& solid) {
  std::vector<double> volumes(solid.densities.size(), 0.0);
  for (std::size_t e = 0; e < solid.elements.size(); ++e)
    volumes[solid.material(e)] += solid.elements[e].volume;
  double mass = 0;
  for (std::size_t i = 0; i < volumes.size(); ++i) mass += solid.densities[i] * volumes[i];
  return std::accumulate(solid.point_mass.begin(), solid.point_mass.end(), mass);
}

}  // namespace tremolo
