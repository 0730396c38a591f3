// The motions of some points of curves as loops of a page's film, one period each.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "common/result.h"
#include "runtime/apps/tremolo/response/curve_report.h"

namespace tremolo {

struct OrbitFilm {
  // The `film` of a page (runtime/io/page/document.h) with `loops`: from, to (s) and label of each.
  // Null if the surface is too large for a page.
  nlohmann::ordered_json film;
  // The loop of the nearest chosen point, for each curve and point, then for each bifurcation.
  std::vector<std::vector<int>> loop_of_point, loop_of_bifurcation;
};

// Chooses some points of each curve, evenly along it, and all bifurcations. The first loop is the
// motion with the largest amplitude. Errors: page_motion's.
Result<OrbitFilm> orbit_film(const std::vector<CurveResult>& results, const CurveContext& context);

}  // namespace tremolo
