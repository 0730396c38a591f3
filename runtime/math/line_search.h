// Chooses the length of a move of Newton's method.
#pragma once

#include <algorithm>
#include <cmath>

namespace tremolo {

// Values at a length along the move.
struct LineTrial {
  double size = 0.0;   // size of the residual
  double slope = 0.0;  // slope of the function that falls along the move
};

// Searches along the move. go(length) evaluates there and returns a LineTrial; the search ends at
// the length of its last call and returns that. start: at length 0, with a slope below zero for a
// move of descent.
//
// The whole move is taken if the residual falls or the slope is not yet positive. Otherwise the
// slope guides the search for the minimum in between: the residual cannot, because friction changes
// sign.
template <class Go>
LineTrial search_line(const Go& go, const LineTrial& start) {
  constexpr int kMost = 14;
  constexpr double kFlat = 0.3, kFalls = 0.1, kGrows = 4.0;
  LineTrial trial = go(1.0);
  if (trial.size < kFalls * start.size) return trial;
  // A slope that continues to fall while the residual grows leads away from the solution.
  const auto leads_away = [&start](const LineTrial& at) {
    return !std::isfinite(at.size) || (at.size > kGrows * start.size && at.slope < start.slope);
  };
  if (trial.slope <= -kFlat * start.slope && !leads_away(trial)) return trial;
  double low = 0.0, high = 1.0, low_slope = start.slope, high_slope = trial.slope;
  for (int k = 0; k < kMost; ++k) {
    double share = std::isfinite(high_slope) ? low_slope / (low_slope - high_slope) : 0.5;
    share = std::clamp(share, 0.05, 0.95);
    if (k % 3 == 2 || high_slope < 0.0) share = 0.5;
    const double length = low + share * (high - low);
    trial = go(length);
    const bool away = leads_away(trial);
    if (!away && std::abs(trial.slope) <= -kFlat * start.slope) break;
    if (trial.slope < 0.0 && !away) {
      low = length;
      low_slope = trial.slope;
    } else {
      high = length;
      high_slope = trial.slope;
    }
  }
  return trial;
}

// Makes a move of Newton's method and searches along it. find_move(heavier) makes the move with
// inertia increased by the factor heavier and returns the slope. The inertia is raised until the
// move is one of descent and its end is not far off. heavier: receives the factor for the next
// move. small: the residual is near rounding. False: no move is one of descent; the last call was
// go(0), if any.
template <class FindMove, class Go>
bool newton_move(const FindMove& find_move, const Go& go, double size, bool small, double& heavier,
                 LineTrial& reached) {
  constexpr double kHeaviest = 1e8, kFarOff = 10.0;
  for (; heavier <= kHeaviest; heavier = std::max(1.0, 10.0 * heavier)) {
    const double slope = find_move(heavier);
    if (!(slope < 0.0)) {
      if (small) return false;
      continue;
    }
    reached = search_line(go, {size, slope});
    if (reached.size <= kFarOff * size || small) {
      heavier = heavier > 1.0 ? 0.1 * heavier : 0.0;
      return true;
    }
    go(0.0);
  }
  heavier = 0.0;
  return false;
}

}  // namespace tremolo
