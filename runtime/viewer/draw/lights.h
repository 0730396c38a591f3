// The lights of the studio: directions, and the maps of depths that tell what each sees.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/viewer/draw/gl_handle.h"

namespace tremolo {

// lamps: directions near each other that are one soft lamp, at least one. sky: directions spread
// over the sky. More of both give softer shadows and cost a pass over all triangles each. side: of
// a lamp's map, in texels; those of the sky are a third of it, which blurs what each of them adds.
struct LightCounts {
  int lamps = 12, sky = 36;
  int side = 1024;

  int all() const { return lamps + sky; }
  int sky_side() const { return side / 3; }
  bool operator==(const LightCounts&) const = default;
};

// direction: towards the light, of length one, world. brightness: that of all lamps sums to the
// lamp's, that of the sky so that ground that sees all of it is as bright as the sky.
struct StudioLight {
  Eigen::Vector3f direction;
  float brightness = 0.0f;
};

// up: of the world; right: to the right of the camera's first place, level. Lamps come first. At
// most kMostLights (runtime/viewer/draw/shaders.h).
std::vector<StudioLight> studio_lights(const LightCounts& counts, const Eigen::Vector3d& up,
                                       const Eigen::Vector3d& right);

// Maps the world to a light's clip coordinates, so that a ball is just inside; m.
Eigen::Matrix4f clip_of_light(const Eigen::Vector3f& direction, const Eigen::Vector3d& centre,
                              double radius);

// Depth maps of one size, one a light.
class ShadowMaps {
 public:
  // With a context current. count: 0 makes one that nobody draws into.
  void make(int count, int side);
  int count() const { return count_; }
  // What is drawn now goes into this map, which is empty.
  void begin(int map) const;
  GLuint texture() const { return texture_.name(); }

 private:
  int count_ = 0, side_ = 0;
  GlHandle texture_, framebuffer_;
};

}  // namespace tremolo
