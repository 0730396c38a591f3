// OpenGL without a display.
#pragma once

#include <memory>

#include "common/result.h"

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

}  // namespace tremolo
