#include "runtime/io/exchange/glb_file.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"
#include "runtime/io/exchange/json_text.h"

namespace tremolo {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr std::size_t kAlignment = 4;

constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};

constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

std::size_t padded_to_words(std::size_t size) {
  return (size + kAlignment - 1) / kAlignment * kAlignment;
}

int component_size(GlbComponent component) {
  if (component == GlbComponent::kByte) return 1;
  return component == GlbComponent::kShort ? 2 : 4;
}

// Least and largest value of each component.
std::string bounds_text(std::span<const float> values, std::size_t components) {
  std::vector<float> low(components, std::numeric_limits<float>::infinity());
  std::vector<float> high(components, -std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < values.size(); ++i) {
    low[i % components] = std::min(low[i % components], values[i]);
    high[i % components] = std::max(high[i % components], values[i]);
  }
  return ",\"min\":" + json_numbers(low) + ",\"max\":" + json_numbers(high);
}

std::string view_text(std::size_t offset, std::size_t size) {
  return "{\"buffer\":0,\"byteOffset\":" + json_number(offset) +
         ",\"byteLength\":" + json_number(size);
}

}  // namespace

std::size_t GlbFile::view_of(GlbPart part) {
  const auto found = std::find(views_.begin(), views_.end(), part);
  if (found != views_.end()) return static_cast<std::size_t>(found - views_.begin());
  views_.push_back(part);
  return views_.size() - 1;
}

std::size_t GlbFile::add(GlbPart part, const GlbFormat& format, const void* bytes, std::size_t size,
                         std::size_t count) {
  std::string& place = parts_[static_cast<std::size_t>(part)];
  place.resize(padded_to_words(place.size()), '\0');
  std::string text = "{\"bufferView\":" + json_number(view_of(part)) +
                     ",\"byteOffset\":" + json_number(place.size()) +
                     ",\"componentType\":" + json_number(static_cast<int>(format.component)) +
                     ",\"count\":" + json_number(count) + ",\"type\":\"" +
                     kTypes[format.components - 1] + "\"";
  if (format.normalized) text += ",\"normalized\":true";
  if (format.bounds) {
    const std::size_t numbers = size / sizeof(float);
    text += bounds_text({static_cast<const float*>(bytes), numbers},
                        static_cast<std::size_t>(format.components));
  }
  accessors_.push_back(text + "}");
  place.append(static_cast<const char*>(bytes), size);
  if (part != GlbPart::kIndices && part != GlbPart::kMotion)
    stride_[static_cast<std::size_t>(part)] = component_size(format.component) * format.components;
  return accessors_.size() - 1;
}

std::size_t GlbFile::add_zeros(int components, std::size_t count) {
  const std::vector<float> one(static_cast<std::size_t>(components), 0.0F);
  accessors_.push_back("{\"componentType\":" + json_number(static_cast<int>(GlbComponent::kFloat)) +
                       ",\"count\":" + json_number(count) + ",\"type\":\"" +
                       kTypes[components - 1] + "\"" + bounds_text(one, one.size()) + "}");
  return accessors_.size() - 1;
}

std::size_t GlbFile::add_floats(GlbPart part, int components, std::span<const float> values,
                                bool bounds) {
  return add(part, {GlbComponent::kFloat, components, false, bounds}, values.data(),
             values.size_bytes(), values.size() / static_cast<std::size_t>(components));
}

std::size_t GlbFile::add_image(const std::string& name, const std::string& type,
                               std::string bytes) {
  images_.push_back({name, type, std::move(bytes)});
  return images_.size() - 1;
}

Status GlbFile::write(const std::string& path, std::vector<std::string> members,
                      std::uint64_t& bytes) {
  std::vector<std::string> views, images;
  std::size_t offset = 0;
  for (const GlbPart part : views_) {
    const auto k = static_cast<std::size_t>(part);
    std::string text = view_text(offset, parts_[k].size());
    if (stride_[k] != 0) text += ",\"byteStride\":" + json_number(stride_[k]);
    if (part != GlbPart::kMotion)
      text += ",\"target\":" +
              json_number(part == GlbPart::kIndices ? kElementArrayBuffer : kArrayBuffer);
    views.push_back(text + "}");
    parts_[k].resize(padded_to_words(parts_[k].size()), '\0');
    offset += parts_[k].size();
  }
  for (Image& image : images_) {
    images.push_back("{\"name\":" + json_string(image.name) + ",\"mimeType\":\"" + image.type +
                     "\",\"bufferView\":" + json_number(views.size()) + "}");
    views.push_back(view_text(offset, image.bytes.size()) + "}");
    image.bytes.resize(padded_to_words(image.bytes.size()), '\0');
    offset += image.bytes.size();
  }
  members.push_back("\"accessors\":" + json_list(accessors_));
  members.push_back("\"bufferViews\":" + json_list(views));
  if (!images.empty()) members.push_back("\"images\":" + json_list(images));
  members.push_back("\"buffers\":[{\"byteLength\":" + json_number(offset) + "}]");
  std::string json = json_list(members);
  json.front() = '{';
  json.back() = '}';
  json.resize(padded_to_words(json.size()), ' ');

  constexpr std::size_t kHeaders = 12 + 8 + 8;
  bytes = kHeaders + json.size() + offset;
  if (bytes > std::numeric_limits<std::uint32_t>::max())
    return content_error(path + ": it would have " + std::to_string(bytes) +
                         " bytes, and a .glb file at most 4294967295");
  std::string head;
  for (const std::size_t word : {std::size_t{kMagic}, std::size_t{2}, std::size_t{bytes},
                                 json.size(), std::size_t{kJsonChunk}})
    append_bytes(head, static_cast<std::uint32_t>(word));
  head += json;
  append_bytes(head, static_cast<std::uint32_t>(offset));
  append_bytes(head, kBinChunk);
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  Status status = file->write(head);
  for (const GlbPart part : views_)
    if (status) status = file->write(parts_[static_cast<std::size_t>(part)]);
  for (const Image& image : images_)
    if (status) status = file->write(image.bytes);
  return status ? file->commit() : status;
}

}  // namespace tremolo
