#include "formats/polygons/surface_parts.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace tremolo {
namespace {

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

void note_left_out(const LeftOut& left_out, std::vector<std::string>& notes) {
  if (left_out.points > 0)
    notes.push_back(counted(left_out.points, "point", "points") + " left out");
  if (left_out.lines > 0) notes.push_back(counted(left_out.lines, "line", "lines") + " left out");
  if (left_out.polygons > 0)
    notes.push_back(counted(left_out.polygons, "polygon", "polygons") +
                    " that could not be cut into triangles left out");
  if (left_out.not_finite > 0)
    notes.push_back(counted(left_out.not_finite, "triangle", "triangles") +
                    " with coordinates that are no numbers left out");
}

void fill_missing_normals(RenderSurface& surface, const std::vector<bool>& has_normal) {
  if (std::find(has_normal.begin(), has_normal.end(), true) == has_normal.end()) {
    surface.normals.clear();
    return;
  }
  if (std::find(has_normal.begin(), has_normal.end(), false) == has_normal.end()) return;
  std::vector<Eigen::Vector3d> sums(surface.vertices.size(), Eigen::Vector3d::Zero());
  for (const Triangle& triangle : surface.triangles) {
    const Eigen::Vector3d& a = surface.vertices[triangle[0]];
    const Eigen::Vector3d twice_area =
        (surface.vertices[triangle[1]] - a).cross(surface.vertices[triangle[2]] - a);
    for (const VertexId v : triangle) sums[v] += twice_area;
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const Eigen::Vector3d n = sums[v].stableNormalized();
    // A vertex of flat triangles only keeps the normal that it has.
    if (!has_normal[v] && n.allFinite() && std::abs(n.norm() - 1) < 1e-6)
      surface.normals[v] = n.cast<float>();
  }
}

}  // namespace tremolo
