// The CSV of a run: a row for each recorded state, written during the run.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/atomic_file.h"
#include "runtime/energy.h"
#include "runtime/model.h"
#include "runtime/program/run/march.h"

namespace tremolo {

// coordinates: whose q is recorded; probes: vertices whose displacement is. velocities: p of these
// coordinates and the velocities of these vertices too. further: names of columns whose values are
// given with each row.
struct RecordedColumns {
  std::vector<int> coordinates;
  std::vector<int> probes;
  bool velocities = false;
  std::vector<std::string> further;
};

// Columns: t (s), kinetic, potential, total, high_band, work, dissipated (J), the further ones,
// q<i> (kg^1/2 m) and p<i> (kg^1/2 m/s) of chosen coordinates, u<v>x u<v>y u<v>z (m) and v<v>x
// v<v>y v<v>z (m/s) of chosen vertices. Whole lines are written to a temporary file, which finish()
// renames.
class Recorder {
 public:
  // path: of the CSV; empty: nothing is recorded. parked: its file is closed between pieces, for
  // runs with more recorders than a process may have open files. Errors: kUsage for a vertex that
  // the model does not have; kSystem if the file cannot be made.
  static Result<Recorder> create(const Model& model, const RecordedColumns& columns,
                                 const std::string& path, bool parked = false);

  // further: as many values as there are further columns.
  Status record(const Moment& moment, const Energy& energy, std::span<const double> further = {});
  // Writes the buffered rows, so that they can be read in the temporary file.
  Status flush();
  Status finish();

 private:
  struct Probe {
    int vertex;
    Eigen::Matrix<double, 3, Eigen::Dynamic> rows;
  };

  RecordedColumns columns_;
  std::vector<Probe> probes_;
  std::string text_;
  std::optional<AtomicFile> file_;
  bool parked_ = false;
};

}  // namespace tremolo
