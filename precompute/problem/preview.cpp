#include "precompute/problem/preview.h"

#include <cmath>
#include <numbers>

#include "formats/surface/surface_writer.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

constexpr double kArrowLength = 0.25;  // relative to the diagonal of the body's bounding box
constexpr double kShaft = 0.04, kHead = 0.1, kHeadLength = 0.3;  // relative to the arrow's length
constexpr int kSides = 16;

void paint(const std::vector<VertexId>& ids, const Colour& colour, std::vector<Colour>& of_mesh) {
  for (const VertexId id : ids) of_mesh[id] = colour;
}

// Returns a closed surface of revolution about the line from tail to tip.
SurfaceMesh arrow(const Eigen::Vector3d& tail, const Eigen::Vector3d& tip) {
  const Eigen::Vector3d along = tip - tail;
  const double length = along.norm();
  const Eigen::Vector3d u = along.unitOrthogonal();
  const Eigen::Vector3d v = along.normalized().cross(u);
  // Distance from the tail and radius of each ring, relative to the length.
  const double rings[][2] = {
      {0.0, kShaft}, {1.0 - kHeadLength, kShaft}, {1.0 - kHeadLength, kHead}};
  SurfaceMesh mesh;
  for (const auto& [at, radius] : rings)
    for (int side = 0; side < kSides; ++side) {
      const double turn = 2.0 * std::numbers::pi * side / kSides;
      mesh.vertices.push_back(tail + at * along +
                              radius * length * (std::cos(turn) * u + std::sin(turn) * v));
    }
  const auto low = static_cast<VertexId>(mesh.vertices.size());
  mesh.vertices.push_back(tail);
  mesh.vertices.push_back(tip);
  for (VertexId side = 0; side < kSides; ++side) {
    const VertexId next = (side + 1) % kSides;
    mesh.triangles.push_back({low, next, side});
    for (VertexId ring = 0; ring < 2; ++ring) {
      const VertexId a = ring * kSides + side, b = ring * kSides + next;
      mesh.triangles.push_back({a, b, b + kSides});
      mesh.triangles.push_back({a, b + kSides, a + kSides});
    }
    mesh.triangles.push_back({2 * kSides + side, 2 * kSides + next, low + 1});
  }
  return mesh;
}

void add_arrow(const Problem& problem, const BoundingBox& box, Preview& preview) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < problem.load.vertices.size(); ++i) {
    middle += problem.mesh.vertices[problem.load.vertices[i]];
    force += problem.load.forces[i];
  }
  middle /= static_cast<double>(problem.load.vertices.size());
  const Eigen::Vector3d reach = kArrowLength * box.diagonal() * force.stableNormalized();
  // A load perpendicular to the body counts as pulling, so that rounding cannot decide.
  const double outwards =
      force.stableNormalized().dot(middle - 0.5 * (box.low + box.high)) / box.diagonal();
  const bool pulls = outwards > -1e-6;
  const SurfaceMesh shown = pulls ? arrow(middle, middle + reach) : arrow(middle - reach, middle);
  const auto first = static_cast<VertexId>(preview.surface.vertices.size());
  preview.surface.vertices.insert(preview.surface.vertices.end(), shown.vertices.begin(),
                                  shown.vertices.end());
  for (const Triangle& t : shown.triangles)
    preview.surface.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  preview.colours.resize(preview.surface.vertices.size(), kLoadedColour);
}

}  // namespace

Preview make_preview(const Problem& problem, const std::vector<VertexId>& selected) {
  std::vector<Colour> of_mesh(problem.mesh.vertices.size(), kFreeColour);
  for (const auto& held : problem.held) paint(held, kPartlyHeldColour, of_mesh);
  paint(problem.load.vertices, kLoadedColour, of_mesh);
  paint(problem.fixed, kHeldColour, of_mesh);
  paint(selected, kSelectedColour, of_mesh);

  Preview preview;
  const BoundarySurface boundary = boundary_surface(problem.mesh);
  preview.surface.triangles = boundary.triangles;
  for (const VertexId id : boundary.vertex_ids) {
    preview.surface.vertices.push_back(problem.mesh.vertices[id]);
    preview.colours.push_back(of_mesh[id]);
  }
  if (!problem.load.vertices.empty())
    add_arrow(problem, bounding_box(preview.surface.vertices), preview);
  return preview;
}

void write_preview(const std::string& path, const Problem& problem,
                   const std::vector<VertexId>& selected) {
  if (path.empty()) return;
  const Preview preview = make_preview(problem, selected);
  unwrap(write_painted_surface(path, preview.surface, preview.colours));
}

}  // namespace tremolo
