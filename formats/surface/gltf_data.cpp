#include "formats/surface/gltf_data.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/file/base64.h"

namespace tremolo {
namespace {

using nlohmann::json;

constexpr std::int64_t kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                       kUnsignedInt = 5125;

std::uint64_t component_bytes(std::int64_t type) {
  switch (type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kGltfFloat:
      return 4;
    default:
      return 0;
  }
}

template <class T>
float component(const char* bytes, bool normalised) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  const auto number = static_cast<float>(value);
  if constexpr (std::is_integral_v<T>)
    if (normalised)
      return std::max(number / static_cast<float>(std::numeric_limits<T>::max()), -1.0F);
  return number;
}

// glTF is little-endian, as are the machines that this runs on; a test of the box would show
// others.
float component_of(const char* bytes, std::int64_t type, bool normalised) {
  switch (type) {
    case kByte:
      return component<std::int8_t>(bytes, normalised);
    case kUnsignedByte:
      return component<std::uint8_t>(bytes, normalised);
    case kShort:
      return component<std::int16_t>(bytes, normalised);
    case kUnsignedShort:
      return component<std::uint16_t>(bytes, normalised);
    case kUnsignedInt:
      return component<std::uint32_t>(bytes, normalised);
    default:
      return component<float>(bytes, false);
  }
}

std::int64_t columns_of(const std::string& type) {
  static const std::map<std::string, std::int64_t> kColumns = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
  const auto found = kColumns.find(type);
  return found == kColumns.end() ? 0 : found->second;
}

const json* entry_at(const json& list, std::int64_t index) {
  if (index < 0 || std::cmp_greater_equal(index, list.size())) return nullptr;
  return list[static_cast<std::size_t>(index)].is_object() ? &list[static_cast<std::size_t>(index)]
                                                           : nullptr;
}

// Escapes of a URI, as in "my%20mesh.bin".
std::string without_escapes(const std::string& uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 2]))) {
      name += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      name += uri[i];
    }
  }
  return name;
}

}  // namespace

std::int64_t gltf_integer(const json& object, const char* key, std::int64_t otherwise) {
  if (!object.is_object()) return otherwise;
  const auto found = object.find(key);
  return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>()
                                                             : otherwise;
}

std::string gltf_text(const json& object, const char* key) {
  if (!object.is_object()) return {};
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

const json& gltf_list(const json& object, const char* key) {
  static const json kNone = json::array();
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : kNone;
}

Result<GltfData::Layout> GltfData::layout(const json& accessor) const {
  Layout layout;
  layout.component = gltf_integer(accessor, "componentType", 0);
  layout.columns = columns_of(gltf_text(accessor, "type"));
  const std::int64_t count = gltf_integer(accessor, "count", 0);
  const auto normalised = accessor.find("normalized");
  layout.normalised = normalised != accessor.end() && normalised->is_boolean() && *normalised;
  if (component_bytes(layout.component) == 0 || layout.columns == 0 || count <= 0)
    return content_error("an accessor has a type or a count that cannot be");
  layout.count = static_cast<std::uint64_t>(count);
  return layout;
}

Result<std::string_view> GltfData::buffer(std::int64_t index) {
  const json* entry = entry_at(gltf_list(document_, "buffers"), index);
  if (entry == nullptr) return content_error("buffer " + std::to_string(index) + " does not exist");
  const std::string uri = gltf_text(*entry, "uri");
  if (uri.empty()) {
    if (index == 0 && !binary_.empty()) return binary_;
    return content_error("buffer " + std::to_string(index) + " has no data");
  }
  const auto [at, fresh] = loaded_.try_emplace(index);
  if (!fresh) return std::string_view(at->second);
  constexpr std::string_view kMark = ";base64,";
  if (uri.starts_with("data:")) {
    const std::size_t begin = uri.find(kMark);
    if (begin != std::string::npos)
      at->second = decode_base64(std::string_view(uri).substr(begin + kMark.size())).bytes;
  } else {
    at->second = open_(without_escapes(uri));
  }
  return std::string_view(at->second);
}

Result<std::string_view> GltfData::rows(const json& holder, std::uint64_t count, std::uint64_t row,
                                        std::uint64_t& stride) {
  const json* view =
      entry_at(gltf_list(document_, "bufferViews"), gltf_integer(holder, "bufferView", -1));
  const std::int64_t offset = gltf_integer(holder, "byteOffset", 0);
  if (view == nullptr || offset < 0) return content_error("an accessor has no data");
  const Result<std::string_view> bytes = buffer(gltf_integer(*view, "buffer", -1));
  if (!bytes) return bytes.error();
  const std::int64_t begin = gltf_integer(*view, "byteOffset", 0);
  const std::int64_t length = gltf_integer(*view, "byteLength", 0);
  stride = static_cast<std::uint64_t>(gltf_integer(*view, "byteStride", 0));
  if (stride == 0) stride = row;
  const std::uint64_t size = bytes->size();
  const bool good = begin >= 0 && length >= 0 && std::cmp_less_equal(begin, size) &&
                    std::cmp_less_equal(length, size - static_cast<std::uint64_t>(begin)) &&
                    offset <= length && stride >= row && stride < (1U << 16U) &&
                    count <= (std::uint64_t{1} << 40U) &&
                    std::cmp_less_equal((count - 1) * stride + row, length - offset);
  if (!good) return content_error("an accessor reaches beyond the end of its buffer");
  return bytes->substr(static_cast<std::size_t>(begin + offset),
                       static_cast<std::size_t>((count - 1) * stride + row));
}

Status GltfData::apply_sparse(const json& sparse, const Layout& layout, GltfValues& values) {
  const std::int64_t count = gltf_integer(sparse, "count", 0);
  if (count <= 0 || !sparse.contains("indices") || !sparse.contains("values"))
    return content_error("a sparse accessor has no entries");
  const std::int64_t type = gltf_integer(sparse["indices"], "componentType", 0);
  const std::uint64_t index_bytes = component_bytes(type);
  if (index_bytes == 0 || type == kGltfFloat)
    return content_error("a sparse accessor has indices of a type that cannot be");
  const std::uint64_t part = component_bytes(layout.component);
  std::uint64_t index_stride = 0, value_stride = 0;
  const auto indices =
      rows(sparse["indices"], static_cast<std::uint64_t>(count), index_bytes, index_stride);
  if (!indices) return indices.error();
  const auto entries = rows(sparse["values"], static_cast<std::uint64_t>(count),
                            part * static_cast<std::uint64_t>(layout.columns), value_stride);
  if (!entries) return entries.error();
  for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(count); ++k) {
    // 32 bits are read as they are: a float would round them.
    std::uint64_t row = 0;
    std::memcpy(&row, indices->data() + k * index_stride, index_bytes);
    if (row >= layout.count) return content_error("a sparse accessor has an index out of range");
    for (std::int64_t c = 0; c < layout.columns; ++c)
      values.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(layout.columns) +
                    static_cast<std::size_t>(c)] =
          component_of(entries->data() + k * value_stride + static_cast<std::uint64_t>(c) * part,
                       layout.component, layout.normalised);
  }
  return Success{};
}

Result<GltfValues> GltfData::values(std::int64_t index) {
  const json* accessor = entry_at(gltf_list(document_, "accessors"), index);
  if (accessor == nullptr)
    return content_error("accessor " + std::to_string(index) + " does not exist");
  const Result<Layout> found = layout(*accessor);
  if (!found) return found.error();
  const std::uint64_t part = component_bytes(found->component);
  GltfValues values{found->columns, {}};
  const auto columns = static_cast<std::uint64_t>(found->columns);
  if (accessor->contains("bufferView")) {
    std::uint64_t stride = 0;
    const auto bytes = rows(*accessor, found->count, part * columns, stride);
    if (!bytes) return bytes.error();
    values.values.reserve(found->count * columns);
    for (std::uint64_t k = 0; k < found->count; ++k)
      for (std::uint64_t c = 0; c < columns; ++c)
        values.values.push_back(component_of(bytes->data() + k * stride + c * part,
                                             found->component, found->normalised));
  } else {
    // All values are zero, except sparse ones: no data would limit the count.
    if (found->count > (1U << 24U)) return content_error("an accessor has no data");
    values.values.assign(found->count * columns, 0.0F);
  }
  if (const auto sparse = accessor->find("sparse");
      sparse != accessor->end() && sparse->is_object())
    if (Status s = apply_sparse(*sparse, *found, values); !s) return s.error();
  return values;
}

}  // namespace tremolo
