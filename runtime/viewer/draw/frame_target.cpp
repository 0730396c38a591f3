#include "runtime/viewer/draw/frame_target.h"

#include <algorithm>
#include <string>

namespace tremolo {
namespace {

constexpr int kSamples = 4;

Status check_complete(const PictureSize& size) {
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Success{};
  return system_error("OpenGL gives no room for a picture of " + std::to_string(size.width) + "x" +
                      std::to_string(size.height) + " pixels");
}

GlHandle renderbuffer(GLenum format, int samples, const PictureSize& size) {
  GlHandle buffer = GlHandle::make(GlKind::kRenderbuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, size.width, size.height);
  return buffer;
}

}  // namespace

Status FrameTarget::resize(const PictureSize& size) {
  if (size.width == size_.width && size.height == size_.height) return Success{};
  size_ = {0, 0};
  GLint most = 0, largest = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  if (std::max(size.width, size.height) > largest)
    return system_error("OpenGL gives no room for a picture of " + std::to_string(size.width) +
                        "x" + std::to_string(size.height) + " pixels, " + std::to_string(largest) +
                        " a side at most");
  const int samples = std::min(kSamples, most);
  samples_ = renderbuffer(GL_RGBA16F, samples, size);
  depth_ = renderbuffer(GL_DEPTH_COMPONENT24, samples, size);
  drawn_ = GlHandle::make(GlKind::kFramebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, samples_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
  if (Status s = check_complete(size); !s) return s;
  light_ = GlHandle::make(GlKind::kTexture);
  glBindTexture(GL_TEXTURE_2D, light_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, size.width, size.height, 0, GL_RGBA, GL_FLOAT,
               nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  resolved_ = GlHandle::make(GlKind::kFramebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, resolved_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, light_.name(), 0);
  if (Status s = check_complete(size); !s) return s;
  size_ = size;
  return Success{};
}

void FrameTarget::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_.name());
  glViewport(0, 0, size_.width, size_.height);
}

void FrameTarget::resolve() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.name());
  glBlitFramebuffer(0, 0, size_.width, size_.height, 0, 0, size_.width, size_.height,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace tremolo
