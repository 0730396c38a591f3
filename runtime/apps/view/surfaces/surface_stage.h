// Moving surfaces as drawn things.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "runtime/apps/view/draw/renderer.h"
#include "runtime/apps/view/setup/view_setup.h"
#include "runtime/apps/view/setup/viewer_options.h"
#include "runtime/apps/view/shape/creased_shape.h"
#include "runtime/apps/view/shape/surface_stress.h"
#include "runtime/apps/view/surfaces/moving_surfaces.h"

namespace tremolo {

class SurfaceStage {
 public:
  // With a context current, as long as it lives. The setup's paints are of sheets, then of balls.
  // Errors (kContent): an image, if no sheet has texture coordinates, or for a material, since
  // those of sheets have no names.
  static Result<std::unique_ptr<SurfaceStage>> create(const MovingSurfaces& scenes,
                                                      const ViewSetup& setup,
                                                      const ViewerOptions& options);

  // Computes all present positions. Needs no OpenGL.
  void pose(const MovingSurfaces& scenes);
  // Uploads them to the card, with the numbers that are shown as colours.
  void upload();
  // The number that is red: the option's, or the largest in any upload() so far.
  float full() const;
  // The largest stress of a vertex in any upload() so far, Pa; 0 if stress is not shown.
  float most_stressed() const { return colour_ == ColourBy::kStress ? most_ : 0.0F; }
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
    CreasedSheet sheet;
    GpuMesh mesh;
    std::vector<Eigen::Vector3d> rest;  // m
    std::vector<Triangle> triangles;    // into rest
    SheetNow now;
    std::vector<float> positions, normals;
    std::optional<SurfaceStress> stress;
    bool has_degrees = false;
    std::vector<float> numbers, colours;
    Eigen::Vector3f colour;
    bool has_uvs = false, tiled = false;
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

  SurfaceStage() = default;
  void add_sheet(const ShownSheet& shown, const Eigen::Vector3f& paint);
  Status add_images(const std::vector<StageImage>& images);
  bool is_numbered(const Sheet& sheet) const;
  void number(Sheet& sheet);
  void add_solid(const ShownSolid& shown, std::size_t number, const Pose& pose, bool colliders,
                 const std::vector<Eigen::Vector3f>& paints, std::size_t& next);
  void pose_sheet(const MovingSurfaces& scenes, std::size_t number);
  void pose_solid(const MovingSurfaces& scenes, Solid& solid);
  void enclose();
  double coarsest_edge() const;

  ColourBy colour_ = ColourBy::kBody;
  float most_ = 0.0F, asked_ = 0.0F;  // the largest number so far, the option's
  std::vector<GlHandle> images_;
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
