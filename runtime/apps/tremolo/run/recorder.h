// The CSV of a run: a row for each recorded state, written during the run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/tremolo/run/log_files.h"
#include "runtime/body.h"
#include "runtime/energy.h"
#include "runtime/model.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The state of a body at the end of a step. work, dissipated, iterations and halved_steps count
// from the start.
struct Moment {
  std::int64_t steps = 0;
  double time = 0.0;  // s
  State state;        // p: the momentum at the time of q
  // N, 3 for each of the model's response_places(): W times these is shown on top of U q.
  Eigen::VectorXd place_forces;
  double work = 0.0;        // J
  double dissipated = 0.0;  // J
  std::int64_t iterations = 0;
  std::int64_t halved_steps = 0;
  bool loaded = false;         // a load can still act
  std::optional<Split> split;  // of a splitting method
  EnergyBound bound;           // with the energy put in so far
};

// The displacement of a vertex that the forces of a moment add to U q. Zero without a response.
class ShownResponse {
 public:
  static Result<ShownResponse> create(const Model& model, int vertex);
  Eigen::Vector3d operator()(const Moment& moment) const {
    if (rows_.cols() == 0) return Eigen::Vector3d::Zero();
    return rows_ * moment.place_forces;
  }

 private:
  Eigen::Matrix<double, 3, Eigen::Dynamic> rows_;
};

// Copies the body's state into `moment`; allocates only if it has not held as many coordinates
// before.
void look_at(const Body& body, Moment& moment);

// coordinates: whose q is recorded; probes: vertices whose displacement is. velocities: p of these
// coordinates and the velocities of these vertices too. further: names of columns whose values are
// given with each row.
struct RecordedColumns {
  std::vector<int> coordinates;
  std::vector<int> probes;
  bool velocities = false;
  std::vector<std::string> further;
};

// The coordinates of "all", "I" and "I-J", each once, in the order named. Errors: kUsage.
Result<std::vector<int>> coordinates_of(const std::vector<std::string>& texts, Eigen::Index modes);

// The columns of a body of the scene, without further ones. Errors: kUsage for a text of the wrong
// form, kContent for a coordinate that the model does not have; those of selectors.
Result<RecordedColumns> recorded_columns(const SceneColumns& columns, const Model& model);

// Columns: t (s), kinetic, potential, total, high_band, work, dissipated (J), the further ones,
// q<i> (kg^1/2 m) and p<i> (kg^1/2 m/s) of chosen coordinates, u<v>x u<v>y u<v>z (m) and v<v>x
// v<v>y v<v>z (m/s) of chosen vertices.
class Recorder {
 public:
  // path, parked: as for CsvTable. Errors: kUsage for a vertex that the model does not have;
  // kSystem if the file cannot be made.
  static Result<Recorder> create(const Model& model, const RecordedColumns& columns,
                                 const std::string& path, bool parked = false);

  // further: as many values as there are further columns.
  Status record(const Moment& moment, const Energy& energy, std::span<const double> further = {});
  Status flush() { return table_.flush(); }
  Status finish() { return table_.finish(); }

 private:
  struct Probe {
    int vertex;
    Eigen::Matrix<double, 3, Eigen::Dynamic> rows;
    ShownResponse response;
  };

  RecordedColumns columns_;
  std::vector<Probe> probes_;
  CsvTable table_;
};

}  // namespace tremolo
