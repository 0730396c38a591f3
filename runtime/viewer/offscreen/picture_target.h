// A framebuffer whose pixels can be read.
#pragma once

#include "common/result.h"
#include "runtime/viewer/camera/camera.h"
#include "runtime/viewer/draw/gl_handle.h"
#include "runtime/viewer/picture/png_file.h"

namespace tremolo {

// 8 bits a colour, sRGB values as they are drawn. A context must be current in every call.
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
