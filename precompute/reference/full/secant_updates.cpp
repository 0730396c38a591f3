#include "precompute/reference/full/secant_updates.h"

#include <utility>

namespace tremolo {

void add_pair(Vector step, Vector change, SecantUpdates& updates) {
  constexpr std::size_t kMost = 12;
  const double product = step.dot(change);
  if (!(product > 0)) return;
  updates.pairs.push_back({std::move(step), std::move(change), product});
  if (updates.pairs.size() > kMost) updates.pairs.pop_front();
}

Vector apply_inverse(const SecantUpdates& updates,
                     const std::function<Vector(const Vector&)>& inverse, const Vector& g) {
  const auto& pairs = updates.pairs;
  std::vector<double> along(pairs.size());
  Vector rest = g;
  for (std::size_t i = pairs.size(); i-- > 0;) {
    along[i] = pairs[i].step.dot(rest) / pairs[i].product;
    rest -= along[i] * pairs[i].change;
  }
  Vector result = inverse(rest);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    result += (along[i] - pairs[i].change.dot(result) / pairs[i].product) * pairs[i].step;
  return result;
}

}  // namespace tremolo
