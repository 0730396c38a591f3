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
  // Before a step of the world in which the particle is held, `way` m from where it was taken.
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

// The scene that was viewed, with its method and step of now, and the hands behind its own ones;
// every path as seen from `path`. Written whole or not at all. Errors: kSystem.
Status write_recorded_cloth(const std::string& path, const ClothFile& file, const ClothScene& now,
                            const std::vector<ClothHand>& hands);

}  // namespace tremolo
