#include "runtime/apps/view/draw/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kLampAngle = 0.13;  // rad: how large the lamp is seen to be, from its middle
constexpr float kLampBrightness = 1.05f, kSkyBrightness = 0.5f;
const double kGolden = std::numbers::pi * (3.0 - std::sqrt(5.0));

}  // namespace

std::vector<StudioLight> studio_lights(const LightCounts& counts, const Vector3d& up,
                                       const Vector3d& right) {
  const Vector3d front = right.cross(up);  // towards the camera
  std::vector<StudioLight> lights;
  const Vector3d lamp = (0.62 * right + 0.62 * front + 1.0 * up).normalized();
  const Vector3d across = lamp.cross(up).normalized(), along = lamp.cross(across);
  for (int i = 0; i < counts.lamps; ++i) {
    // A sunflower's seeds: spread evenly over a disc.
    const double radius = counts.lamps == 1 ? 0.0 : std::sqrt((i + 0.5) / counts.lamps);
    const Vector3d off = std::cos(kGolden * i) * across + std::sin(kGolden * i) * along;
    const Vector3d direction = (lamp + kLampAngle * radius * off).normalized();
    lights.push_back({direction.cast<float>(), kLampBrightness / static_cast<float>(counts.lamps)});
  }
  double level = 0.0;  // light on ground that sees all of the sky
  for (int i = 0; i < counts.sky; ++i) {
    const double height = (i + 0.5) / counts.sky, level_out = std::sqrt(1.0 - height * height);
    const Vector3d direction = level_out * std::cos(kGolden * i) * right +
                               level_out * std::sin(kGolden * i) * front + height * up;
    level += height;
    lights.push_back({direction.cast<float>(), kSkyBrightness});
  }
  for (std::size_t i = counts.lamps; i < lights.size(); ++i)
    lights[i].brightness /= static_cast<float>(level);
  return lights;
}

Eigen::Matrix4f clip_of_light(const Eigen::Vector3f& direction, const Vector3d& centre,
                              double radius) {
  const Vector3d back = direction.cast<double>();
  const Vector3d right = back.unitOrthogonal(), up = back.cross(right);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
  clip.row(0) << right.transpose(), -right.dot(centre);
  clip.row(1) << up.transpose(), -up.dot(centre);
  clip.row(2) << -back.transpose(), back.dot(centre);
  clip.topRows<3>() /= radius;
  return clip.cast<float>();
}

void ShadowMaps::make(int count, int side) {
  count_ = count;
  side_ = side;
  texture_ = GlHandle::make(GlKind::kTexture);
  framebuffer_ = GlHandle::make(GlKind::kFramebuffer);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture_.name());
  glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT16, side, side, std::max(1, count), 0,
               GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, nullptr);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D_ARRAY, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D_ARRAY, wrap, GL_CLAMP_TO_BORDER);
  // Points outside the map are lit.
  const float lit[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  glTexParameterfv(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BORDER_COLOR, lit);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
}

void ShadowMaps::begin(int map) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, texture_.name(), 0, map);
  glViewport(0, 0, side_, side_);
  glClear(GL_DEPTH_BUFFER_BIT);
}

}  // namespace tremolo
