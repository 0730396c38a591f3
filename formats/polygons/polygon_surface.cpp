#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Geometry>

#include "common/mesh/surface_mesh.h"
#include "formats/file/printable_text.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

// A unit normal, or zero for one that is missing or without a direction.
Vector3f normal_of(const PolygonMesh& mesh, const PolygonCorner& corner) {
  if (corner.normal == kNoEntry) return Vector3f::Zero();
  const Vector3f n = mesh.normals[corner.normal].cast<double>().stableNormalized().cast<float>();
  return n.allFinite() && std::abs(n.norm() - 1.0F) < 1e-5F ? n : Vector3f(Vector3f::Zero());
}

Vector2f uv_of(const PolygonMesh& mesh, const PolygonCorner& corner) {
  if (corner.uv == kNoEntry) return Vector2f::Zero();
  const Vector2f& uv = mesh.uvs[corner.uv];
  return uv.allFinite() ? uv : Vector2f(Vector2f::Zero());
}

class Splitter {
 public:
  Splitter(PolygonMesh& mesh, RenderSurface& surface) : mesh_(mesh), surface_(surface) {
    const std::size_t n = mesh.vertices.size();
    surface.vertices = std::move(mesh.vertices);
    surface.colours = std::move(mesh.colours);
    surface.normals.assign(n, Vector3f(0, 0, 1));
    surface.uvs.assign(n, Vector2f::Zero());
    surface.sources.resize(n);
    std::iota(surface.sources.begin(), surface.sources.end(), 0);
    next_.assign(n, kNone);
    used_.assign(n, false);
    has_normal_.assign(n, false);
    for (const Vector3d& x : surface.vertices) finite_.push_back(x.allFinite());
    const auto good = std::find(finite_.begin(), finite_.end(), true);
    const Vector3d stand_in =
        good == finite_.end() ? Vector3d(Vector3d::Zero())
                              : surface.vertices[static_cast<std::size_t>(good - finite_.begin())];
    for (std::size_t v = 0; v < n; ++v)
      if (!finite_[v]) surface.vertices[v] = stand_in;
  }

  bool finite(const PolygonCorner& corner) const { return finite_[corner.vertex]; }

  // The surface's vertex for a corner: the file's own, or a copy.
  VertexId vertex_of(const PolygonCorner& corner) {
    const Vector3f normal = normal_of(mesh_, corner);
    const Vector2f uv = uv_of(mesh_, corner);
    any_uv_ |= corner.uv != kNoEntry;
    VertexId v = corner.vertex;
    if (!used_[v]) return take(v, normal, uv);
    while (!equal(v, normal, uv)) {
      if (next_[v] == kNone) return copy(corner.vertex, v, normal, uv);
      v = next_[v];
    }
    return v;
  }

  void finish() {
    fill_missing_normals(surface_, has_normal_);
    if (!any_uv_) surface_.uvs.clear();
    if (surface_.vertices.size() == finite_.size()) surface_.sources.clear();
  }

 private:
  static constexpr VertexId kNone = -1;

  bool equal(VertexId v, const Vector3f& normal, const Vector2f& uv) const {
    const bool same_normal =
        has_normal_[v] ? surface_.normals[v] == normal : normal == Vector3f::Zero();
    return same_normal && surface_.uvs[v] == uv;
  }

  VertexId take(VertexId v, const Vector3f& normal, const Vector2f& uv) {
    used_[v] = true;
    has_normal_[v] = normal != Vector3f::Zero();
    if (has_normal_[v]) surface_.normals[v] = normal;
    surface_.uvs[v] = uv;
    return v;
  }

  VertexId copy(VertexId source, VertexId last, const Vector3f& normal, const Vector2f& uv) {
    const auto v = static_cast<VertexId>(surface_.vertices.size());
    surface_.vertices.push_back(Vector3d(surface_.vertices[source]));
    if (!surface_.colours.empty()) surface_.colours.push_back(Colour(surface_.colours[source]));
    surface_.normals.emplace_back(0, 0, 1);
    surface_.uvs.emplace_back(0, 0);
    surface_.sources.push_back(source);
    next_.push_back(kNone);
    next_[last] = v;
    used_.push_back(true);
    has_normal_.push_back(false);
    return take(v, normal, uv);
  }

  PolygonMesh& mesh_;
  RenderSurface& surface_;
  std::vector<VertexId> next_;  // of the copies of one vertex, from the file's own
  std::vector<bool> used_, has_normal_, finite_;
  bool any_uv_ = false;
};

// The names of those that have triangles, in the order of their first one.
void take_names(const std::vector<std::string>& names, const char* nameless,
                std::vector<std::uint32_t>& of_triangle, std::vector<std::string>& taken) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> place(names.size(), kUnused);
  UniqueNames unique(nameless);
  for (std::uint32_t& index : of_triangle) {
    if (place[index] == kUnused) {
      place[index] = static_cast<std::uint32_t>(taken.size());
      taken.push_back(unique.take(names[index]));
    }
    index = place[index];
  }
}

}  // namespace

RenderSurface render_surface_of(PolygonMesh mesh, std::vector<std::string>& notes) {
  RenderSurface surface;
  LeftOut left_out{.points = mesh.points, .lines = mesh.lines};
  Splitter splitter(mesh, surface);
  std::vector<Vector3d> outline;
  std::vector<std::array<std::size_t, 3>> cut;
  for (std::size_t f = 0; f < mesh.polygons(); ++f) {
    const std::span polygon(mesh.corners.data() + mesh.first[f], mesh.first[f + 1] - mesh.first[f]);
    if (polygon.size() < 3) {
      ++(polygon.size() < 2 ? left_out.points : left_out.lines);
      continue;
    }
    if (!std::all_of(polygon.begin(), polygon.end(),
                     [&](const PolygonCorner& corner) { return splitter.finite(corner); })) {
      left_out.not_finite += polygon.size() - 2;
      continue;
    }
    outline.clear();
    cut.clear();
    for (const PolygonCorner& corner : polygon) outline.push_back(surface.vertices[corner.vertex]);
    cut_polygon(outline, cut);
    for (const auto& [a, b, c] : cut) {
      const VertexId at_a = splitter.vertex_of(polygon[a]), at_b = splitter.vertex_of(polygon[b]);
      surface.triangles.push_back({at_a, at_b, splitter.vertex_of(polygon[c])});
      surface.object_of.push_back(mesh.object_of[f]);
      surface.material_of.push_back(mesh.material_of[f]);
    }
  }
  splitter.finish();
  take_names(mesh.objects, "object", surface.object_of, surface.objects);
  take_names(mesh.materials, "material", surface.material_of, surface.materials);
  note_left_out(left_out, notes);
  notes.insert(notes.end(), mesh.notes.begin(), mesh.notes.end());
  return surface;
}

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
