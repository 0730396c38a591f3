#include "tests/lab/reproduce/windows.h"

namespace tremolo::reproduce {

void Windows::take(double value) {
  if (taken < length) first.push_back(value);
  if (taken >= count - length) last.push_back(value);
  sum += value;
  if (++taken % length != 0) return;
  means.push_back(sum / static_cast<double>(length));
  sum = 0.0;
}

}  // namespace tremolo::reproduce
