// Scenes of cloth that are seen side by side, and the user's hand in them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/scene_reader/cloth_reader.h"
#include "runtime/viewer/camera/camera.h"
#include "runtime/viewer/live/viewed_scene.h"

namespace tremolo {

// True of a scene file with [[cloths]]; false also of what cannot be read, which others tell.
bool is_cloth_file(const std::string& file);

// The scene with the command line's flags over it. Errors: those of parse_cloths() and
// apply_cloth_flags(); kSystem where the file cannot be read.
Result<ClothFile> read_cloth_file(const std::string& file, const ViewFlags& flags);

class ClothScenes {
 public:
  // A scene's world, and where it is shown: `aside` m along x from where it is.
  struct Shown {
    ClothFile file;
    ClothWorld world;
    Eigen::Vector3d aside = Eigen::Vector3d::Zero();
  };

  // At least one; they are shown one beside the other. Errors: those of ClothWorld::create;
  // kContent where their steps differ.
  static Result<ClothScenes> create(std::vector<ClothFile> files);

  const std::vector<Shown>& shown() const { return shown_; }
  double time() const { return shown_.front().world.time(); }
  double step_size() const { return shown_.front().file.scene.options.step; }
  // One step of each. Errors: those of ClothWorld::step.
  Status step();
  // From their beginning anew; the hand is empty then.
  Status begin_again();

  // Takes hold of the particle nearest to where the ray first meets a cloth; false where it meets
  // none.
  bool take(const CameraRay& ray);
  // Where the hand shall be from the next step on, m, as shown.
  void move_to(const Eigen::Vector3d& point);
  void let_go();
  // As shown, m; nothing while it is empty.
  std::optional<Eigen::Vector3d> hand() const;

 private:
  struct Hand {
    std::size_t scene = 0, cloth = 0, particle = 0;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  // of the scene, m
  };

  ClothScenes() = default;
  void place();

  std::vector<Shown> shown_;
  std::optional<Hand> hand_;
};

}  // namespace tremolo
