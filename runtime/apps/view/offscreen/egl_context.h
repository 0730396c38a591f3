// OpenGL without a display.
#pragma once

#include <memory>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/draw/gl_objects.h"
#include "runtime/apps/view/picture/png_file.h"

namespace tremolo {

// A context of OpenGL 3.3 that is current as long as the object lives. It takes EGL's platform
// without surfaces, which needs neither X nor a screen, else EGL's usual one with a surface of one
// pixel.
class EglContext {
 public:
  // Errors (kSystem) name the missing part: libEGL, a driver, OpenGL 3.3.
  static Result<std::unique_ptr<EglContext>> create();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

 private:
  EglContext() = default;
  void* display_ = nullptr;
  void* context_ = nullptr;
  void* surface_ = nullptr;
};

// A framebuffer whose pixels can be read. 8 bits a colour, sRGB values as they are drawn. A context
// must be current in every call.
class PictureTarget {
 public:
  // Errors: kSystem for a size that the card does not take.
  static Result<PictureTarget> create(const PictureSize& size);
  GLuint framebuffer() const { return framebuffer_.name(); }
  // Reads the picture, from the upper left corner.
  void read(Picture& picture) const;

 private:
  PictureSize size_;
  GlHandle pixels_, framebuffer_;
};

}  // namespace tremolo
