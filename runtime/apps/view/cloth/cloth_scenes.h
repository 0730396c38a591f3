// Scenes of cloth that are seen side by side, and the user's hand in them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/view/live/viewed_scene.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace tremolo {

// A record of the user's grabs of a cloth, as hands of a scene.
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

// The scene with the command line's flags over it. Errors: those of parse_cloths() and
// apply_cloth_flags(); kSystem where the file cannot be read.
Result<ClothFile> read_cloth_file(const std::string& file, const GivenFlags& flags);

class ClothScenes : public MovingSurfaces {
 public:
  // A scene's world, and where it is shown: `aside` m along x from where it is.
  struct Shown {
    ClothFile file;
    ClothWorld world;
    Eigen::Vector3d aside = Eigen::Vector3d::Zero();
  };

  // At least one file; scenes are shown side by side. Errors: those of ClothWorld::create; kContent
  // if their steps differ.
  static Result<ClothScenes> create(std::vector<ClothFile> files);

  const std::vector<Shown>& shown() const { return shown_; }

  SceneGravity gravity() const override { return shown_.front().file.scene.gravity; }
  std::vector<ShownSheet> sheets() const override;
  std::vector<ShownSolid> solids() const override;
  void place(std::size_t sheet, SheetNow& now) const override;
  Pose pose(std::size_t solid) const override;
  double time() const override { return shown_.front().world.time(); }
  double step_size() const override { return shown_.front().world.scene().options.step; }
  std::int64_t steps() const override { return shown_.front().world.steps(); }
  // Errors: those of ClothWorld::step and create.
  Status step() override;
  Status begin_again() override;
  std::vector<std::string> panel_lines() const override;
  // The hand holds the particle nearest to where the ray first meets a cloth.
  bool take(const CameraRay& ray) override;
  void move_to(const Eigen::Vector3d& point) override;
  void let_go() override;
  std::optional<Eigen::Vector3d> hand() const override;
  std::optional<double> hand_work() const override;
  // The twelve. Refused while a hand is recorded, and beyond a method's stability.
  std::span<const std::string_view> methods() const override { return nodal_integrator_names(); }
  std::vector<std::string> chosen() const override;
  Status choose(std::size_t scene, std::string_view method) override;
  Status set_step_size(double step) override;
  // Refused of scenes side by side.
  Status record_hand() override;
  Status write_hand(const std::string& path) override;

 private:
  // begun: position of the particle when it was grabbed, in the scene, m; way: the hand's
  // displacement.
  struct Hand {
    std::size_t scene = 0, cloth = 0, particle = 0;
    Eigen::Vector3d begun = Eigen::Vector3d::Zero(), way = Eigen::Vector3d::Zero();
    Eigen::Vector3d point() const { return begun + way; }
  };

  // A cloth, ball or collider of a scene, by its numbers.
  struct Part {
    std::size_t scene = 0, number = 0;
    bool is_collider = false;
  };

  ClothScenes() = default;
  void place_beside();
  void list_parts();
  void find_looks();

  std::vector<Shown> shown_;
  std::vector<Part> sheets_, solids_;
  std::vector<ClothLook> looks_;                    // of each sheet
  mutable std::vector<float> particles_, normals_;  // room of place()
  std::optional<Hand> hand_;
  ClothHandRecord record_;
  bool records_ = false;
};

// `tremolo view` of scenes with [[cloths]], with or without --offscreen; errors are printed.
int view_cloth_command(const ViewerOptions& options, const GivenFlags& flags);

}  // namespace tremolo
