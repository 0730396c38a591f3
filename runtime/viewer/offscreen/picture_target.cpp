#include "runtime/viewer/offscreen/picture_target.h"

#include <algorithm>

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

void read_pixels(GLuint framebuffer, const PictureSize& size, Picture& picture) {
  picture.width = size.width;
  picture.height = size.height;
  const auto row = static_cast<std::size_t>(3 * size.width);
  picture.pixels.resize(row * static_cast<std::size_t>(size.height));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, picture.pixels.data());
  // OpenGL's first row is the lowest.
  for (int y = 0; y < size.height / 2; ++y) {
    const auto upper = picture.pixels.begin() + static_cast<std::ptrdiff_t>(row) * y;
    const auto lower =
        picture.pixels.begin() + static_cast<std::ptrdiff_t>(row) * (size.height - 1 - y);
    std::swap_ranges(upper, upper + static_cast<std::ptrdiff_t>(row), lower);
  }
}

}  // namespace tremolo
