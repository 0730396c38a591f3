#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "common/text.h"
#include "formats/file/scanner.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

constexpr std::size_t kMostEntries = std::numeric_limits<VertexId>::max();
constexpr std::size_t kMostNumbers = 7;  // of a vertex: position, weight, colour

// Joins lines that a backslash continues, and converts the line ends of old Macs (CR alone) to LF.
// True if the text was changed; lines keep their numbers up to the first joined one.
bool plain_lines(std::string_view text, std::string& changed) {
  const bool old_mac = text.find('\n') == std::string_view::npos && text.find('\r') != text.npos;
  const bool continued =
      text.find("\\\n") != std::string_view::npos || text.find("\\\r") != std::string_view::npos;
  if (!old_mac && !continued) return false;
  changed = text;
  if (old_mac) std::replace(changed.begin(), changed.end(), '\r', '\n');
  for (std::size_t at = changed.find('\\'); at != std::string::npos;
       at = changed.find('\\', at + 1)) {
    const std::size_t end = changed.find_first_not_of('\r', at + 1);
    if (end == std::string::npos || changed[end] != '\n') continue;
    std::fill(changed.begin() + static_cast<std::ptrdiff_t>(at),
              changed.begin() + static_cast<std::ptrdiff_t>(end) + 1, ' ');
  }
  return true;
}

// Names, each once, and the one that is in force.
class NameTable {
 public:
  explicit NameTable(std::vector<std::string>& names) : names_(names) {}

  void choose(std::string_view name) {
    const auto [entry, fresh] =
        known_.try_emplace(std::string(name), static_cast<std::uint32_t>(names_.size()));
    if (fresh) names_.emplace_back(name);
    current_ = entry->second;
    chosen_ = true;
  }
  std::uint32_t current() {
    if (!chosen_) choose({});
    return current_;
  }

 private:
  std::vector<std::string>& names_;
  std::unordered_map<std::string, std::uint32_t> known_;
  std::uint32_t current_ = 0;
  bool chosen_ = false;
};

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& name)
      : scanner_(text, name, {.comment = '#', .lines = true, .open_end = true}),
        objects_(mesh_.objects),
        materials_(mesh_.materials) {}

  Result<PolygonMesh> parse() {
    for (bool more = !scanner_.at_end(); more; more = scanner_.next_line())
      if (!statement(scanner_.token())) return error();
    if (later_ && std::cmp_greater_equal(later_->vertex, mesh_.vertices.size()))
      return later_->error;
    leave_out_unknown();
    if (!mesh_.colours.empty()) mesh_.colours.resize(mesh_.vertices.size(), kWhite);
    return std::move(mesh_);
  }

 private:
  static constexpr Colour kWhite = {255, 255, 255, 255};

  // The largest vertex that a corner has named before it was read, and the error if it never is.
  struct Later {
    std::int64_t vertex;
    Error error;
  };

  Error error() const { return error_.message.empty() ? scanner_.error() : error_; }
  bool fail(const std::string& what) {
    error_ = scanner_.problem(what);
    return false;
  }

  bool statement(std::string_view word) {
    if (word == "v") return vertex();
    if (word == "f" || word == "fo") return face();
    if (word == "vt") return entry(mesh_.uvs, 1);
    if (word == "vn") return entry(mesh_.normals, 3);
    if (word == "p") return count_rest(mesh_.points, 0);
    if (word == "l") return count_rest(mesh_.lines, 1);
    if (word == "o" || word == "g") {
      // `g` without a name keeps the object.
      if (const std::string_view name = rest(); !name.empty()) objects_.choose(name);
    } else if (word == "usemtl") {
      materials_.choose(rest());
    }
    return true;
  }

  // The rest of the line; the scanner stays on this line.
  std::string_view rest() {
    const std::string_view text = scanner_.text();
    const std::size_t end = std::min(text.find('\n', scanner_.offset()), text.size());
    const std::string_view rest = trimmed(text.substr(scanner_.offset(), end - scanner_.offset()));
    scanner_.seek(end);
    return rest;
  }

  bool vertex() {
    std::array<double, kMostNumbers> x{};
    std::size_t count = 0;
    while (count < 3 || (count < kMostNumbers && !scanner_.at_line_end()))
      if (!scanner_.read(x[count++], "a coordinate")) return false;
    if (mesh_.vertices.size() >= kMostEntries) return fail("too many vertices");
    const bool weighted = count == 4 || count == 7;
    const double weight = weighted && x[3] != 0.0 ? x[3] : 1.0;
    mesh_.vertices.emplace_back(x[0] / weight, x[1] / weight, x[2] / weight);
    if (count < 6) return true;
    mesh_.colours.resize(mesh_.vertices.size(), kWhite);
    for (std::size_t k = 0; k < 3; ++k) {
      const double part = std::clamp(x[count - 3 + k], 0.0, 1.0);
      mesh_.colours.back()[k] =
          static_cast<std::uint8_t>(std::isnan(part) ? 0 : std::lround(part * 255.0));
    }
    return true;
  }

  // least: how many numbers there must be; the others are 0.
  template <class Entry>
  bool entry(std::vector<Entry>& entries, int least) {
    Entry values = Entry::Zero();
    for (int k = 0; k < values.size(); ++k) {
      if (k >= least && scanner_.at_line_end()) break;
      double value = 0.0;
      if (!scanner_.read(value, "a number")) return false;
      values[k] = static_cast<float>(value);
    }
    if (entries.size() >= kMostEntries) return fail("too many vt or vn");
    entries.push_back(values);
    return true;
  }

  bool count_rest(std::uint64_t& count, std::uint64_t less) {
    std::uint64_t corners = 0;
    for (; !scanner_.at_line_end(); ++corners) scanner_.token();
    count += corners > less ? corners - less : 0;
    return true;
  }

  // Converts a number of an entry to an index from 0; the entry may follow later. False for other
  // text.
  static bool index_of(std::string_view digits, std::size_t entries, std::int64_t& index) {
    std::int64_t number = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (code != std::errc{} || end != digits.data() + digits.size()) return false;
    index = number < 0 ? number + static_cast<std::int64_t>(entries) : number - 1;
    return true;
  }

  bool face() {
    while (!scanner_.at_line_end())
      if (!corner(scanner_.token())) return false;
    mesh_.end_polygon(objects_.current(), materials_.current());
    return true;
  }

  bool corner(std::string_view token) {
    std::array<std::string_view, 3> parts;  // vertex, vt, vn
    for (std::size_t k = 0, at = 0; k < 3 && at <= token.size(); ++k) {
      const std::size_t end = std::min(token.find('/', at), token.size());
      parts[k] = token.substr(at, end - at);
      at = end + 1;
    }
    std::int64_t vertex = 0;
    if (!index_of(parts[0], mesh_.vertices.size(), vertex))
      return scanner_.fail("a corner's vertex", token);
    const bool known = vertex >= 0 && std::cmp_less(vertex, mesh_.vertices.size());
    if (!known) {
      scanner_.fail("a vertex from 1 to " + std::to_string(mesh_.vertices.size()), token);
      if (vertex < 0 || std::cmp_greater_equal(vertex, kMostEntries)) return false;
      if (!later_ || vertex > later_->vertex) later_ = {vertex, scanner_.error()};
    }
    mesh_.corners.push_back({static_cast<VertexId>(vertex), entry_of(parts[1], mesh_.uvs.size()),
                             entry_of(parts[2], mesh_.normals.size())});
    return true;
  }

  std::int32_t entry_of(std::string_view digits, std::size_t entries) {
    if (digits.empty()) return kNoEntry;
    std::int64_t index = 0;
    const bool good =
        index_of(digits, entries, index) && index >= 0 && std::cmp_less(index, kMostEntries);
    left_out_ += good ? 0 : 1;
    return good ? static_cast<std::int32_t>(index) : kNoEntry;
  }

  void leave_out_unknown() {
    for (PolygonCorner& corner : mesh_.corners) {
      for (auto [index, size] : {std::pair{&corner.uv, mesh_.uvs.size()},
                                 std::pair{&corner.normal, mesh_.normals.size()}})
        if (*index != kNoEntry && std::cmp_greater_equal(*index, size)) {
          *index = kNoEntry;
          ++left_out_;
        }
    }
    if (left_out_ > 0)
      mesh_.notes.push_back(
          std::to_string(left_out_) +
          " texture coordinates or normals of corners left out: they do not exist");
  }

  TextScanner scanner_;
  Error error_;
  PolygonMesh mesh_;
  NameTable objects_, materials_;
  std::optional<Later> later_;
  std::uint64_t left_out_ = 0;
};

}  // namespace

Result<PolygonMesh> parse_obj_polygons(std::string_view text, const std::string& name) {
  std::string changed;
  return ObjParser(plain_lines(text, changed) ? changed : text, name).parse();
}

}  // namespace tremolo
