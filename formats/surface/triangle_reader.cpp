#include "formats/surface/triangle_reader.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/index.h"
#include "formats/file/text_scanner.h"
#include "formats/file/whole_file.h"
#include "formats/surface/ply_header.h"

namespace tremolo {
namespace {

// Numbers of an .obj's corner count from 1, or from the end where they are negative.
bool obj_corner(TextScanner& scanner, std::size_t vertices, std::vector<VertexId>& polygon) {
  const std::string_view token = scanner.token();
  const std::string_view digits = token.substr(0, token.find('/'));
  std::int64_t number = 0;
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (code != std::errc{} || end != digits.data() + digits.size())
    return scanner.fail("a corner's vertex", token);
  if (number < 0) number += static_cast<std::int64_t>(vertices) + 1;
  if (!is_index(number - 1, vertices))
    return scanner.fail("a vertex from 1 to " + std::to_string(vertices), token);
  polygon.push_back(static_cast<VertexId>(number - 1));
  return true;
}

// Empty if it is a polygon.
std::string polygon_problem(const std::vector<VertexId>& polygon) {
  if (polygon.size() < 3) return "a face of fewer than three corners";
  for (std::size_t i = 0; i < polygon.size(); ++i)
    for (std::size_t k = i + 1; k < polygon.size(); ++k)
      if (polygon[i] == polygon[k]) return "a corner stands twice in a face";
  return {};
}

void add_fan(const std::vector<VertexId>& polygon, SurfaceMesh& mesh) {
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
    mesh.triangles.push_back({polygon[0], polygon[k], polygon[k + 1]});
}

Result<SurfaceMesh> named(Result<SurfaceMesh> mesh, const std::string& name) {
  if (mesh && mesh->triangles.empty()) return content_error(name + ": it has no triangles");
  return mesh;
}

// A list's length above this is taken for damage.
constexpr std::uint64_t kMostCorners = 1U << 16U;

// The body of a .ply behind its header. Numbers: PlyNumbers<text or bytes>.
template <class Numbers>
Result<SurfaceMesh> ply_body(Numbers& numbers, const PlyHeader& header, const std::string& name) {
  SurfaceMesh mesh;
  std::vector<VertexId> polygon;
  for (const PlyElement& element : header.elements)
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Eigen::Vector3d place = Eigen::Vector3d::Constant(std::nan(""));
      polygon.clear();
      bool face = false;
      for (const PlyProperty& property : element.properties) {
        double value = 0.0;
        if (!property.list) {
          if (!numbers.read(property.type, value)) return numbers.error(name);
          if (property.axis >= 0) place[property.axis] = value;
          continue;
        }
        double count = 0.0;
        if (!numbers.read(property.count_type, count)) return numbers.error(name);
        if (!(count >= 0.0) || count > static_cast<double>(kMostCorners))
          return content_error(name + ": a list of " + element.name + " " + std::to_string(i) +
                               " has a length that cannot be");
        for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(count); ++k) {
          if (!numbers.read(property.type, value)) return numbers.error(name);
          if (!property.corners) continue;
          if (!(value >= 0.0) || !(value < static_cast<double>(mesh.vertices.size())))
            return content_error(name + ": face " + std::to_string(i) +
                                 " has a corner that is no vertex");
          polygon.push_back(static_cast<VertexId>(value));
        }
        face = face || property.corners;
      }
      if (element.name == "vertex") {
        if (!place.allFinite())
          return content_error(name + ": vertex " + std::to_string(i) + " is not finite");
        mesh.vertices.push_back(place);
      }
      if (!face) continue;
      if (const std::string problem = polygon_problem(polygon); !problem.empty())
        return content_error(name + ": face " + std::to_string(i) + ": " + problem);
      add_fan(polygon, mesh);
    }
  return mesh;
}

bool ends_in(const std::string& path, std::string_view ending) {
  return path.size() > ending.size() && path.ends_with(ending);
}

}  // namespace

Result<SurfaceMesh> parse_obj(std::string_view text, const std::string& name) {
  TextScanner scanner(text, name, {.comment = '#', .lines = true, .open_end = true});
  SurfaceMesh mesh;
  std::vector<VertexId> polygon;
  for (bool more = !scanner.at_end(); more; more = scanner.next_line()) {
    const std::string_view word = scanner.token();
    if (word == "v") {
      Eigen::Vector3d place;
      for (int k = 0; k < 3; ++k)
        if (!scanner.read(place[k], "a coordinate")) return scanner.error();
      if (!place.allFinite()) return scanner.problem("a coordinate is not finite");
      if (mesh.vertices.size() >= std::numeric_limits<VertexId>::max())
        return scanner.problem("too many vertices");
      mesh.vertices.push_back(place);
    } else if (word == "f") {
      polygon.clear();
      while (!scanner.at_line_end())
        if (!obj_corner(scanner, mesh.vertices.size(), polygon)) return scanner.error();
      if (const std::string problem = polygon_problem(polygon); !problem.empty())
        return scanner.problem(problem);
      add_fan(polygon, mesh);
    }
  }
  return named(std::move(mesh), name);
}

Result<SurfaceMesh> parse_ply(std::string_view bytes, const std::string& name) {
  const Result<PlyHeader> header = parse_ply_header(bytes, name);
  if (!header) return header.error();
  PlyNumbers numbers(bytes.substr(header->size), header->form, header->size);
  return named(ply_body(numbers, *header, name), name);
}

Result<SurfaceMesh> read_surface_triangles(const std::string& path) {
  const bool obj = ends_in(path, ".obj") || ends_in(path, ".OBJ");
  if (!obj && !ends_in(path, ".ply") && !ends_in(path, ".PLY"))
    return usage_error(path + ": its ending must be .obj or .ply");
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return obj ? parse_obj(*text, path) : parse_ply(*text, path);
}

}  // namespace tremolo
