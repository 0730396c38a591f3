#include "formats/surface/surface_answer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_set>

#include "formats/file/scanner.h"
#include "formats/surface/flat_rig.h"

namespace tremolo {
namespace {

// The answer: magic, kind, then of a refusal its text; of a surface
//   f64 metres_per_unit, text unit, text format, texts notes, objects, materials,
//   u32 channels, u64 s, u64 t, vertices, triangles, normals, uvs, colours, sources, object_of,
//   material_of, and if there is a rig the arrays of a FlatRig, each behind its u64 length,
// in this machine's byte order. A text is u32 length and bytes; texts are u32 count and texts.
constexpr std::uint32_t kMagic = 0x46525354;  // "TSRF"
constexpr std::uint32_t kRefusal = 0;
constexpr std::uint32_t kSurface = 1;

constexpr std::uint32_t kNormals = 1;
constexpr std::uint32_t kUvs = 2;
constexpr std::uint32_t kColours = 4;
constexpr std::uint32_t kSources = 8;
constexpr std::uint32_t kRig = 16;

class Writer {
 public:
  template <class T>
  void number(T value) {
    numbers(&value, 1);
  }
  template <class T>
  void numbers(const T* values, std::size_t count) {
    const auto* begin = reinterpret_cast<const std::byte*>(values);
    bytes.insert(bytes.end(), begin, begin + count * sizeof(T));
  }
  void text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    numbers(value.data(), value.size());
  }
  void texts(const std::vector<std::string>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    for (const std::string& value : values) text(value);
  }

  std::vector<std::byte> bytes;
};

// Each returns false and leaves scanner.error() or `problem`.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes)
      : bytes_(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
        scanner_(bytes_, "the reader's answer", 0, false) {}

  template <class T>
  bool number(T& value) {
    return scanner_.read(value, "a number");
  }

  template <class T>
  bool rows(std::vector<T>& values, std::uint64_t count) {
    if (!scanner_.fits(count, sizeof(T), "values")) return false;
    values.resize(count);
    if (count > 0)
      std::memcpy(static_cast<void*>(values.data()), bytes_.data() + scanner_.offset(),
                  count * sizeof(T));
    return scanner_.skip(count, sizeof(T), "values");
  }

  bool text(std::string& value, std::size_t longest) {
    std::uint32_t length = 0;
    if (!number(length) || !scanner_.fits(length, 1, "a text")) return false;
    const std::string_view found = bytes_.substr(scanner_.offset(), length);
    if (!is_printable_text(found, longest)) return fail("a text that cannot be printed");
    value = found;
    return scanner_.skip(length, 1, "a text");
  }

  bool texts(std::vector<std::string>& values, std::size_t longest) {
    std::uint32_t count = 0;
    if (!number(count) || !scanner_.fits(count, sizeof(std::uint32_t), "texts")) return false;
    for (std::uint32_t i = 0; i < count; ++i)
      if (!text(values.emplace_back(), longest)) return false;
    return true;
  }

  bool names(std::vector<std::string>& values) {
    if (!texts(values, kLongestName)) return false;
    const std::unordered_set<std::string_view> once(values.begin(), values.end());
    if (values.empty() || once.size() != values.size())
      return fail("names that are none or not each once");
    return true;
  }

  bool at_end() { return scanner_.remaining() == 0 || fail("bytes behind its end"); }
  bool fail(const char* what) {
    error_ = scanner_.problem(what);
    return false;
  }
  Error error() const { return error_.message.empty() ? scanner_.error() : error_; }

 private:
  std::string_view bytes_;
  ByteScanner scanner_;
  Error error_;
};

template <class Row>
bool all_finite(const std::vector<Row>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.allFinite(); });
}

bool all_below(const std::vector<std::uint32_t>& values, std::size_t bound) {
  return std::all_of(values.begin(), values.end(),
                     [bound](std::uint32_t value) { return value < bound; });
}

bool indices_hold(const RenderSurface& surface) {
  const auto s = static_cast<VertexId>(surface.vertices.size());
  for (const Triangle& triangle : surface.triangles)
    for (const VertexId v : triangle)
      if (v < 0 || v >= s) return false;
  return all_below(surface.object_of, surface.objects.size()) &&
         all_below(surface.material_of, surface.materials.size());
}

bool normals_hold(const RenderSurface& surface) {
  // A float's rounding leaves 1e-7.
  return std::all_of(surface.normals.begin(), surface.normals.end(),
                     [](const Eigen::Vector3f& n) { return std::abs(n.norm() - 1.0F) < 1e-4F; });
}

template <class T>
bool read_array(Reader& reader, std::vector<T>& values) {
  std::uint64_t count = 0;
  return reader.number(count) && reader.rows(values, count);
}
bool read_array(Reader& reader, std::string& text) {
  std::vector<char> values;
  if (!read_array(reader, values)) return false;
  text.assign(values.begin(), values.end());
  return true;
}

bool read_rig(Reader& reader, RenderSurface& surface) {
  FlatRig flat;
  if (!read_array(reader, flat.names) || !read_array(reader, flat.parents) ||
      !read_array(reader, flat.ends) || !read_array(reader, flat.places) ||
      !read_array(reader, flat.weights) || !read_array(reader, flat.clip_names) ||
      !read_array(reader, flat.clip_frames) || !read_array(reader, flat.clip_times) ||
      !read_array(reader, flat.clip_poses))
    return false;
  surface.rig = unflatten(flat, surface.vertices.size());
  return surface.rig != nullptr || reader.fail("bones that do not fit each other or the surface");
}

bool read_surface_values(Reader& reader, RenderSurface& surface) {
  std::uint32_t channels = 0;
  std::uint64_t s = 0;
  std::uint64_t t = 0;
  if (!reader.number(channels) || !reader.number(s) || !reader.number(t)) return false;
  if (channels > (kNormals | kUvs | kColours | kSources | kRig))
    return reader.fail("unknown channels");
  if (t == 0) return reader.fail("no triangles");
  constexpr std::uint64_t kMost = std::numeric_limits<VertexId>::max();
  if (s > kMost || t > kMost) return reader.fail("more vertices or triangles than have numbers");
  const auto with = [channels](std::uint32_t channel, std::uint64_t count) {
    return (channels & channel) != 0 ? count : 0;
  };
  return reader.rows<Eigen::Vector3d>(surface.vertices, s) &&
         reader.rows<Triangle>(surface.triangles, t) &&
         reader.rows<Eigen::Vector3f>(surface.normals, with(kNormals, s)) &&
         reader.rows<Eigen::Vector2f>(surface.uvs, with(kUvs, s)) &&
         reader.rows<Colour>(surface.colours, with(kColours, s)) &&
         reader.rows<VertexId>(surface.sources, with(kSources, s)) &&
         reader.rows<std::uint32_t>(surface.object_of, t) &&
         reader.rows<std::uint32_t>(surface.material_of, t) &&
         ((channels & kRig) == 0 || read_rig(reader, surface)) && reader.at_end();
}

bool read_file_values(Reader& reader, SurfaceFile& file) {
  RenderSurface& surface = file.surface;
  if (!reader.number(file.metres_per_unit) || !reader.text(file.unit, kLongestName) ||
      !reader.text(file.format, kLongestName) || !reader.texts(file.notes, kLongestMessage) ||
      !reader.names(surface.objects) || !reader.names(surface.materials) ||
      !read_surface_values(reader, surface))
    return false;
  if (!std::isfinite(file.metres_per_unit)) return reader.fail("a unit that is no number");
  if (!indices_hold(surface) || !surface.sources_hold())
    return reader.fail("an index out of range");
  if (!all_finite(surface.vertices) || !all_finite(surface.uvs) || !normals_hold(surface))
    return reader.fail("a coordinate that is no number");
  return true;
}

}  // namespace

std::vector<std::byte> encode_refusal(std::string_view message) {
  Writer writer;
  writer.number(kMagic);
  writer.number(kRefusal);
  writer.text(printable_text(message, kLongestMessage));
  return std::move(writer.bytes);
}

std::vector<std::byte> encode_surface(const SurfaceFile& file) {
  const RenderSurface& surface = file.surface;
  Writer writer;
  writer.bytes.reserve(4096 + surface.vertices.size() * 48 + surface.triangles.size() * 20);
  writer.number(kMagic);
  writer.number(kSurface);
  writer.number(file.metres_per_unit);
  writer.text(file.unit);
  writer.text(file.format);
  writer.texts(file.notes);
  writer.texts(surface.objects);
  writer.texts(surface.materials);
  writer.number((surface.normals.empty() ? 0 : kNormals) | (surface.uvs.empty() ? 0 : kUvs) |
                (surface.colours.empty() ? 0 : kColours) |
                (surface.sources.empty() ? 0 : kSources) | (surface.rig == nullptr ? 0 : kRig));
  writer.number(std::uint64_t{surface.vertices.size()});
  writer.number(std::uint64_t{surface.triangles.size()});
  writer.numbers(surface.vertices.data(), surface.vertices.size());
  writer.numbers(surface.triangles.data(), surface.triangles.size());
  writer.numbers(surface.normals.data(), surface.normals.size());
  writer.numbers(surface.uvs.data(), surface.uvs.size());
  writer.numbers(surface.colours.data(), surface.colours.size());
  writer.numbers(surface.sources.data(), surface.sources.size());
  writer.numbers(surface.object_of.data(), surface.object_of.size());
  writer.numbers(surface.material_of.data(), surface.material_of.size());
  if (surface.rig != nullptr) {
    const FlatRig flat = flatten(*surface.rig);
    const auto add = [&writer](const auto& values) {
      writer.number(std::uint64_t{values.size()});
      writer.numbers(values.data(), values.size());
    };
    add(flat.names);
    add(flat.parents);
    add(flat.ends);
    add(flat.places);
    add(flat.weights);
    add(flat.clip_names);
    add(flat.clip_frames);
    add(flat.clip_times);
    add(flat.clip_poses);
  }
  return std::move(writer.bytes);
}

Result<SurfaceFile> decode_surface(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  std::uint32_t magic = 0;
  std::uint32_t kind = 0;
  if (!reader.number(magic) || !reader.number(kind)) return reader.error();
  if (magic != kMagic || kind > kSurface) {
    reader.fail("not the beginning of an answer");
    return reader.error();
  }
  if (kind == kRefusal) {
    std::string message;
    if (!reader.text(message, kLongestMessage) || !reader.at_end()) return reader.error();
    if (message.find_first_not_of(' ') == std::string::npos) {
      reader.fail("a refusal without words");
      return reader.error();
    }
    return content_error(message);
  }
  SurfaceFile file;
  if (!read_file_values(reader, file)) return reader.error();
  return file;
}

}  // namespace tremolo
