// The target of a picture: linear light at four samples per pixel, averaged at the end.
#pragma once

#include "common/result.h"
#include "runtime/viewer/camera/camera.h"
#include "runtime/viewer/draw/gl_handle.h"

namespace tremolo {

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
