// Objects of OpenGL that are given back: buffers, meshes, programs, targets.
#pragma once

#include <cstdint>
#include <epoxy/gl.h>
#include <span>
#include <utility>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/picture/png_file.h"
#include "runtime/apps/view/shape/collider_shape.h"

namespace tremolo {

// Names of OpenGL objects that are given back.

enum class GlKind { kBuffer, kVertexArray, kTexture, kFramebuffer, kRenderbuffer, kProgram };

// Owns one object; 0: none. It must be made and destroyed with the same context current.
class GlHandle {
 public:
  GlHandle() = default;
  GlHandle(GlKind kind, GLuint name) : kind_(kind), name_(name) {}
  GlHandle(GlHandle&& other) noexcept : kind_(other.kind_), name_(std::exchange(other.name_, 0U)) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    std::swap(kind_, other.kind_);
    std::swap(name_, other.name_);
    return *this;
  }
  GlHandle(const GlHandle&) = delete;
  GlHandle& operator=(const GlHandle&) = delete;
  ~GlHandle();

  // Creates an object of any kind except kProgram.
  static GlHandle make(GlKind kind);

  GLuint name() const { return name_; }

 private:
  GlKind kind_ = GlKind::kBuffer;
  GLuint name_ = 0;
};

// A texture of the picture, with its first row at v = 1 since texture coordinates count from below.
// A context must be current.
GlHandle make_image(const Picture& picture);

// True if a texture coordinate is outside 0 to 1, with a margin for rounding: the image is then
// repeated; otherwise its edges are clamped, so that the opposite edge is not mixed in. uvs: of all
// vertices, u v ...; triangles: three indices each.
bool repeats_image(std::span<const std::uint32_t> triangles, std::span<const float> uvs);

// Triangles in the graphics card's memory. A context must be current in every call, the same one.
class GpuMesh {
 public:
  GpuMesh() = default;
  // triangles: three indices each. rest: positions of the vertices at rest, x y z ..., m;
  // Paint::kMoved shows the distance from them.
  GpuMesh(std::span<const std::uint32_t> triangles, std::span<const float> rest);
  explicit GpuMesh(const TriangleShape& shape);

  // positions: of all vertices now, x y z ..., m; normals: their unit normals.
  void move(std::span<const float> positions, std::span<const float> normals);
  // colours: r g b a of each vertex, linear light. uvs: u v of each vertex.
  void paint(std::span<const float> colours);
  void unfold(std::span<const float> uvs);

  void draw() const;
  // Draws a part of the triangles; first and count in triangles.
  void draw(std::size_t first, std::size_t count) const;
  std::size_t triangles() const { return triangles_; }

 private:
  void attribute(GLuint location, GlHandle& buffer, int numbers, std::span<const float> values,
                 GLenum use);

  GlHandle array_, indices_, positions_, normals_, rest_, colours_, uvs_;
  std::size_t triangles_ = 0;
};

// Shaders: text -> program.
class ShaderProgram {
 public:
  ShaderProgram() = default;
  // Errors (kSystem): the messages of the driver's compiler, after `name`.
  static Result<ShaderProgram> create(const char* name, const char* vertex, const char* fragment);

  void use() const { glUseProgram(program_.name()); }
  GLuint name() const { return program_.name(); }
  // Sets a uniform of the program in use. A name that the driver has removed as unused is ignored.
  void set(const char* uniform, int value) const { glUniform1i(place(uniform), value); }
  void set(const char* uniform, float value) const { glUniform1f(place(uniform), value); }
  void set(const char* uniform, const Eigen::Vector3f& value) const {
    glUniform3fv(place(uniform), 1, value.data());
  }
  void set(const char* uniform, const Eigen::Vector4f& value) const {
    glUniform4fv(place(uniform), 1, value.data());
  }
  void set(const char* uniform, const Eigen::Matrix4f& value) const {
    glUniformMatrix4fv(place(uniform), 1, GL_FALSE, value.data());
  }

 private:
  explicit ShaderProgram(GlHandle program) : program_(std::move(program)) {}
  GLint place(const char* uniform) const { return glGetUniformLocation(program_.name(), uniform); }

  GlHandle program_;
};

// Lights of one picture at most; the shaders' array is as long.
inline constexpr int kMostLights = 96;

// A surface under all lights. What its inputs mean is said at runtime/apps/view/draw/renderer.cpp.
extern const char* const kSurfaceVertexShader;
extern const char* const kSurfaceFragmentShader;
// The same surface seen from a light: depth only.
extern const char* const kDepthVertexShader;
extern const char* const kDepthFragmentShader;
// A triangle over the whole picture: the background; and the picture's light as sRGB.
extern const char* const kWholeVertexShader;
extern const char* const kBackgroundFragmentShader;
extern const char* const kDevelopFragmentShader;

// The target of a picture: linear light at four samples per pixel, averaged at the end.
class FrameTarget {
 public:
  // Makes room for pictures of this size, if it is another one. Errors: kSystem where the card does
  // not take it.
  Status resize(const PictureSize& size);
  const PictureSize& size() const { return size_; }

  void begin() const;    // makes it the target of drawing
  void resolve() const;  // light() then has it
  GLuint light() const { return light_.name(); }

 private:
  PictureSize size_{0, 0};
  GlHandle samples_, depth_, drawn_, light_, resolved_;
};

}  // namespace tremolo
