#include "runtime/apps/view/offscreen/egl_context.h"
#include "runtime/apps/view/picture/png_file.h"

namespace tremolo {

Result<PictureTarget> PictureTarget::create(const PictureSize& size) {
  PictureTarget target;
  target.size_ = size;
  target.pixels_ = GlHandle::make(GlKind::kRenderbuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, target.pixels_.name());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size.width, size.height);
  target.framebuffer_ = GlHandle::make(GlKind::kFramebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                            target.pixels_.name());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    return system_error("OpenGL gives no room for a picture of " + std::to_string(size.width) +
                        "x" + std::to_string(size.height) + " pixels");
  return target;
}

void PictureTarget::read(Picture& picture) const {
  read_pixels(framebuffer_.name(), size_, picture);
}

}  // namespace tremolo
