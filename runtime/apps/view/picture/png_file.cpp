#include "runtime/apps/view/picture/png_file.h"

#include <algorithm>
#include <fstream>
#include <png.h>
#include <string_view>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"

namespace tremolo {
namespace {

constexpr png_uint_32 kMostPixels = 16384;  // a side

// A PNG begins with a signature of 8 bytes and a chunk IHDR of 25.
constexpr std::size_t kChunksFrom = 33;
constexpr std::string_view kMaker("tEXtSoftware\0tremolo view", 25);

void append_number(std::string& bytes, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
}

// CRC-32 as PNG has it.
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

// The chunk with the name of the writing program.
std::string maker_chunk() {
  std::string chunk;
  append_number(chunk, static_cast<std::uint32_t>(kMaker.size() - 4));
  chunk += kMaker;
  append_number(chunk, crc_of(kMaker));
  return chunk;
}

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
  bytes.resize(size);
  bytes.insert(kChunksFrom, maker_chunk());
  return write_file(path, bytes);
}

bool is_our_png(const std::string& path) {
  std::string head(kChunksFrom + 4 + kMaker.size(), '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  return stream.good() && std::string_view(head).substr(kChunksFrom + 4) == kMaker;
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
