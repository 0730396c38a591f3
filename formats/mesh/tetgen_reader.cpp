#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>

#include "formats/file/input_file.h"
#include "formats/file/scanner.h"
#include "formats/mesh/mesh_builder.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {
namespace {

constexpr TextStyle kTetgenStyle{.comment = '#', .lines = true};

// The first line of either file: a count, a width, and the further columns of each line.
struct Header {
  std::uint64_t count = 0;
  int width = 0;
  std::uint64_t attributes = 0;
  int markers = 0;
};

bool read_header(TextScanner& scanner, std::string_view items, std::string_view width,
                 Header& header) {
  if (scanner.at_end()) return scanner.fail("the number of " + std::string(items), "");
  if (!scanner.read(header.count, "the number of " + std::string(items)) ||
      !scanner.read(header.width, width))
    return false;
  if (!scanner.at_line_end() && !scanner.read(header.attributes, "the number of attributes"))
    return false;
  return scanner.at_line_end() || scanner.read(header.markers, "0 or 1 (boundary markers)");
}

bool skip_attributes(TextScanner& scanner, std::uint64_t count) {
  double ignored = 0;
  for (std::uint64_t a = 0; a < count; ++a)
    if (!scanner.read(ignored, "an attribute")) return false;
  return true;
}

Status read_nodes(TextScanner scanner, MeshBuilder& builder) {
  Header header;
  if (!read_header(scanner, "points", "the dimension 3", header)) return scanner.error();
  if (header.width != 3)
    return scanner.problem("expected dimension 3, found " + std::to_string(header.width));
  if (!scanner.fits(header.count, 8, "points")) return scanner.error();
  builder.reserve_vertices(header.count);
  std::vector<std::int64_t> markers;
  for (std::uint64_t n = 0; n < header.count; ++n) {
    std::int64_t id = 0;
    std::int64_t marker = 0;
    Eigen::Vector3d x;
    scanner.next_line();
    if (!scanner.read(id, "a point id") || !scanner.read(x[0], "a coordinate") ||
        !scanner.read(x[1], "a coordinate") || !scanner.read(x[2], "a coordinate") ||
        !skip_attributes(scanner, header.attributes) ||
        (header.markers != 0 && !scanner.read(marker, "a boundary marker")))
      return scanner.error();
    if (!builder.add_vertex(id, x)) return scanner.problem(builder.complaint());
    markers.push_back(marker);
  }
  if (!builder.seal_vertices()) return scanner.problem(builder.complaint());
  for (std::size_t v = 0; v < markers.size(); ++v) {
    const auto vertex = static_cast<VertexId>(v);
    if (markers[v] != 0) builder.add_to_set("marker " + std::to_string(markers[v]), {&vertex, 1});
  }
  return Success{};
}

// TetGen's second order (-o2): six further nodes at the middles of the edges. Versions differ in
// their order, so each node is assigned to the edge with the nearest middle. False if two are
// assigned to one edge.
bool order_edge_nodes(const TetMesh& mesh, std::vector<VertexId>& vertices) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kEnds = {
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  const auto at = [&](std::size_t n) -> const Eigen::Vector3d& {
    return mesh.vertices[vertices[n]];
  };
  std::array<VertexId, 6> ordered;
  ordered.fill(-1);
  for (std::size_t n = 4; n < 10; ++n) {
    const auto distance = [&](const std::array<std::size_t, 2>& ends) {
      return (at(n) - 0.5 * (at(ends[0]) + at(ends[1]))).squaredNorm();
    };
    const auto nearest =
        std::min_element(kEnds.begin(), kEnds.end(),
                         [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    VertexId& place = ordered[nearest - kEnds.begin()];
    if (place >= 0) return false;
    place = vertices[n];
  }
  std::copy(ordered.begin(), ordered.end(), vertices.begin() + 4);
  return true;
}

// The last attribute numbers regions: TetGen puts it there.
Status read_elements(TextScanner scanner, MeshBuilder& builder) {
  Header header;
  if (!read_header(scanner, "tetrahedra", "the number of nodes of a tetrahedron", header))
    return scanner.error();
  if (header.width != 4 && header.width != 10)
    return scanner.problem("expected tetrahedra of 4 or 10 nodes, found " +
                           std::to_string(header.width) + " nodes");
  if (!scanner.fits(header.count, 10, "tetrahedra")) return scanner.error();
  builder.reserve_tetrahedra(header.count);
  constexpr CellKind kLinear{"tetrahedra", 4, CellKind::Role::kTetrahedron};
  constexpr CellKind kQuadratic{"10-node tetrahedra", 10, CellKind::Role::kQuadraticTetrahedron};
  const CellKind& kind = header.width == 4 ? kLinear : kQuadratic;
  std::vector<std::int64_t> nodes(header.width);
  std::vector<VertexId> vertices;
  std::vector<std::int64_t> regions;
  bool whole = header.attributes > 0;
  for (std::uint64_t e = 0; e < header.count; ++e) {
    std::int64_t id = 0;
    scanner.next_line();
    if (!scanner.read(id, "an element id")) return scanner.error();
    for (std::int64_t& node : nodes)
      if (!scanner.read(node, "a node of an element")) return scanner.error();
    double attribute = 0;
    for (std::uint64_t a = 0; a < header.attributes; ++a)
      if (!scanner.read(attribute, "an attribute")) return scanner.error();
    whole = whole && std::abs(attribute) <= kMostExact && attribute == std::floor(attribute);
    if (whole) regions.push_back(static_cast<std::int64_t>(attribute));
    if (!builder.resolve(id, nodes, vertices)) return scanner.problem(builder.complaint());
    if (kind.is_quadratic() && !order_edge_nodes(builder.mesh(), vertices))
      return scanner.problem("element " + std::to_string(id) +
                             ": expected its last six nodes near the middles of its six edges, "
                             "found two at one edge");
    if (!builder.add_cell(id, kind, vertices)) return scanner.problem(builder.complaint());
  }
  if (whole)
    builder.set_regions(regions,
                        [](std::int64_t label) { return "region " + std::to_string(label); });
  else if (header.attributes > 0)
    builder.add_note("the attributes of the tetrahedra are not integers: they name no regions");
  return Success{};
}

}  // namespace

Result<MeshFile> read_tetgen(const std::string& path) {
  const std::string node_path = std::filesystem::path(path).replace_extension(".node").string();
  const std::string ele_path = std::filesystem::path(path).replace_extension(".ele").string();
  // If the file that was named first is missing, its error is reported.
  const bool node_given = node_path == path;
  const Result<std::string> given = read_whole_file(path);
  if (!given) return given.error();
  const Result<std::string> other = read_whole_file(node_given ? ele_path : node_path);
  if (!other)
    return Error{other.error().kind, other.error().message + " (it is needed beside " + path + ")"};
  return read_tetgen_texts(node_given ? *given : *other, node_path, node_given ? *other : *given,
                           ele_path);
}

Result<MeshFile> read_tetgen_texts(std::string_view nodes, const std::string& node_path,
                                   std::string_view elements, const std::string& ele_path) {
  MeshBuilder builder(ele_path);
  Status status = read_nodes(TextScanner(nodes, node_path, kTetgenStyle), builder);
  if (status) status = read_elements(TextScanner(elements, ele_path, kTetgenStyle), builder);
  if (!status) return status.error();
  return builder.finish("TetGen");
}

}  // namespace tremolo
