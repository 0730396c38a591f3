// Scenes of bodies of tetrahedra as surfaces that move.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/scene_reader/tets_reader.h"
#include "runtime/viewer/live/viewed_scene.h"
#include "runtime/viewer/setup/viewer_options.h"
#include "runtime/viewer/surfaces/moving_surfaces.h"

namespace tremolo {

// True of a scene file whose bodies are of kind "tets"; false also of what cannot be read, which
// others tell.
bool is_tets_file(const std::string& file);

class TetsScenes : public MovingSurfaces {
 public:
  // by_degree: a vertex's number is the share of quadratic edges in its element. Errors: those of
  // make_tets_bodies.
  static Result<TetsScenes> create(TetScene scene, bool by_degree);

  const TetsBodies& bodies() const { return bodies_; }

  SceneGravity gravity() const override;
  std::vector<ShownSheet> sheets() const override;
  std::vector<ShownSolid> solids() const override;
  void place(std::size_t sheet, SheetNow& now) const override;
  Pose pose(std::size_t solid) const override { return scene_.colliders[solid].pose; }
  double time() const override { return scene_.step * static_cast<double>(steps_); }
  double step_size() const override { return scene_.step; }
  std::int64_t steps() const override { return steps_; }
  // kSolver: bodies whose step could not be made, and those that they touch, are as they were.
  Status step() override;
  Status begin_again() override;
  std::vector<std::string> told() const override;
  // Bodies of tetrahedra cannot be held.
  bool take(const CameraRay&) override { return false; }
  void move_to(const Eigen::Vector3d&) override {}
  void let_go() override {}
  std::optional<Eigen::Vector3d> hand() const override { return std::nullopt; }

 private:
  TetsScenes() = default;

  TetScene scene_;
  TetsBodies bodies_;
  std::vector<TetStepReport> reports_;
  bool by_degree_ = false;
  std::int64_t steps_ = 0;
};

// `tremolo view` of such a scene, with or without --offscreen; errors are printed.
int view_tets_command(const ViewerOptions& options, const ViewFlags& flags);

}  // namespace tremolo
