// Means of a long series over windows of equal length.
#pragma once

#include <cstdint>
#include <vector>

namespace tremolo::reproduce {

// A series that comes value by value, cut into windows of `length` values each, from the first on,
// and, because the end need not fall on a window's, its last `length` values once more. The whole
// has `count` values; an unfinished window at the end counts in `last` only. Plain data: what is
// written here and read back goes on as if it had never stopped.
struct Windows {
  std::int64_t length = 1;
  std::int64_t count = 1;
  std::int64_t taken = 0;
  double sum = 0.0;           // of the window under way
  std::vector<double> means;  // of the finished ones
  std::vector<double> first;  // the values of the first window
  std::vector<double> last;   // the last `length` values of the whole

  void take(double value);
};

}  // namespace tremolo::reproduce
