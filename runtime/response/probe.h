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

// The displacement of a vertex by the forces themselves, of a model's stored response
// (Model::response), at the factor 1 of the load.
struct ProbeResponse {
  Eigen::Vector3d constant = Eigen::Vector3d::Zero();  // m
  FourierSeries periodic;                              // 3 x (2K + 1), m; column 0 is zero

  bool none() const { return constant.isZero(0.0) && periodic.isZero(0.0); }
};
// forces: f of the load's places, N, 3 per place (place_forces_of); course: of the load in time, 1
// x (2K + 1); static_scale: of the same forces held constant. Errors as Model::response.
Result<ProbeResponse> probe_response(const Model& model, VertexId vertex,
                                     const Eigen::VectorXd& forces, const FourierSeries& course,
                                     double static_scale);

// The probe's displacement over a period at this factor of the load, 3 x (2H + 1), m.
FourierSeries shown_motion(const Probe& probe, const ProbeResponse& response,
                           const FourierSeries& motion, double load);

// The largest distance of the displacement above: CurveOptions::loaded_amplitude. Empty without a
// response.
std::function<double(const FourierSeries&, double load)> loaded_amplitude_of(
    const Probe& probe, const ProbeResponse& response);

// Limits the curve of a system without damping: no motion attracts others and the curve need not
// end, so that no stability is computed, no harmonics are added and the points are few.
void limit_undamped(CurveOptions& options);

}  // namespace tremolo
