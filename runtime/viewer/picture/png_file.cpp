#include "runtime/viewer/picture/png_file.h"

#include <png.h>
#include <string_view>

#include "formats/file/atomic_file.h"
#include "formats/file/whole_file.h"

namespace tremolo {
namespace {

constexpr png_uint_32 kMostPixels = 16384;  // a side

}  // namespace

Status write_png(const std::string& path, const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.pixels.data(), 0,
                                nullptr) == 0)
    return system_error(path + ": the picture could not be packed: " + image.message);
  return write_file(path, std::string_view(bytes).substr(0, size));
}

Result<Picture> read_png(const std::string& path) {
  const Result<std::string> bytes = read_whole_file(path);
  if (!bytes) return bytes.error();
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto refused = [&path, &image](const char* why) {
    const Error error = content_error(path + ": " + why);
    png_image_free(&image);
    return error;
  };
  if (png_image_begin_read_from_memory(&image, bytes->data(), bytes->size()) == 0)
    return refused(image.message);
  if (image.width > kMostPixels || image.height > kMostPixels)
    return refused("the picture is larger than 16384 pixels a side");
  image.format = PNG_FORMAT_RGB;
  Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.pixels.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, picture.pixels.data(), 0, nullptr) == 0)
    return refused(image.message);
  return picture;
}

}  // namespace tremolo
