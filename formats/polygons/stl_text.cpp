#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <utility>

#include "formats/file/scanner.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

constexpr std::size_t kHeaderBytes = 80, kCountBytes = 4, kFacetBytes = 50;

bool same_word(std::string_view text, std::string_view lower) {
  return std::equal(text.begin(), text.end(), lower.begin(), lower.end(), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

std::string_view trimmed_name(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

// Each triangle gets its own vertices and normal.
void add_corners(PolygonMesh& mesh, const std::vector<Eigen::Vector3d>& corners,
                 const Eigen::Vector3f& normal, std::uint32_t object) {
  const auto entry = static_cast<std::int32_t>(mesh.normals.size());
  mesh.normals.push_back(normal);
  for (const Eigen::Vector3d& x : corners) {
    mesh.corners.push_back({static_cast<VertexId>(mesh.vertices.size()), kNoEntry, entry});
    mesh.vertices.push_back(x);
  }
  mesh.end_polygon(object, 0);
}

class StlText {
 public:
  StlText(std::string_view text, const std::string& name)
      : scanner_(text, name, {.open_end = true}) {
    mesh_.materials = {""};
  }

  // True if the first words are those of a text file.
  static bool opens(std::string_view bytes) {
    TextScanner scanner(bytes, "");
    if (!same_word(scanner.token(), "solid")) return false;
    const std::string_view line = scanner.rest_of_line();
    if (facet_in(line) != line.npos) return true;
    const std::string_view next = scanner.token();
    return same_word(next, "facet") || same_word(next, "endsolid") || same_word(next, "color");
  }

  Result<PolygonMesh> parse() {
    while (!scanner_.at_end()) {
      const std::string_view word = scanner_.token();
      const bool good = same_word(word, "solid")      ? solid()
                        : same_word(word, "facet")    ? facet()
                        : same_word(word, "endsolid") ? skip_line()
                        : same_word(word, "color")    ? skip_line()
                                                      : fail("solid, facet or endsolid", word);
      if (!good) return scanner_.error();
    }
    return std::move(mesh_);
  }

 private:
  // Where "facet normal NUMBER" begins in a line: a text without line ends has no names to their
  // end.
  static std::size_t facet_in(std::string_view line) {
    TextScanner scanner(line, "", {.lines = true, .open_end = true});
    while (!scanner.at_line_end()) {
      if (!same_word(scanner.token(), "facet")) continue;
      const std::size_t begin = scanner.offset() - 5;
      if (!same_word(scanner.peek(), "normal")) continue;
      scanner.token();
      double number = 0.0;
      if (scanner.read(number, "") && scanner.read(number, "") && scanner.read(number, "") &&
          same_word(scanner.token(), "outer"))
        return begin;
    }
    return std::string_view::npos;
  }

  bool fail(std::string_view expected, std::string_view found) {
    return scanner_.fail(expected, found);
  }
  bool expect(const char* word) {
    const std::string_view found = scanner_.token();
    return same_word(found, word) || fail(word, found);
  }
  bool skip_line() {
    const std::size_t begin = scanner_.offset();
    const std::string_view line = scanner_.rest_of_line();
    // On a text's only line the next solid follows.
    const std::size_t next = line.find(" solid ");
    if (next != std::string_view::npos && facet_in(line) != std::string_view::npos)
      scanner_.seek(begin + next);
    return true;
  }

  bool solid() {
    const std::size_t begin = scanner_.offset();
    std::string_view line = scanner_.rest_of_line();
    if (const std::size_t facet = facet_in(line); facet != std::string_view::npos) {
      scanner_.seek(begin + facet);
      line = line.substr(0, facet);
    }
    mesh_.objects.emplace_back(trimmed_name(line));
    return true;
  }

  bool facet() {
    if (mesh_.objects.empty()) mesh_.objects.emplace_back();
    Eigen::Vector3d normal;
    if (!expect("normal") || !vector(normal) || !expect("outer") || !expect("loop")) return false;
    corners_.clear();
    for (;;) {
      const std::string_view word = scanner_.token();
      if (same_word(word, "endloop")) break;
      if (!same_word(word, "vertex")) return fail("vertex or endloop", word);
      if (!vector(corners_.emplace_back())) return false;
    }
    add_corners(mesh_, corners_, normal.cast<float>(),
                static_cast<std::uint32_t>(mesh_.objects.size() - 1));
    return expect("endfacet");
  }

  bool vector(Eigen::Vector3d& x) {
    return scanner_.read(x[0], "a number") && scanner_.read(x[1], "a number") &&
           scanner_.read(x[2], "a number");
  }

  TextScanner scanner_;
  PolygonMesh mesh_;
  std::vector<Eigen::Vector3d> corners_;
};

// Fifteen bits of a colour; red is the high part for VisCAM, the low part for Materialise.
Colour colour_of(std::uint16_t bits, bool materialise) {
  const auto part = [bits](int at) {
    return static_cast<std::uint8_t>(((bits >> at) & 31) * 255 / 31);
  };
  return materialise ? Colour{part(0), part(5), part(10), 255}
                     : Colour{part(10), part(5), part(0), 255};
}

Result<PolygonMesh> parse_bytes(std::string_view bytes, const std::string& name,
                                std::uint64_t count) {
  PolygonMesh mesh;
  mesh.objects = mesh.materials = {""};
  const std::size_t mark = bytes.substr(0, kHeaderBytes).find("COLOR=");
  const bool materialise = mark != std::string_view::npos && mark + 10 <= kHeaderBytes;
  Colour plain = {153, 153, 153, 255};
  if (materialise)
    for (std::size_t k = 0; k < 4; ++k) plain[k] = static_cast<std::uint8_t>(bytes[mark + 6 + k]);
  ByteScanner scanner(bytes, name, kHeaderBytes + kCountBytes, kSwapsLittleEndian);
  std::vector<Colour> colours;
  bool painted = false;
  std::vector<Eigen::Vector3d> corners(3);
  for (std::uint64_t t = 0; t < count; ++t) {
    std::array<float, 12> values{};
    for (float& value : values)
      if (!scanner.read(value, "a number")) return scanner.error();
    std::uint16_t attribute = 0;
    if (!scanner.read(attribute, "two bytes")) return scanner.error();
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = Eigen::Vector3f(values.data() + 3 + 3 * k).cast<double>();
    add_corners(mesh, corners, Eigen::Vector3f(values.data()), 0);
    // The highest bit means that there is a colour; for Materialise, that there is none.
    const bool own = ((attribute >> 15) != 0) != materialise;
    painted |= (attribute >> 15) != 0 || (materialise && attribute != 0);
    colours.insert(colours.end(), 3, own ? colour_of(attribute, materialise) : plain);
  }
  if (painted) mesh.colours = std::move(colours);
  if (scanner.remaining() > 0)
    mesh.notes.push_back(std::to_string(scanner.remaining()) + " bytes behind the last of " +
                         std::to_string(count) + " triangles are not read");
  return mesh;
}

}  // namespace

Result<PolygonMesh> parse_stl_polygons(std::string_view bytes, const std::string& name) {
  std::uint32_t count = 0;
  const bool headed = bytes.size() >= kHeaderBytes + kCountBytes;
  if (headed) {
    ByteScanner scanner(bytes, name, kHeaderBytes, kSwapsLittleEndian);
    scanner.read(count, "the number of triangles");
  }
  const std::uint64_t needed = kHeaderBytes + kCountBytes + std::uint64_t{count} * kFacetBytes;
  const bool exact = headed && bytes.size() == needed && count > 0;
  if (!exact && StlText::opens(bytes)) return StlText(bytes, name).parse();
  if (headed && bytes.size() >= needed && count > 0) return parse_bytes(bytes, name, count);
  return content_error(
      name +
      ": it is neither STL as text nor binary STL of as many triangles as it says; "
      "it may be cut off");
}

}  // namespace tremolo
