// What the last few iterations have shown of an equation's derivative, as corrections of an
// approximate inverse P^-1: the limited-memory BFGS update (Nocedal 1980, two loops). With a good P
// it takes the place of tangents.
#pragma once

#include <deque>

#include "precompute/reference/step_equation.h"

namespace tremolo {

struct SecantUpdates {
  struct Pair {
    Vector step, change;  // s, and y: the gradient's change over it
    double product = 0;   // s . y > 0
  };
  std::deque<Pair> pairs;  // oldest first
};

// Pairs along which the gradient does not grow are not kept.
void add_pair(Vector step, Vector change, SecantUpdates& updates);

// The corrected inverse times g; inverse: x -> P^-1 x, symmetric and positive definite.
Vector apply_inverse(const SecantUpdates& updates,
                     const std::function<Vector(const Vector&)>& inverse, const Vector& g);

}  // namespace tremolo
