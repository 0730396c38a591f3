// Scenes of cloth as things that are drawn.
#pragma once

#include <vector>

#include "runtime/viewer/cloth/cloth_scenes.h"
#include "runtime/viewer/draw/renderer.h"

namespace tremolo {

class ClothStage {
 public:
  // With a context current, as long as it lives. paints: linear light, a cloth or ball one behind
  // the other, scene by scene.
  ClothStage(const ClothScenes& scenes, const std::vector<Eigen::Vector3f>& paints, bool colliders);

  // Where everything is now. No OpenGL.
  void pose(const ClothScenes& scenes);
  // Hands it to the card.
  void upload();
  // Valid until the next call; after upload().
  const std::vector<DrawnThing>& things();
  // Around all that throws shadows, of the last pose(); it does not shrink.
  const ShownBall& ball() const { return ball_; }
  // All particles of the last pose(), and the corners of boxes around balls; m, as shown.
  const std::vector<double>& points() const { return points_; }
  // Along z, m, and whether a level plane is the ground.
  double ground() const { return ground_; }
  bool has_ground() const { return has_ground_; }

 private:
  struct Sheet {
    GpuMesh mesh;
    std::size_t scene = 0, cloth = 0;
    std::vector<float> positions, normals;
    Eigen::Vector3f colour;
  };
  // Balls and colliders: `number` of the scene's.
  struct Solid {
    GpuMesh mesh;
    std::size_t scene = 0, number = 0;
    bool is_ball = false;
    double radius = 0.0;  // m, of a ball
    Eigen::Matrix4f pose = Eigen::Matrix4f::Identity();
    Eigen::Vector3f colour;
  };

  void pose_sheet(const ClothScenes& scenes, Sheet& sheet);
  void pose_solid(const ClothScenes& scenes, Solid& solid);
  void add_solids(const ClothScenes& scenes, std::size_t scene, bool colliders,
                  const std::vector<Eigen::Vector3f>& paints, std::size_t& next);
  void enclose();

  std::vector<Sheet> sheets_;
  std::vector<Solid> solids_;
  GpuMesh hand_mesh_;
  std::optional<Eigen::Vector3d> hand_;
  std::vector<DrawnThing> things_;
  std::vector<double> points_;
  ShownBall ball_;
  bool posed_ = false;
  double ground_ = 0.0;
  bool has_ground_ = false;
};

}  // namespace tremolo
