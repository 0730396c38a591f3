// Measurements and output files of a run of a scene with [[cloths]].
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/tremolo/measure/energy_balance.h"
#include "runtime/apps/tremolo/run/log_files.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/math/state.h"

namespace tremolo {

// Writes the surface of a cloth with its particles at x, 3n.
Status write_cloth_surface(const ClothParts& parts, const Eigen::VectorXd& x,
                           const std::string& path);

// Columns: t (s), kinetic, elastic, gravity, total, damped, wind, pins, contact, numerical (J; as
// ClothEnergy), px py pz (kg m/s), lx ly lz (kg m^2/s), penetration (m), and NAMEx NAMEy NAMEz (m)
// of each ball.
class ClothTable {
 public:
  // path: empty: nothing is written. Errors: kSystem.
  static Result<ClothTable> create(const std::string& path, const ClothScene& scene);
  Status write(const ClothWorld& world, const ClothEnergy& energy);
  Status finish() { return table_.finish(); }

 private:
  explicit ClothTable(CsvTable table) : table_(std::move(table)) {}

  CsvTable table_;
};

struct ClothReport : RunEnding {
  ClothEnergy start, end;
  Momenta momenta_start, momenta_end;  // of all cloths and balls together
  // Of the sum of kinetic, elastic and |change of gravity's| energy, with the energy given by wind,
  // pins, contact and dampers; the remainder is the error of the method.
  EnergyBalance balance;
  std::vector<std::string> files;
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
  std::vector<Frames> frames_;  // of each cloth
  ClothReport report_;
};

}  // namespace tremolo
