// The CSV of a run: a row for each recorded moment.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/body.h"

namespace tremolo {

// Columns: t (s), kinetic, potential, total, high_band, work, dissipated (J), q<i> of chosen
// coordinates (kg^1/2 m), u<v>x u<v>y u<v>z of chosen vertices (m). Text in memory until write().
class Recorder {
 public:
  // Errors (kUsage): a coordinate or a vertex that the model does not have.
  static Result<Recorder> create(const Model& model, std::vector<int> coordinates,
                                 const std::vector<int>& probes);

  void record(const Body& body, const Energy& energy);
  Status write(const std::string& path) const;

 private:
  struct Probe {
    int vertex;
    Eigen::Matrix<double, 3, Eigen::Dynamic> rows;
  };

  std::vector<int> coordinates_;
  std::vector<Probe> probes_;
  std::string text_;
};

}  // namespace tremolo
