// Moving surfaces as drawn things.
#pragma once

#include <vector>

#include "runtime/apps/view/draw/renderer.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"

namespace tremolo {

class SurfaceStage {
 public:
  // With a context current, as long as it lives. paints: linear light, of sheets, then of balls.
  SurfaceStage(const MovingSurfaces& scenes, const std::vector<Eigen::Vector3f>& paints,
               bool colliders);

  // Computes all present positions. Needs no OpenGL.
  void pose(const MovingSurfaces& scenes);
  // Uploads them to the card.
  void upload();
  // Valid until the next call; after upload().
  const std::vector<DrawnThing>& things();
  // The ball around everything that casts shadows in the last pose(); it does not shrink.
  const ShownBall& ball() const { return ball_; }
  // All vertices of the last pose(), and the corners of boxes around balls; m, as shown.
  const std::vector<double>& points() const { return points_; }
  // Along z, m, and whether a level plane is the ground.
  double ground() const { return ground_; }
  bool has_ground() const { return has_ground_; }

 private:
  struct Sheet {
    GpuMesh mesh;
    std::vector<Triangle> triangles;
    bool numbered = false;
    SheetNow now;
    std::vector<float> positions, normals, colours;
    Eigen::Vector3f colour;
  };
  struct Solid {
    GpuMesh mesh;
    std::size_t number = 0;  // of the scenes' solids
    double radius = 0.0;     // m, of a ball; 0: a collider
    bool is_plane = false;
    float most_yield = 0.0F;  // m
    Eigen::Matrix4f pose = Eigen::Matrix4f::Identity();
    Eigen::Vector3f colour;
  };

  void add_solid(const ShownSolid& shown, std::size_t number, const Pose& pose, bool colliders,
                 const std::vector<Eigen::Vector3f>& paints, std::size_t& next);
  void pose_sheet(const MovingSurfaces& scenes, std::size_t number);
  void pose_solid(const MovingSurfaces& scenes, Solid& solid);
  void enclose();
  double coarsest_edge() const;

  std::vector<Sheet> sheets_;
  std::vector<Solid> solids_;
  GpuMesh hand_mesh_;
  std::optional<Eigen::Vector3d> hand_;
  std::vector<DrawnThing> things_;
  std::vector<double> points_;
  double edge_ = 0.0;      // m, of the sheets' triangles at first; the coarsest sheet's mean
  bool yielding_ = false;  // there are solids that yield to sheets
  ShownBall ball_;
  bool posed_ = false;
  double ground_ = 0.0;
  bool has_ground_ = false;
};

}  // namespace tremolo
