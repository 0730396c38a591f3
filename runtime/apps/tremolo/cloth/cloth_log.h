// Measurements and output files of a run of a scene with [[cloths]].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "formats/file/atomic_file.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/math/state.h"

namespace tremolo {

// Columns: t (s), kinetic, elastic, gravity, total, damped, wind, pins, contact, numerical (J; as
// ClothEnergy), px py pz (kg m/s), lx ly lz (kg m^2/s), penetration (m), and NAMEx NAMEy NAMEz (m)
// of each ball.
class ClothTable {
 public:
  // Errors: kSystem.
  static Result<ClothTable> create(const std::string& path, const ClothScene& scene);
  Status write(const ClothWorld& world, const ClothEnergy& energy);
  Status finish();

 private:
  explicit ClothTable(AtomicFile file) : file_(std::move(file)) {}

  std::string text_;
  AtomicFile file_;
};

// The surfaces of one cloth, evenly spaced in time, in a folder, which is there.
class ClothFrames {
 public:
  // steps: of the whole run.
  ClothFrames(std::string folder, const SceneOutputs& outputs, std::int64_t steps)
      : folder_(std::move(folder)),
        format_(outputs.surface_format),
        count_(outputs.surfaces),
        steps_(steps) {}

  // They are due at k/N of the run, k = 1 ... N.
  bool due(std::int64_t steps) const;
  Status write(const ClothWorld& world, std::size_t cloth);
  // Writes frames.csv (frame, t in s, file).
  Status finish();

  const std::vector<std::string>& files() const { return files_; }

 private:
  std::string folder_, format_;
  int count_;
  std::int64_t steps_;
  int written_ = 0;
  std::string list_ = "frame,t,file\n";
  std::vector<std::string> files_;
};

// Energies in J. remainder_max: the largest |change of the energy - energy given by wind, pins,
// contact and dampers|, which is the error of the method.
struct ClothReport {
  ClothEnergy start, end;
  Momenta momenta_start, momenta_end;  // of all cloths and balls together
  double energy_max = 0.0;  // largest sum of kinetic, elastic and |change of gravity's| energy
  double remainder_max = 0.0;
  double turnover_max = 0.0;  // the largest sum of |energy exchanged| over all causes
  int exit_code = 0;          // 0, 4 or 5
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
