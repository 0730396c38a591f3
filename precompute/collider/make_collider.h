// `tremolo-precompute collider`: a surface becomes a collider file.
#pragma once

#include "precompute/collider/collider_options.h"

namespace tremolo {

// Reads the surface, closes it, computes the distances, measures the grid's error and writes the
// file; JSON goes to stdout, progress to stderr. Throws Failure, with the file in the message.
void make_collider(const ColliderOptions& options);

}  // namespace tremolo
