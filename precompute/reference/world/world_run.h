// `tremolo-precompute reference` of a body that moves through the world: its support follows a
// given motion, or it has none and flies (docs/theory.md, "The unreduced body").
#pragma once

#include "precompute/reference/reference_options.h"

namespace tremolo {

// True if the options ask for it.
bool moves_in_world(const ReferenceOptions& options);

// Runs it, as run_reference. Throws Failure: kUsage for flags that exclude each other, kContent for
// a motion that does not cover the run, for a support motion of a free body, or for spin or
// velocity of a fixed one.
void run_in_world(const ReferenceOptions& options);

}  // namespace tremolo
