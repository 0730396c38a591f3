// Reads the pixels of a framebuffer.
#pragma once

#include <epoxy/gl.h>

#include "runtime/viewer/camera/camera.h"
#include "runtime/viewer/picture/png_file.h"

namespace tremolo {

// The pixels of a framebuffer, from the upper left corner. A context must be current.
void read_pixels(GLuint framebuffer, const PictureSize& size, Picture& picture);

}  // namespace tremolo
