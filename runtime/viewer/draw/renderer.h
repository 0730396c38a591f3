// Things under the studio's lights -> a picture. Needs OpenGL 3.3.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/viewer/camera/camera.h"
#include "runtime/viewer/draw/frame_target.h"
#include "runtime/viewer/draw/gpu_mesh.h"
#include "runtime/viewer/draw/lights.h"
#include "runtime/viewer/draw/shader_program.h"

namespace tremolo {

// Where the colour of a thing comes from: one colour, a colour a vertex, an image, by how much its
// vertices have moved, or by a number a vertex, the first of its colour.
enum class Paint { kOne = 0, kVertices = 1, kImage = 2, kMoved = 3, kNumber = 4 };

// mesh: must live while it is drawn. pose: from the mesh's frame to the world. first, count: which
// of its triangles. colour: linear light, r g b in 0 to 1. image: a texture's name. gloss: 0 to 1.
// shadow: it throws one.
struct DrawnThing {
  const GpuMesh* mesh = nullptr;
  Eigen::Matrix4f pose = Eigen::Matrix4f::Identity();
  std::size_t first = 0, count = 0;
  Paint paint = Paint::kOne;
  Eigen::Vector3f colour = Eigen::Vector3f::Constant(0.6f);
  GLuint image = 0;
  float gloss = 1.0f;
  float glass = 1.0f;  // how much of it is seen; below 1 it hides nothing that comes behind it
  bool shadow = true;
  bool wire = true;     // if wires are asked for
  bool on_top = false;  // nothing hides it; such things come last
};

// light_azimuth: rad, as of a camera: the lamp stands to the upper right of one there. background:
// one colour behind everything, and no ground; linear. Without one a studio: level ground at
// `ground` (m along the up axis) that fades into the background.
struct PictureLook {
  LightCounts lights;
  double light_azimuth = 0.0;
  bool wire = false;
  int coarser = 1;    // pixels of the picture, along each side, that are drawn as one
  float full = 1.0f;  // what kMoved (m) and kNumber paint red
  std::optional<Eigen::Vector3f> background;
  double ground = 0.0;
  bool has_ground = true;  // of the studio; a scene may have a floor of its own
};

// A ball that holds what throws shadows, m: it is what the maps of the lights cover.
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
