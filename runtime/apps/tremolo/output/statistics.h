// A few numbers about a list of numbers.
#pragma once

#include <vector>

namespace tremolo {

// Not a number for an empty list.
double mean(const std::vector<double>& values);

// An even count has the geometric mean of the middle two, which suits ratios; the lower one of them
// where that is not positive or not finite. Not a number for an empty list.
double median(std::vector<double> values);

// mean; scatter: the standard deviation of the values (n - 1). slope: of the least-squares line
// over positions 0, spacing, 2 spacing ...; slope_error: its standard error; explained: the part of
// the squared scatter that is on the line, 0 to 1. Not a number where there are too few values (2
// for a scatter and a slope, 3 for the rest).
struct Fit {
  double mean = 0.0;
  double scatter = 0.0;
  double slope = 0.0;
  double slope_error = 0.0;
  double explained = 0.0;
};
Fit fit_line(const std::vector<double>& values, double spacing);

}  // namespace tremolo
