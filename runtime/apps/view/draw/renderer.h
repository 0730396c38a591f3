// Draws things under the studio's lights. Needs OpenGL 3.3.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/draw/gl_objects.h"
#include "runtime/apps/view/draw/lights.h"

namespace tremolo {

// The source of a thing's colour: one colour, a colour per vertex, an image, the displacement of
// each vertex, or a number per vertex (the first component of its colour).
enum class Paint { kOne = 0, kVertices = 1, kImage = 2, kMoved = 3, kNumber = 4 };

// A range of a mesh's triangles with its pose and material.
struct DrawnThing {
  const GpuMesh* mesh = nullptr;                       // must live while it is drawn
  Eigen::Matrix4f pose = Eigen::Matrix4f::Identity();  // from the mesh's frame to the world
  std::size_t first = 0, count = 0;                    // triangles
  Paint paint = Paint::kOne;
  Eigen::Vector3f colour = Eigen::Vector3f::Constant(0.6f);  // linear light, r g b in 0 to 1
  GLuint image = 0;                                          // a texture's name
  bool tiled = false;                                        // the image is repeated beyond 0 to 1
  float gloss = 1.0f;                                        // 0 to 1
  // Opacity; below 1 it hides nothing behind it, casts no shadow and shows none, because shadows of
  // something that is hardly visible would be noticed more than the thing.
  float glass = 1.0f;
  // Something that is behind its surface by less than this is drawn over it, m: a sheet that rests
  // on a solid by its vertices has triangles that cut off the solid's edges.
  float yields = 0.0f;
  // Distance along its normals at which its surface looks for shadows, m, for the same reason.
  float lifted = 0.0f;
  bool shadow = true;   // it casts one
  bool wire = true;     // drawn when PictureLook::wire is set
  bool on_top = false;  // nothing hides it; such things are last in the list
};

// The appearance of a picture.
struct PictureLook {
  LightCounts lights;
  double light_azimuth = 0.0;  // rad, as for a camera: the lamp is to the upper right of it
  bool wire = false;
  int coarser = 1;    // pixels of the picture, along each side, per pixel that is drawn
  float full = 1.0f;  // the value that kMoved (m) and kNumber show in red
  // Linear colour behind everything, without a ground. Empty: the studio, whose level ground fades
  // into the background.
  std::optional<Eigen::Vector3f> background;
  double ground = 0.0;     // m, along the up axis
  bool has_ground = true;  // of the studio; a scene may have a floor of its own
};

// A ball around everything that casts shadows, m: the region of the lights' maps.
struct ShownBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 1.0;
};

class Renderer {
 public:
  // A context must be current, here and in every call. Errors: kSystem where it has no OpenGL 3.3
  // or does not take the shaders.
  static Result<std::unique_ptr<Renderer>> create();

  // Into the framebuffer. Errors: kSystem for a size that the card does not take.
  Status draw(std::span<const DrawnThing> things, const ShownBall& ball, const Camera& camera,
              const PictureSize& size, const PictureLook& look, GLuint framebuffer);

  // The pictures are made by the processor, not by a graphics card.
  bool is_software() const { return software_; }

 private:
  Renderer() = default;
  void draw_maps(std::span<const DrawnThing> things, const ShownBall& ball);
  void draw_things(std::span<const DrawnThing> things, const Eigen::Matrix4f& clip,
                   const PictureLook& look);
  void draw_ground(const ShownBall& ball, const Camera& camera, const PictureLook& look,
                   const Eigen::Matrix4f& clip);
  void begin_surfaces(const Camera& camera, const ShownBall& ball, const PictureLook& look) const;
  void choose_lights(const PictureLook& look, UpAxis up);
  void place_lights(const ShownBall& ball);
  void develop(const PictureSize& size, const PictureLook& look, GLuint framebuffer) const;

  ShaderProgram surface_, depth_, background_, develop_;
  LightCounts light_counts_{0, 0, 0};
  ShadowMaps lamp_maps_, sky_maps_;
  std::vector<StudioLight> lights_;
  UpAxis lights_up_ = UpAxis::kZ;
  double lights_azimuth_ = 0.0;
  GlHandle light_buffer_, whole_;
  FrameTarget target_;
  GpuMesh ground_;
  bool software_ = false;
};

}  // namespace tremolo
