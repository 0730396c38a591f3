// Limited-memory BFGS updates (Nocedal 1980, two-loop recursion) that correct an approximate
// inverse P^-1 of an equation's derivative. With a good P they replace new tangents.
#pragma once

#include <deque>

#include "precompute/reference/full/step_equation.h"

namespace tremolo {

struct SecantUpdates {
  struct Pair {
    Vector step, change;  // s, and y: the gradient's change over s
    double product = 0;   // s . y > 0
  };
  std::deque<Pair> pairs;  // oldest first
};

// Adds a pair; pairs with s . y <= 0 are discarded.
void add_pair(Vector step, Vector change, SecantUpdates& updates);

// Returns the corrected inverse times g. inverse: x -> P^-1 x, symmetric and positive definite.
Vector apply_inverse(const SecantUpdates& updates,
                     const std::function<Vector(const Vector&)>& inverse, const Vector& g);

}  // namespace tremolo
