#include "precompute/assembly.h"

namespace tremolo {

double total_mass(const Solid& solid) {
  double volume = 0;
  for (const StrainSample& sample : solid.samples) volume += sample.weight;
  return solid.material.density * volume;
}

}  // namespace tremolo
