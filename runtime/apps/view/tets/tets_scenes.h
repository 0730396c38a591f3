// Scenes of bodies of tetrahedra as surfaces that move.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/view/live/viewed_scene.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace tremolo {

class TetsScenes : public MovingSurfaces {
 public:
  // Errors: those of make_tets_bodies.
  static Result<TetsScenes> create(TetScene scene);

  const TetsBodies& bodies() const { return bodies_; }

  SceneGravity gravity() const override;
  std::vector<ShownSheet> sheets() const override;
  std::vector<ShownSolid> solids() const override;
  void place(std::size_t sheet, SheetNow& now) const override;
  Pose pose(std::size_t solid) const override { return scene_.colliders[solid].pose; }
  double time() const override { return scene_.step * static_cast<double>(steps_); }
  double step_size() const override { return scene_.step; }
  std::int64_t steps() const override { return steps_; }
  // kSolver: bodies whose step failed, and those in contact with them, keep their state.
  Status step() override;
  Status begin_again() override;
  std::vector<std::string> panel_lines() const override;
  // The vertex of the drawn surface that is nearest to where the ray first meets it is taken, and
  // pulled by suitable springs (tet_hand.h).
  bool take(const CameraRay& ray) override;
  void move_to(const Eigen::Vector3d& point) override;
  void let_go() override;
  std::optional<Eigen::Vector3d> hand() const override;
  // Position of the grabbed vertex, m.
  std::optional<Eigen::Vector3d> held() const;

 private:
  // goal: where the hand's point is at the end of the next step, m.
  struct Hold {
    std::size_t body = 0;
    TetHand hand;
    Eigen::Vector3d goal = Eigen::Vector3d::Zero();
  };

  TetsScenes() = default;

  TetScene scene_;
  TetsBodies bodies_;
  std::vector<TetStepReport> reports_;
  std::int64_t steps_ = 0;
  std::optional<Hold> hold_;
};

// `tremolo view` of such a scene, with or without --offscreen; errors are printed.
int view_tets_command(const ViewerOptions& options, const GivenFlags& flags);

}  // namespace tremolo
