// The lights of the studio: their directions, and depth maps for their shadows.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/apps/view/draw/gl_objects.h"

namespace tremolo {

// Numbers of lights. More of either kind give softer shadows; each costs a pass over all triangles.
struct LightCounts {
  int lamps = 12;   // directions close together, which form one soft lamp; at least 1
  int sky = 36;     // directions spread over the sky
  int side = 1024;  // of a lamp's map, texels; sky maps have a third of it, for softer shadows

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

// up: of the world; right: to the right of the camera's first position, horizontal. Lamps are
// first. At most kMostLights (runtime/apps/view/draw/gl_objects.h).
std::vector<StudioLight> studio_lights(const LightCounts& counts, const Eigen::Vector3d& up,
                                       const Eigen::Vector3d& right);

// Maps the world to a light's clip coordinates, so that a ball is just inside; m.
Eigen::Matrix4f clip_of_light(const Eigen::Vector3f& direction, const Eigen::Vector3d& centre,
                              double radius);

// Depth maps of one size, one per light.
class ShadowMaps {
 public:
  // A context must be current. count: with 0 one map is made, which stays unused.
  void make(int count, int side);
  int count() const { return count_; }
  // Clears this map and selects it as the target of drawing.
  void begin(int map) const;
  GLuint texture() const { return texture_.name(); }

 private:
  int count_ = 0, side_ = 0;
  GlHandle texture_, framebuffer_;
};

}  // namespace tremolo
