// run.csv of the whole mesh in the world.
#pragma once

#include <string>

#include "precompute/reference/time_integration.h"
#include "precompute/reference/world/whole_frame.h"

namespace tremolo {

// Columns: t (s), kinetic, potential, total, work, dissipated (J); x y z (m) qw qx qy qz, the
// frame; px py pz (kg m/s), lx ly lz (N m s, about the world's origin), the momenta of the whole
// mesh; u<v>x u<v>y u<v>z of the probes, m, along the frame's axes.
std::string world_table_head(const std::vector<VertexId>& probes);

// relative: displacements in the frame, 3n.
std::string world_table_row(const Motion& motion, const WholeFrame& frame,
                            const std::vector<VertexId>& probes, const Field& relative);

}  // namespace tremolo
