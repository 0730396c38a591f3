// `tremolo-precompute reference` of a body that moves through the world: its support follows a
// given motion, or nothing holds it and it flies (docs/theory.md, "The unreduced body").
#pragma once

#include "precompute/reference/reference_options.h"

namespace tremolo {

// True if the options ask for it.
bool moves_in_world(const ReferenceOptions& options);

// Runs it; as run_reference. Throws Failure: kUsage for flags that do not go together, kContent for
// a motion that does not cover the run, or a support where the body has none or the other way
// round.
void run_in_world(const ReferenceOptions& options);

}  // namespace tremolo
