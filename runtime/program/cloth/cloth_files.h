// The files of a run of a scene with [[cloths]]: run.csv, and of each cloth its surfaces.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "formats/file/atomic_file.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/scene_reader/scene_keys.h"

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

}  // namespace tremolo
