// Names of OpenGL objects that are given back.
#pragma once

#include <epoxy/gl.h>
#include <utility>

namespace tremolo {

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

}  // namespace tremolo
