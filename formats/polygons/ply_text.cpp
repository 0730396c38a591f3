#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "formats/polygons/ply_header.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

constexpr std::size_t kRoles = static_cast<std::size_t>(PlyRole::kStrips) + 1;
constexpr double kStripEnd = -1.0;

// The values of one item by their role; lists of the last kinds.
struct PlyItem {
  std::array<double, kRoles> values{};
  std::vector<double> corners, uvs;

  double at(PlyRole role) const { return values[static_cast<std::size_t>(role)]; }
};

// A part of a colour of this type, as a byte.
std::uint8_t colour_byte(double value, PlyType type) {
  if (type == PlyType::kFloat || type == PlyType::kDouble) value *= 255.0;
  if (type == PlyType::kUint16 || type == PlyType::kInt16) value /= 257.0;
  return static_cast<std::uint8_t>(value > 0.0 ? std::lround(std::min(value, 255.0)) : 0);
}

class PlyBody {
 public:
  PlyBody(PlyNumbers numbers, const PlyHeader& header, const std::string& name)
      : numbers_(numbers), header_(header), name_(name) {
    mesh_.objects = mesh_.materials = {""};
  }

  Result<PolygonMesh> parse() {
    for (const PlyElement& element : header_.elements)
      if (!read_element(element)) return std::move(error_);
    for (std::size_t k = 0; k < mesh_.corners.size(); ++k) {
      if (std::cmp_greater_equal(mesh_.corners[k].vertex, mesh_.vertices.size()))
        return content_error(name_ + ": corner " + std::to_string(k) + " of all faces is vertex " +
                             std::to_string(mesh_.corners[k].vertex) + " of " +
                             std::to_string(mesh_.vertices.size()));
      if (vertex_uvs_) mesh_.corners[k].uv = mesh_.corners[k].vertex;
      if (vertex_normals_) mesh_.corners[k].normal = mesh_.corners[k].vertex;
    }
    return std::move(mesh_);
  }

 private:
  bool fail(const std::string& what) {
    error_ = content_error(name_ + ": " + what);
    return false;
  }

  bool read_number(PlyType type, double& value) {
    if (numbers_.read(type, value)) return true;
    error_ = numbers_.error(name_);
    return false;
  }

  bool read_list(const PlyProperty& property, const std::string& where, std::vector<double>* kept) {
    double count = 0.0;
    if (!read_number(property.count_type, count)) return false;
    // Every entry takes at least a byte.
    if (!(count >= 0.0) || count > static_cast<double>(numbers_.remaining()))
      return fail("a list of " + where + " has a length that cannot be");
    for (std::uint64_t k = 0; k < static_cast<std::uint64_t>(count); ++k) {
      double value = 0.0;
      if (!read_number(property.type, value)) return false;
      if (kept != nullptr) kept->push_back(value);
    }
    return true;
  }

  bool read_element(const PlyElement& element) {
    const auto has = [&element](PlyRole role) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [role](const PlyProperty& property) { return property.role == role; });
    };
    // Ids of vertices are 32 bits.
    if (element.name == "vertex" && element.count > std::numeric_limits<VertexId>::max())
      return fail("too many vertices");
    const bool normals = has(PlyRole::kNormalX) && has(PlyRole::kNormalY) && has(PlyRole::kNormalZ);
    const bool uvs = has(PlyRole::kU) && has(PlyRole::kV);
    const bool colours = has(PlyRole::kRed) && has(PlyRole::kGreen) && has(PlyRole::kBlue);
    PlyItem item;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      item.corners.clear();
      item.uvs.clear();
      item.values[static_cast<std::size_t>(PlyRole::kAlpha)] = 255.0;
      for (const PlyProperty& property : element.properties)
        if (!read_property(element, i, property, item)) return false;
      if (has(PlyRole::kX))
        add_vertex(item, normals, uvs, colours);
      else if (has(PlyRole::kStrips) && !add_strips(item))
        return false;
      else if (has(PlyRole::kCorners) && !add_face(item, i))
        return false;
    }
    return true;
  }

  bool read_property(const PlyElement& element, std::uint64_t i, const PlyProperty& property,
                     PlyItem& item) {
    if (property.list) {
      std::vector<double>* kept = property.role == PlyRole::kCornerUvs ? &item.uvs
                                  : property.role != PlyRole::kNone    ? &item.corners
                                                                       : nullptr;
      return read_list(property, element.name + " " + std::to_string(i), kept);
    }
    double value = 0.0;
    if (!read_number(property.type, value)) return false;
    if (property.role >= PlyRole::kRed && property.role <= PlyRole::kAlpha)
      value = colour_byte(value, property.type);
    item.values[static_cast<std::size_t>(property.role)] = value;
    return true;
  }

  void add_vertex(const PlyItem& item, bool normals, bool uvs, bool colours) {
    mesh_.vertices.emplace_back(item.at(PlyRole::kX), item.at(PlyRole::kY), item.at(PlyRole::kZ));
    const auto single = [&item](PlyRole role) { return static_cast<float>(item.at(role)); };
    const auto byte = [&item](PlyRole role) { return static_cast<std::uint8_t>(item.at(role)); };
    if (normals)
      mesh_.normals.emplace_back(single(PlyRole::kNormalX), single(PlyRole::kNormalY),
                                 single(PlyRole::kNormalZ));
    if (uvs) mesh_.uvs.emplace_back(single(PlyRole::kU), single(PlyRole::kV));
    vertex_normals_ |= normals;
    vertex_uvs_ |= uvs;
    if (colours)
      mesh_.colours.push_back({byte(PlyRole::kRed), byte(PlyRole::kGreen), byte(PlyRole::kBlue),
                               byte(PlyRole::kAlpha)});
  }

  // The vertex of a corner; whether there is one is seen at the end.
  bool add_corner(double vertex, const std::string& where) {
    if (!(vertex >= 0.0) || !(vertex <= std::numeric_limits<VertexId>::max()))
      return fail(where + " has a corner that is no vertex");
    mesh_.corners.push_back({static_cast<VertexId>(vertex)});
    return true;
  }

  bool add_face(const PlyItem& item, std::uint64_t i) {
    const std::size_t begin = mesh_.corners.size();
    for (const double vertex : item.corners)
      if (!add_corner(vertex, "face " + std::to_string(i))) return false;
    if (item.uvs.size() == 2 * item.corners.size())
      for (std::size_t k = 0; k < item.corners.size() && !vertex_uvs_; ++k) {
        mesh_.corners[begin + k].uv = static_cast<std::int32_t>(mesh_.uvs.size());
        mesh_.uvs.emplace_back(static_cast<float>(item.uvs[2 * k]),
                               static_cast<float>(item.uvs[2 * k + 1]));
      }
    mesh_.end_polygon(0, 0);
    return true;
  }

  // Every second triangle of a strip is reversed.
  bool add_strips(const PlyItem& item) {
    std::size_t start = 0;
    for (std::size_t k = 0; k < item.corners.size(); ++k) {
      if (item.corners[k] == kStripEnd) {
        start = k + 1;
        continue;
      }
      if (k < start + 2) continue;
      const bool turned = (k - start) % 2 != 0;
      const std::array<double, 3> triangle = {item.corners[turned ? k - 1 : k - 2],
                                              item.corners[turned ? k - 2 : k - 1],
                                              item.corners[k]};
      // A vertex that is repeated joins strips.
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[0] == triangle[2])
        continue;
      for (const double vertex : triangle)
        if (!add_corner(vertex, "a triangle strip")) return false;
      mesh_.end_polygon(0, 0);
    }
    return true;
  }

  PlyNumbers numbers_;
  const PlyHeader& header_;
  const std::string& name_;
  PolygonMesh mesh_;
  bool vertex_normals_ = false, vertex_uvs_ = false;
  Error error_;
};

}  // namespace

Result<PolygonMesh> parse_ply_polygons(std::string_view bytes, const std::string& name) {
  const Result<PlyHeader> header = parse_ply_header(bytes, name);
  if (!header) return header.error();
  return PlyBody({bytes.substr(header->size), header->form, header->size}, *header, name).parse();
}

}  // namespace tremolo
