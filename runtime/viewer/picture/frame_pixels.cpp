#include "runtime/viewer/picture/frame_pixels.h"

#include <algorithm>

namespace tremolo {

void read_pixels(GLuint framebuffer, const PictureSize& size, Picture& picture) {
  picture.width = size.width;
  picture.height = size.height;
  const std::size_t row = 3 * size.width;
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
