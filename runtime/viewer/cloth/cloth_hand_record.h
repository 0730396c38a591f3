// A record of the user's grabs of a cloth, as hands of a scene.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

class ClothHandRecord {
 public:
  // Call this before a step of the world in which the particle is held, displaced by `way`, m, from
  // its position when grabbed.
  void before_step(const ClothWorld& world, std::size_t cloth, std::size_t particle,
                   const Eigen::Vector3d& way);
  // Ends the grab at `time`, s.
  void end(double time);
  // Discards all records, when the world restarts.
  void clear();

  // In a world with the same start they give the same motion.
  const std::vector<ClothHand>& hands() const { return hands_; }

 private:
  std::vector<ClothHand> hands_;
  bool holds_ = false;
};

// Writes the viewed scene with its present method and step, and with these hands after its own;
// paths are relative to that of the file. Written whole or not at all. Errors: kSystem.
Status write_recorded_cloth(const std::string& path, const ClothFile& file, const ClothScene& now,
                            const std::vector<ClothHand>& hands);

}  // namespace tremolo
