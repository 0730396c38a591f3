// The vertex whose largest displacement is the amplitude of a periodic motion.
#pragma once

#include <span>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/response/response.h"

namespace tremolo {

struct Probe {
  VertexId vertex = 0;
  Eigen::MatrixXd rows;  // of U, 3 x r, kg^-1/2
  bool moves = false;    // false: all vertices that it was chosen from are fixed
};

// Of these vertices the one that moves most in the mode, 0 <= mode < r. Errors as Model::vertex.
Result<Probe> moving_most(const Model& model, std::span<const VertexId> vertices,
                          Eigen::Index mode);

// The largest extent of the drawn surface at rest, m.
double extent_of(const Model& model);

// The probe's largest distance from its position at rest over a period, m: CurveOptions::amplitude.
std::function<double(const FourierSeries&)> amplitude_of(const Probe& probe);

// Limits the curve of a system without damping: no motion attracts others and the curve need not
// end, so that no stability is computed, no harmonics are added and the points are few.
void limit_undamped(CurveOptions& options);

}  // namespace tremolo
