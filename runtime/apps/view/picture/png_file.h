// A picture as a PNG file.
#pragma once

#include <cstdint>
#include <epoxy/gl.h>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"

namespace tremolo {

// pixels: r g b of each, 8 bits sRGB, row by row from the upper left corner, width * height * 3.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

// Writes the file whole or not at all, with the text that is_our_png() checks. Errors: kSystem if
// it cannot be written.
Status write_png(const std::string& path, const Picture& picture);

// True if write_png() wrote the file, which its text "Software" shows.
bool is_our_png(const std::string& path);

// Any PNG as r g b. Errors: kSystem for a file that cannot be read, kContent for one that is no PNG
// or is larger than 16384 a side.
Result<Picture> read_png(const std::string& path);

// Reads the pixels of a framebuffer. The pixels of a framebuffer, from the upper left corner. A
// context must be current.
void read_pixels(GLuint framebuffer, const PictureSize& size, Picture& picture);

}  // namespace tremolo
