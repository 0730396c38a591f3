#include "formats/polygons/off_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "formats/file/scanner.h"

namespace tremolo {
namespace {

// Normal, colour and texture coordinates, and some to spare.
constexpr std::size_t kMostExtras = 12;
// Missing parts of a colour.
constexpr OffNumbers kNotGiven = {-1, -1, -1, -1};

struct Extras {
  std::array<double, kMostExtras> values{};
  std::size_t count = 0;
};

// The letters before OFF.
struct Channels {
  bool texture = false;
  bool colour = false;
  bool normal = false;
  bool any() const { return texture || colour || normal; }
};

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

// False if the letters are no prefix of OFF that is read.
bool parse_channels(std::string_view letters, Channels& channels) {
  while (!letters.empty()) {
    bool* channel = nullptr;
    std::size_t length = 1;
    if (letters.starts_with("ST")) {
      channel = &channels.texture;
      length = 2;
    } else if (letters.front() == 'C') {
      channel = &channels.colour;
    } else if (letters.front() == 'N') {
      channel = &channels.normal;
    }
    if (channel == nullptr || *channel) return false;
    *channel = true;
    letters.remove_prefix(length);
  }
  return true;
}

// Parts are of 255 if one of them is above 1; missing ones are 1.
void scale_colours(std::vector<OffNumbers>& colours) {
  float most = 0;
  for (const OffNumbers& colour : colours)
    for (const float part : colour) most = std::max(most, part);
  const float whole = most > 1 ? 255 : 1;
  for (OffNumbers& colour : colours)
    for (float& part : colour) part = part < 0 ? 1 : part / whole;
}

class Parser {
 public:
  explicit Parser(std::string_view text) : scanner_(text, "", {.comment = '#', .open_end = true}) {}

  Result<OffMesh> parse() {
    if (!read_header() || !read_counts() || !read_vertices() || !read_faces()) return error();
    if (!scanner_.at_end())
      mesh_.notes.emplace_back("what stands behind the last of " + std::to_string(faces_) +
                               " faces is not read");
    if (extras_left_)
      mesh_.notes.emplace_back(
          "numbers behind the coordinates left out: a file that begins with OFF has none (COFF: "
          "colours, NOFF: normals, STOFF: texture coordinates)");
    if (face_extras_left_)
      mesh_.notes.emplace_back(
          "numbers behind the corners of faces left out: a colour has three or four");
    scale_colours(mesh_.colours);
    scale_colours(mesh_.face_colours);
    if (!channels_.colour) mesh_.colours.clear();
    if (!painted_) mesh_.face_colours.clear();
    return std::move(mesh_);
  }

 private:
  // "line 12: expected ...", without the name of a file.
  Error error() const {
    Error error = scanner_.error().message.empty() ? error_ : scanner_.error();
    if (error.message.starts_with(", ")) error.message.erase(0, 2);
    return error;
  }
  bool fail(const std::string& what) {
    error_ = scanner_.problem(what);
    return false;
  }

  bool read_header();
  bool read_counts();
  bool read_vertices();
  bool read_faces();
  bool read_vertex();
  bool read_face();
  bool read_coordinate(std::string_view& written);
  bool read_extras(Extras& extras);
  bool take_extras(const Extras& extras);
  bool cut_off(const char* what, std::uint64_t done, std::uint64_t wanted);

  TextScanner scanner_;
  Error error_;
  OffMesh mesh_;
  Channels channels_;
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
  bool vertices_known_ = false;
  bool extras_left_ = false;
  bool face_extras_left_ = false;
  bool painted_ = false;
};

bool Parser::read_header() {
  const std::string_view next = scanner_.peek();
  // The counts may follow directly.
  if (!next.empty() && std::isdigit(static_cast<unsigned char>(next.front())) != 0 &&
      upper(next).find("OFF") == std::string::npos)
    return true;
  const std::string_view written = scanner_.token();
  const std::string word = upper(written);
  const std::size_t at = word.find("OFF");
  const std::string digits = at == std::string::npos ? "" : word.substr(at + 3);
  // A small n is a number of dimensions.
  if (word.find("4OFF") != std::string::npos || written.find("nOFF") != std::string_view::npos)
    return fail("expected three dimensions, found " + quoted_text(written));
  if (at == std::string::npos || !parse_channels(std::string_view(word).substr(0, at), channels_))
    return fail("expected OFF, COFF, NOFF, STOFF or what combines them, found " +
                quoted_text(written));
  // "OFF490 518 0" is in circulation.
  if (!digits.empty()) {
    const auto [end, code] =
        std::from_chars(digits.data(), digits.data() + digits.size(), vertices_);
    if (code != std::errc{} || end != digits.data() + digits.size())
      return fail("expected OFF and a blank, found " + quoted_text(word));
    vertices_known_ = true;
  }
  if (upper(scanner_.peek()) == "BINARY")
    return fail("binary OFF is not read: export it as text, or as PLY");
  return true;
}

bool Parser::read_counts() {
  if (!vertices_known_ && !scanner_.read(vertices_, "the number of vertices")) return false;
  if (!scanner_.read(faces_, "the number of faces")) return false;
  // The number of edges is often wrong, and sometimes left out.
  std::int64_t edges = 0;
  if (!scanner_.at_line_end() && !scanner_.read(edges, "the number of edges")) return false;
  constexpr std::size_t kVertexBytes = 6, kFaceBytes = 2;  // "0 0 0 ", "0 "
  return scanner_.fits(vertices_, kVertexBytes, "vertices") &&
         scanner_.fits(faces_, kFaceBytes, "faces");
}

bool Parser::cut_off(const char* what, std::uint64_t done, std::uint64_t wanted) {
  scanner_.token();
  return fail("the file ends behind " + std::to_string(done) + " of " + std::to_string(wanted) +
              " " + what + ": it may be cut off, or its counts are wrong");
}

bool Parser::read_coordinate(std::string_view& written) {
  double value = 0;
  written = scanner_.peek();
  return scanner_.read(value, "a coordinate");
}

// Reads the remaining numbers of the line.
bool Parser::read_extras(Extras& extras) {
  extras.count = 0;
  while (!scanner_.at_line_end()) {
    double value = 0;
    if (!scanner_.read(value, "a number")) return false;
    if (extras.count == kMostExtras) return fail("expected the end of the line");
    extras.values[extras.count++] = value;
  }
  return true;
}

// The coordinates are followed by a normal, a colour, texture coordinates.
bool Parser::take_extras(const Extras& extras) {
  const std::size_t others = (channels_.normal ? 3 : 0) + (channels_.texture ? 2 : 0);
  const std::size_t parts = extras.count < others ? 0 : extras.count - others;
  const bool good = extras.count >= others && (parts == 0 || parts == 3 || parts == 4);
  if (!good || (parts > 0 && channels_.any() && !channels_.colour))
    return fail("expected " + std::to_string(others) +
                (channels_.colour ? ", and 3 or 4 of a colour," : "") +
                " numbers behind the coordinates of a vertex, found " +
                std::to_string(extras.count));
  if (!channels_.any()) {
    extras_left_ |= parts > 0;
    return true;
  }
  std::size_t at = 0;
  const auto next = [&] { return static_cast<float>(extras.values[at++]); };
  if (channels_.normal) {
    OffNumbers& normal = mesh_.normals.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) normal[i] = next();
  }
  if (channels_.colour) {
    OffNumbers& colour = mesh_.colours.emplace_back(kNotGiven);
    for (std::size_t i = 0; i < parts; ++i) colour[i] = std::max(0.0F, next());
  }
  if (channels_.texture) {
    OffNumbers& uv = mesh_.uvs.emplace_back();
    for (std::size_t i = 0; i < 2; ++i) uv[i] = next();
  }
  return true;
}

bool Parser::read_vertex() {
  auto& written = mesh_.coordinates.emplace_back();
  for (std::string_view& each : written)
    if (!read_coordinate(each)) return false;
  Extras extras;
  return read_extras(extras) && take_extras(extras);
}

bool Parser::read_vertices() {
  for (std::uint64_t v = 0; v < vertices_; ++v) {
    if (scanner_.at_end()) return cut_off("vertices", v, vertices_);
    if (!read_vertex()) return false;
  }
  return true;
}

bool Parser::read_face() {
  std::uint64_t count = 0;
  if (!scanner_.read(count, "a face's number of corners")) return false;
  if (!scanner_.fits(count, 2, "corners")) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t vertex = 0;
    if (!scanner_.read(vertex, "a corner's vertex")) return false;
    if (vertex >= vertices_)
      return fail("expected a vertex from 0 to below " + std::to_string(vertices_) + ", found " +
                  std::to_string(vertex));
    mesh_.corners.push_back(static_cast<VertexId>(vertex));
  }
  mesh_.first.push_back(mesh_.corners.size());
  Extras extras;
  if (!read_extras(extras)) return false;
  OffNumbers colour = kNotGiven;
  if (extras.count == 3 || extras.count == 4) {
    for (std::size_t i = 0; i < extras.count; ++i)
      colour[i] = std::max(0.0F, static_cast<float>(extras.values[i]));
    painted_ = true;
  } else if (extras.count > 0) {
    face_extras_left_ = true;
  }
  mesh_.face_colours.push_back(colour);
  return true;
}

bool Parser::read_faces() {
  for (std::uint64_t f = 0; f < faces_; ++f) {
    if (scanner_.at_end()) return cut_off("faces", f, faces_);
    if (!read_face()) return false;
  }
  return true;
}

}  // namespace

Result<OffMesh> parse_off(std::string_view text) {
  return Parser(text).parse();
}

}  // namespace tremolo
