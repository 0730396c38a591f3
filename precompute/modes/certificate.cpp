#include "precompute/modes/certificate.h"

#include <cmath>
#include <limits>
#include <vector>

#include "precompute/modes/mode_clusters.h"

namespace tremolo {

InertiaCertificate certify(ShiftedSolver& solver, const Modes& modes, int rigid_count) {
  std::vector<double> values(modes.squared_frequencies.begin(), modes.squared_frequencies.end());
  if (!modes.left_out.empty())
    values.insert(values.end(), modes.left_out.begin(), modes.left_out.end());
  else if (modes.next_squared_frequency > 0)
    values.push_back(modes.next_squared_frequency);
  // The bound lies between the last two values that differ by more than rounding, since a cluster
  // at the cut may continue beyond what was computed.
  const Nearness near = nearness(values.front(), modes.cancellation);
  std::size_t below = values.size() - 1;
  while (below > 0 && near(values[below - 1], values[below])) --below;
  InertiaCertificate certificate;
  if (below == 0) {  // all values equal, or only one mode exists
    certificate.bound = 0.5 * values.front();
    certificate.expected = rigid_count;
  } else {
    certificate.bound = 0.5 * (values[below - 1] + values[below]);
    certificate.expected = static_cast<int>(below) + rigid_count;
  }
  // The inertia is that of a matrix perturbed by growth times rounding, relative to its diagonal;
  // this perturbation must not move an eigenvalue across the bound.
  const double room = std::abs(values[below] - certificate.bound);
  const double unit = std::numeric_limits<double>::epsilon() * values.front() / modes.cancellation;
  const InertiaCount count =
      solver.count_negative(modes.shift, certificate.bound, 0.5 * room / unit);
  certificate.counted = count.negative;
  certificate.solver = count.package;
  return certificate;
}

}  // namespace tremolo
