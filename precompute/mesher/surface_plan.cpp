#include "precompute/mesher/surface_plan.h"

#include <algorithm>
#include <cmath>

#include "common/text.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

constexpr double kError = 0.003;  // the default
constexpr double kDefaultTets = 10'000;
constexpr double kMostTets = 4 * kDefaultTets;  // where walls are thin
constexpr std::size_t kWallSamples = 6'000;
// Thin walls that are a smaller share of the surface do not set the finest size.
constexpr double kRareWalls = 0.03;

// Walls thinner than the finest size by these factors: that are likely to be lost, and that are
// refused at once. Cut with edges of three times their thickness, walls still bend; beyond, the
// angles are bad.
constexpr double kThin = 1.6, kFarTooThin = 3;
// The share of such walls that matters.
constexpr double kThinShare = 0.1;

// The thickness below which this share of the walls is.
double thickness_quantile(const std::vector<WallSample>& walls, double share) {
  std::vector<double> values;
  for (const WallSample& wall : walls) values.push_back(wall.thickness);
  if (values.empty()) return 0.0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The largest size with which walls of at least that size are cut into no more than `most`.
double fine_enough(const MeshPlan& plan, double most) {
  double low = 0.02 * plan.coarse, high = plan.coarse;
  if (estimated_count(plan.walls, plan.volume, plan.coarse, low) <= most) return low;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (estimated_count(plan.walls, plan.volume, plan.coarse, middle) > most ? low : high) = middle;
  }
  return high;
}

double thinner_share(const std::vector<WallSample>& walls, double bound) {
  std::size_t count = 0;
  for (const WallSample& wall : walls) count += wall.thickness < bound;
  return walls.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(walls.size());
}

}  // namespace

double estimated_count(const MeshPlan& plan) {
  return estimated_count(plan.walls, plan.volume, plan.coarse, plan.fine);
}

double median_thickness(const MeshPlan& plan) {
  return thickness_quantile(plan.walls, 0.5);
}

bool has_thin_walls(const MeshPlan& plan) {
  return thinner_share(plan.walls, plan.fine / kThin) > kThinShare;
}

Result<MeshPlan> make_plan(const SurfaceSolid& solid, const SurfaceMeshOptions& options,
                           const Scaling& scaling) {
  MeshPlan plan;
  plan.volume = volume(solid);
  if (solid.half_thickness > 0) {
    // A sheet has the requested thickness.
    for (const SurfacePoint& at : spread_points(solid.surface, kWallSamples))
      plan.walls.push_back({at.point, 2.0 * solid.half_thickness, 1.0});
  } else {
    const Inside inside =
        solid.closed ? Inside()
                     : Inside([&solid](const Eigen::Vector3d& x) { return solid.inside(x); });
    plan.walls = wall_samples(solid.surface, solid.tree, inside, kWallSamples);
  }
  const double wanted = options.tets > 0 ? options.tets : kDefaultTets;
  const double most = options.tets > 0 ? 1.5 * options.tets : kMostTets;
  if (options.size > 0) {
    plan.coarse = options.size / scaling.diagonal;
    plan.fine = 0.25 * plan.coarse;
  } else {
    plan.coarse = size_for_count(plan.volume, wanted);
    const double rare = std::min(plan.coarse, thickness_quantile(plan.walls, kRareWalls));
    plan.fine = std::max(rare, fine_enough(plan, most));
  }
  plan.error_asked = options.error > 0;
  plan.error = options.error > 0 ? options.error / scaling.diagonal
                                 : std::clamp(0.05 * plan.coarse, kError, 0.1);
  if (options.size > 0 || options.tets > 0) return plan;
  if (thinner_share(plan.walls, plan.fine / kFarTooThin) > kThinShare) {
    const double thin = median_thickness(plan);
    return content_error(
        text("its walls are about %.3g m thick at a size of %.3g m: about %.1g tetrahedra would be "
             "needed "
             "for good ones. Make the walls thicker, or ask for that many by --tets or for their "
             "size by "
             "--size",
             thin * scaling.diagonal, scaling.diagonal,
             estimated_count(plan.walls, plan.volume, plan.coarse, thin)));
  }
  return plan;
}

}  // namespace tremolo
