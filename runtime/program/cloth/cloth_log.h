// Measurements and output files of a run of a scene with [[cloths]].
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/program/cloth/cloth_files.h"
#include "runtime/scene_reader/cloth_reader.h"
#include "runtime/values/momenta.h"

namespace tremolo {

// Energies in J. remainder_max: the largest |change of the energy - energy given by wind, pins,
// contact and dampers|, which is the error of the method.
struct ClothReport {
  ClothEnergy start, end;
  Momenta momenta_start, momenta_end;  // of all cloths and balls together
  double energy_max = 0.0;  // largest sum of kinetic, elastic and |change of gravity's| energy
  double remainder_max = 0.0;
  double turnover_max = 0.0;  // the largest sum of |energy exchanged| over all causes
  int exit_code = 0;  // 0, 4 or 5
  std::string reason;
  std::vector<std::string> files;

  // Relative to the larger of energy_max and turnover_max; 0 if nothing ever moved.
  double balance_error() const;
};

class ClothLog {
 public:
  // Makes the folders if there is an `out`. file: must outlive this. Errors: kSystem.
  static Result<ClothLog> create(const ClothFile& file, const ClothWorld& world);

  // Takes the start and then every step. False: the energy has left its bound, and the report says
  // so.
  Result<bool> observe(const ClothWorld& world);
  void give_up(const Error& why);
  // Renames the files from their temporary names.
  Status finish(const ClothWorld& world);

  const ClothReport& report() const { return report_; }

 private:
  ClothLog(const ClothFile& file, const ClothWorld& world);
  void note_energy(const ClothEnergy& now);

  const ClothFile* file_;
  std::optional<ClothTable> table_;
  std::vector<ClothFrames> frames_;
  ClothReport report_;
};

}  // namespace tremolo
