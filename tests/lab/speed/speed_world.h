// Declarations shared by the two files of the section "Many bodies".
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "runtime/model.h"
#include "tests/lab/speed/speed.h"

namespace tremolo::bench {

inline constexpr std::size_t kBodies = 1000;

// States like those of a scene: the first mode moves its vertex by up to a twentieth of the size,
// the others have at most its energy.
// The same ones every time.
std::vector<Eigen::VectorXd> random_states(const Model& model, std::size_t count);

// Rows of the force in lanes, one thread; of AVX2 code where the machine has AVX-512.
void measure_lane_force(const Model& model, const MachineProbe& probe, SpeedSection& section);
void measure_narrower_lanes(const Model& model, SpeedSection& section);

}  // namespace tremolo::bench
