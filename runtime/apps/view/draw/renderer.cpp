#include "runtime/apps/view/draw/renderer.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "runtime/apps/view/draw/gl_objects.h"
#include "runtime/apps/view/shape/collider_shape.h"

namespace tremolo {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

// Linear light.
const Vector3f kHorizon(0.80f, 0.82f, 0.85f), kZenith(0.55f, 0.58f, 0.63f);
const Vector3f kGroundColour(0.60f, 0.61f, 0.63f);
const Vector3f kLampColour(1.0f, 0.96f, 0.90f), kSkyColour(0.93f, 0.97f, 1.0f);
const Eigen::Vector4f kWireColour(0.02f, 0.02f, 0.03f, 0.35f);
constexpr float kWireShift = -1.0f;    // of OpenGL's polygon offset, towards the camera
constexpr double kGroundReach = 60.0;  // radii of the ball
constexpr float kFadeFrom = 2.0f, kFadeTo = 16.0f;
constexpr float kTexelsOff = 1.6f;  // along the normal, against shadows of a surface on itself
constexpr GLuint kLightsBinding = 0;
constexpr int kLampUnit = 0, kImageUnit = 1, kSkyUnit = 2;

struct LightBlock {
  Eigen::Vector4f to_map[3 * kMostLights];
  Eigen::Vector4f light[kMostLights];
};

Vector3f level_right(const Camera& camera) {
  return axes_of(camera).right.cast<float>();
}

}  // namespace

Result<std::unique_ptr<Renderer>> Renderer::create() {
  if (epoxy_gl_version() < 33)
    return system_error("the viewer needs OpenGL 3.3, there is " +
                        std::to_string(epoxy_gl_version() / 10) + "." +
                        std::to_string(epoxy_gl_version() % 10));
  std::unique_ptr<Renderer> made(new Renderer());
  const auto shader = [](const char* name, const char* vertex, const char* fragment) {
    return ShaderProgram::create(name, vertex, fragment);
  };
  if (Status s =
          take(made->surface_, shader("surface", kSurfaceVertexShader, kSurfaceFragmentShader));
      !s)
    return s.error();
  if (Status s = take(made->depth_, shader("depth", kDepthVertexShader, kDepthFragmentShader)); !s)
    return s.error();
  if (Status s = take(made->background_,
                      shader("background", kWholeVertexShader, kBackgroundFragmentShader));
      !s)
    return s.error();
  if (Status s =
          take(made->develop_, shader("develop", kWholeVertexShader, kDevelopFragmentShader));
      !s)
    return s.error();
  made->whole_ = GlHandle::make(GlKind::kVertexArray);
  made->light_buffer_ = GlHandle::make(GlKind::kBuffer);
  made->ground_ = GpuMesh(disc_shape(1.0));
  const GLuint program = made->surface_.name();
  glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Lights"), kLightsBinding);
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const std::string_view card = name == nullptr ? "" : name;
  for (const char* software : {"llvmpipe", "softpipe", "SWR", "SwiftShader"})
    if (card.find(software) != std::string_view::npos) made->software_ = true;
  return made;
}

void Renderer::choose_lights(const PictureLook& look, UpAxis up) {
  if (!lights_.empty() && light_counts_ == look.lights && lights_up_ == up &&
      lights_azimuth_ == look.light_azimuth)
    return;
  Camera front;
  front.up = up;
  front.azimuth = look.light_azimuth;
  light_counts_ = look.lights;
  lamp_maps_.make(look.lights.lamps, look.lights.side);
  sky_maps_.make(look.lights.sky, look.lights.sky_side());
  lights_ = studio_lights(look.lights, up_direction(up), axes_of(front).right);
  lights_up_ = up;
  lights_azimuth_ = look.light_azimuth;
}

void Renderer::place_lights(const ShownBall& ball) {
  LightBlock block;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const StudioLight& light = lights_[i];
    const Matrix4f clip = clip_of_light(light.direction, ball.centre, ball.radius);
    // From [-1, 1] to the map's [0, 1].
    for (int row = 0; row < 3; ++row) {
      Eigen::Vector4f to_map = 0.5f * clip.row(row).transpose();
      to_map[3] += 0.5f;
      block.to_map[3 * i + static_cast<std::size_t>(row)] = to_map;
    }
    block.light[i] << light.direction, light.brightness;
  }
  glBindBuffer(GL_UNIFORM_BUFFER, light_buffer_.name());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(block), &block, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, kLightsBinding, light_buffer_.name());
}

void Renderer::draw_maps(std::span<const DrawnThing> things, const ShownBall& ball) {
  depth_.use();
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_CLAMP);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(1.5f, 2.0f);
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const int light = static_cast<int>(i);
    if (light < light_counts_.lamps)
      lamp_maps_.begin(light);
    else
      sky_maps_.begin(light - light_counts_.lamps);
    depth_.set("clip", clip_of_light(lights_[i].direction, ball.centre, ball.radius));
    for (const DrawnThing& thing : things) {
      if (!thing.shadow || thing.glass < 1.0f) continue;
      depth_.set("pose", thing.pose);
      thing.mesh->draw(thing.first, thing.count);
    }
  }
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDisable(GL_DEPTH_CLAMP);
}

void Renderer::begin_surfaces(const Camera& camera, const ShownBall& ball,
                              const PictureLook& look) const {
  surface_.use();
  surface_.set("lamp_maps", kLampUnit);
  surface_.set("sky_maps", kSkyUnit);
  surface_.set("image", kImageUnit);
  surface_.set("lamps", light_counts_.lamps);
  surface_.set("lights", light_counts_.all());
  surface_.set("eye", Vector3f(eye_of(camera).cast<float>()));
  surface_.set("up", Vector3f(up_direction(camera.up).cast<float>()));
  surface_.set("centre", Vector3f(ball.centre.cast<float>()));
  surface_.set("lamp_colour", kLampColour);
  surface_.set("sky_colour", kSkyColour);
  surface_.set("horizon", kHorizon);
  surface_.set("zenith", kZenith);
  surface_.set("height", static_cast<float>(target_.size().height));
  surface_.set("moved_scale", 1.0f / std::max(look.full, 1e-30f));
  const auto texels = [&ball](int side) {
    return kTexelsOff * 2.0f * static_cast<float>(ball.radius) / static_cast<float>(side);
  };
  surface_.set("lamp_shift", texels(light_counts_.side));
  surface_.set("sky_shift", texels(light_counts_.sky_side()));
  for (const auto& [unit, maps] : {std::pair{kLampUnit, &lamp_maps_}, {kSkyUnit, &sky_maps_}}) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D_ARRAY, maps->texture());
  }
  glActiveTexture(GL_TEXTURE0 + kImageUnit);
}

void Renderer::draw_things(std::span<const DrawnThing> things, const Matrix4f& clip,
                           const PictureLook& look) {
  surface_.set("clip", clip);
  const auto draw = [this](const DrawnThing& thing) {
    surface_.set("pose", thing.pose);
    surface_.set("yields", thing.yields);
    thing.mesh->draw(thing.first, thing.count);
  };
  surface_.set("line", Eigen::Vector4f(Eigen::Vector4f::Zero()));
  glUniform2f(glGetUniformLocation(surface_.name(), "ground_fade"), -1.0f, -1.0f);
  for (const DrawnThing& thing : things) {
    surface_.set("paint_kind", static_cast<int>(thing.paint));
    surface_.set("colour", thing.colour);
    surface_.set("gloss", thing.gloss);
    surface_.set("glass", thing.glass);
    surface_.set("lifted", thing.lifted);
    if (thing.paint == Paint::kImage) {
      glBindTexture(GL_TEXTURE_2D, thing.image);
      const GLint wrap = thing.tiled ? GL_REPEAT : GL_CLAMP_TO_EDGE;
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap);
    }
    if (thing.glass < 1.0f) {
      glEnable(GL_BLEND);
      glDepthMask(GL_FALSE);
      glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    }
    if (thing.on_top) glDepthRange(0.0, 0.001);
    draw(thing);
    glDepthRange(0.0, 1.0);
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
  }
  if (!look.wire) return;
  surface_.set("line", kWireColour);
  glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
  glEnable(GL_POLYGON_OFFSET_LINE);
  glPolygonOffset(kWireShift, kWireShift);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  for (const DrawnThing& thing : things)
    if (thing.wire) draw(thing);
  glDisable(GL_BLEND);
  glDisable(GL_POLYGON_OFFSET_LINE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void Renderer::draw_ground(const ShownBall& ball, const Camera& camera, const PictureLook& look,
                           const Matrix4f& clip) {
  const Eigen::Vector3d up = up_direction(camera.up);
  const auto radius = static_cast<float>(ball.radius);
  Matrix4f pose = Matrix4f::Identity();
  // The disc's z becomes the world's up.
  const Eigen::Vector3d right = level_right({.up = camera.up}).cast<double>();
  pose.col(0).head<3>() = right.cast<float>();
  pose.col(1).head<3>() = up.cross(right).cast<float>();
  pose.col(2).head<3>() = up.cast<float>();
  pose.leftCols<3>() *= static_cast<float>(kGroundReach) * radius;
  const Eigen::Vector3d place = ball.centre + (look.ground - up.dot(ball.centre)) * up;
  pose.col(3).head<3>() = place.cast<float>();
  surface_.set("pose", pose);
  surface_.set("clip", clip);
  surface_.set("line", Eigen::Vector4f(Eigen::Vector4f::Zero()));
  surface_.set("paint_kind", static_cast<int>(Paint::kOne));
  surface_.set("colour", kGroundColour);
  surface_.set("gloss", 0.0f);
  surface_.set("glass", 1.0f);
  surface_.set("yields", 0.0f);
  surface_.set("lifted", 0.0f);
  glUniform2f(glGetUniformLocation(surface_.name(), "ground_fade"), kFadeFrom * radius,
              kFadeTo * radius);
  glEnable(GL_CULL_FACE);
  ground_.draw();
  glDisable(GL_CULL_FACE);
}

void Renderer::develop(const PictureSize& size, const PictureLook& look, GLuint framebuffer) const {
  target_.resolve();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, size.width, size.height);
  glDisable(GL_DEPTH_TEST);
  develop_.use();
  develop_.set("picture", kImageUnit);
  glUniform2f(glGetUniformLocation(develop_.name(), "size"), static_cast<float>(size.width),
              static_cast<float>(size.height));
  develop_.set("flat_background", look.background ? 1 : 0);
  glActiveTexture(GL_TEXTURE0 + kImageUnit);
  glBindTexture(GL_TEXTURE_2D, target_.light());
  glBindVertexArray(whole_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Status Renderer::draw(std::span<const DrawnThing> things, const ShownBall& ball,
                      const Camera& camera, const PictureSize& size, const PictureLook& look,
                      GLuint framebuffer) {
  const int coarser = std::max(1, look.coarser);
  if (Status s = target_.resize(
          {(size.width + coarser - 1) / coarser, (size.height + coarser - 1) / coarser});
      !s)
    return s;
  choose_lights(look, camera.up);
  place_lights(ball);
  draw_maps(things, ball);
  target_.begin();
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glDisable(GL_DEPTH_TEST);
  background_.use();
  background_.set("horizon", look.background.value_or(kHorizon));
  background_.set("zenith", look.background.value_or(kZenith));
  background_.set("height", static_cast<float>(target_.size().height));
  glBindVertexArray(whole_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_MULTISAMPLE);
  begin_surfaces(camera, ball, look);
  const auto clip_within = [&](double reach) {
    return Matrix4f(
        clip_from_world(camera, size.aspect(), ball.centre, reach * ball.radius).cast<float>());
  };
  // The ground is behind or below all things and has its own depth range.
  if (!look.background && look.has_ground) {
    draw_ground(ball, camera, look, clip_within(kGroundReach));
    glClear(GL_DEPTH_BUFFER_BIT);
  }
  draw_things(things, clip_within(1.5), look);
  develop(size, look, framebuffer);
  return Success{};
}

}  // namespace tremolo
