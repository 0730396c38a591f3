#include "runtime/viewer/draw/gl_handle.h"

namespace tremolo {

GlHandle GlHandle::make(GlKind kind) {
  GLuint name = 0;
  switch (kind) {
    case GlKind::kBuffer:
      glGenBuffers(1, &name);
      break;
    case GlKind::kVertexArray:
      glGenVertexArrays(1, &name);
      break;
    case GlKind::kTexture:
      glGenTextures(1, &name);
      break;
    case GlKind::kFramebuffer:
      glGenFramebuffers(1, &name);
      break;
    case GlKind::kRenderbuffer:
      glGenRenderbuffers(1, &name);
      break;
    case GlKind::kProgram:
      name = glCreateProgram();
      break;
  }
  return {kind, name};
}

GlHandle::~GlHandle() {
  if (name_ == 0) return;
  switch (kind_) {
    case GlKind::kBuffer:
      glDeleteBuffers(1, &name_);
      break;
    case GlKind::kVertexArray:
      glDeleteVertexArrays(1, &name_);
      break;
    case GlKind::kTexture:
      glDeleteTextures(1, &name_);
      break;
    case GlKind::kFramebuffer:
      glDeleteFramebuffers(1, &name_);
      break;
    case GlKind::kRenderbuffer:
      glDeleteRenderbuffers(1, &name_);
      break;
    case GlKind::kProgram:
      glDeleteProgram(name_);
      break;
  }
}

}  // namespace tremolo
