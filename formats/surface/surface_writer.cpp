#include "formats/surface/surface_writer.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string_view>

#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"

namespace tremolo {
namespace {

template <class... Values>
void append(std::string& text, const char* format, Values... values) {
  char line[160];
  std::snprintf(line, sizeof(line), format, values...);
  text += line;
}

// The parts of a surface that the formats write, besides its triangles' objects and materials. An
// empty list: the surface has none. channels: of a colour that is written, 3 or 4.
template <class Normals>
struct Drawn {
  const std::vector<Eigen::Vector3d>& vertices;
  const std::vector<Triangle>& triangles;
  const Normals& normals;
  const std::vector<Eigen::Vector2f>& uvs;
  const std::vector<Colour>& colours;
  std::size_t channels;
};

Drawn<std::vector<Eigen::Vector3f>> drawn(const RenderSurface& surface) {
  return {surface.vertices, surface.triangles, surface.normals, surface.uvs, surface.colours, 4};
}

const std::vector<Eigen::Vector2f> kNoUvs;

// Makes a name safe for the rest of a line.
std::string one_line(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 32; }, '_');
  return name.empty() ? "unnamed" : name;
}

// authored: number of the first vertices, which are not copies of others.
template <class Normals>
void append_obj_vertices(std::string& text, const Drawn<Normals>& surface, std::size_t authored) {
  for (std::size_t v = 0; v < authored; ++v) {
    const Eigen::Vector3d& x = surface.vertices[v];
    append(text, "v %.9g %.9g %.9g", x[0], x[1], x[2]);
    if (!surface.colours.empty()) {
      const Colour& c = surface.colours[v];
      append(text, " %.4g %.4g %.4g", c[0] / 255.0, c[1] / 255.0, c[2] / 255.0);
    }
    text += '\n';
  }
  for (const Eigen::Vector2f& uv : surface.uvs)
    append(text, "vt %.9g %.9g\n", double{uv[0]}, double{uv[1]});
  for (const auto& n : surface.normals)
    append(text, "vn %.6g %.6g %.6g\n", double{n[0]}, double{n[1]}, double{n[2]});
}

void append_obj_corner(std::string& text, const RenderSurface& surface, VertexId corner) {
  const int index = corner + 1;
  const int vertex = surface.sources.empty() ? index : surface.sources[corner] + 1;
  const bool uv = !surface.uvs.empty();
  const bool normal = !surface.normals.empty();
  if (uv && normal)
    append(text, " %d/%d/%d", vertex, index, index);
  else if (uv)
    append(text, " %d/%d", vertex, index);
  else if (normal)
    append(text, " %d//%d", vertex, index);
  else
    append(text, " %d", vertex);
}

std::string obj_text(const RenderSurface& surface, const std::string& library) {
  std::string text;
  if (!library.empty()) text += "mtllib " + library + "\n";
  append_obj_vertices(text, drawn(surface), surface.authored());
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t object = kNone, material = kNone;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (surface.object_of[t] != object) {
      object = surface.object_of[t];
      material = kNone;
      text += "o " + one_line(surface.objects[object]) + "\n";
    }
    if (surface.material_of[t] != material) {
      material = surface.material_of[t];
      text += "usemtl " + one_line(surface.materials[material]) + "\n";
    }
    text += 'f';
    for (const VertexId corner : surface.triangles[t]) append_obj_corner(text, surface, corner);
    text += '\n';
  }
  return text;
}

template <class Normals>
std::string ply_bytes(const Drawn<Normals>& surface) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
  append(bytes, "element vertex %zu\n", surface.vertices.size());
  bytes += "property float x\nproperty float y\nproperty float z\n";
  if (!surface.normals.empty())
    bytes += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!surface.uvs.empty()) bytes += "property float s\nproperty float t\n";
  constexpr const char* kChannels[] = {"red", "green", "blue", "alpha"};
  for (std::size_t i = 0; !surface.colours.empty() && i < surface.channels; ++i)
    append(bytes, "property uchar %s\n", kChannels[i]);
  append(bytes, "element face %zu\n", surface.triangles.size());
  bytes += "property list uchar int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    const Eigen::Vector3f x = surface.vertices[v].template cast<float>();
    append_bytes(bytes, x.data(), 3);
    if (!surface.normals.empty()) append_bytes(bytes, surface.normals[v].data(), 3);
    if (!surface.uvs.empty()) append_bytes(bytes, surface.uvs[v].data(), 2);
    if (!surface.colours.empty()) append_bytes(bytes, surface.colours[v].data(), surface.channels);
  }
  for (const Triangle& t : surface.triangles) {
    bytes += '\3';
    append_bytes(bytes, t.data(), 3);
  }
  return bytes;
}

template <class Normals>
std::string pov_text(const Drawn<Normals>& surface) {
  std::string text = "#declare Surface = mesh2 {\n";
  const auto list = [&text](const char* name, const auto& entries, const auto& append_entry) {
    append(text, "  %s {\n    %zu", name, entries.size());
    for (const auto& entry : entries) {
      text += ",\n    <";
      append_entry(entry);
      text += '>';
    }
    text += "\n  }\n";
  };
  const auto three = [&text](const auto& x) {
    append(text, "%.7g, %.7g, %.7g", double{x[0]}, double{x[1]}, double{x[2]});
  };
  list("vertex_vectors", surface.vertices, three);
  if (!surface.normals.empty()) list("normal_vectors", surface.normals, three);
  if (!surface.uvs.empty())
    list("uv_vectors", surface.uvs, [&text](const Eigen::Vector2f& uv) {
      append(text, "%.7g, %.7g", double{uv[0]}, double{uv[1]});
    });
  list("face_indices", surface.triangles,
       [&text](const Triangle& t) { append(text, "%d, %d, %d", t[0], t[1], t[2]); });
  return text + "}\n";
}

bool has_ending(const std::string& path, std::string_view ending) {
  return path.size() > ending.size() && path.ends_with(ending);
}

Error unknown_ending(const std::string& path) {
  return {ErrorKind::kUsage, path + ": a surface ends in .obj, .ply or .inc"};
}

}  // namespace

std::vector<Eigen::Vector3d> vertex_normals(const SurfaceMesh& surface) {
  std::vector<Eigen::Vector3d> normals(surface.vertices.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : surface.triangles) {
    const Eigen::Vector3d a = surface.vertices[t[1]] - surface.vertices[t[0]];
    const Eigen::Vector3d b = surface.vertices[t[2]] - surface.vertices[t[0]];
    for (VertexId v : t) normals[v] += a.cross(b);
  }
  for (Eigen::Vector3d& normal : normals)
    if (normal.norm() > 0) normal.normalize();
  return normals;
}

Status write_surface(const std::string& path, const SurfaceMesh& surface) {
  if (has_ending(path, ".ply")) return write_painted_surface(path, surface, {});
  const bool smooth = has_ending(path, ".inc");
  const auto normals = smooth ? vertex_normals(surface) : std::vector<Eigen::Vector3d>();
  const std::vector<Colour> bare;
  const Drawn<std::vector<Eigen::Vector3d>> plain = {
      surface.vertices, surface.triangles, normals, kNoUvs, bare, 0};
  if (smooth) return write_file(path, pov_text(plain));
  if (!has_ending(path, ".obj")) return unknown_ending(path);
  std::string text;
  append_obj_vertices(text, plain, surface.vertices.size());
  for (const Triangle& t : surface.triangles)
    append(text, "f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return write_file(path, text);
}

Status write_painted_surface(const std::string& path, const SurfaceMesh& surface,
                             const std::vector<Colour>& colours) {
  if (!has_ending(path, ".ply"))
    return Error{ErrorKind::kUsage, path + ": a painted surface ends in .ply"};
  const std::vector<Eigen::Vector3d> none;
  return write_file(path, ply_bytes(Drawn<std::vector<Eigen::Vector3d>>{
                              surface.vertices, surface.triangles, none, kNoUvs, colours, 3}));
}

std::string material_library(const RenderSurface& surface) {
  std::vector<Eigen::Vector3d> sums(surface.materials.size(), Eigen::Vector3d::Zero());
  std::vector<double> counts(surface.materials.size(), 0.0);
  for (std::size_t t = 0; t < surface.triangles.size() && !surface.colours.empty(); ++t)
    for (const VertexId corner : surface.triangles[t]) {
      const Colour& c = surface.colours[corner];
      sums[surface.material_of[t]] += Eigen::Vector3d(c[0], c[1], c[2]) / 255.0;
      counts[surface.material_of[t]] += 1.0;
    }
  std::string text = "# names and mean colours; textures are those of the surface's own file\n";
  for (std::size_t m = 0; m < surface.materials.size(); ++m) {
    const Eigen::Vector3d colour =
        counts[m] > 0 ? Eigen::Vector3d(sums[m] / counts[m]) : Eigen::Vector3d::Constant(0.8);
    text += "newmtl " + one_line(surface.materials[m]) + "\n";
    append(text, "Kd %.4g %.4g %.4g\n", colour[0], colour[1], colour[2]);
  }
  return text;
}

Status write_render_surface(const std::string& path, const RenderSurface& surface,
                            const std::string& library) {
  if (has_ending(path, ".obj")) return write_file(path, obj_text(surface, library));
  if (has_ending(path, ".ply")) return write_file(path, ply_bytes(drawn(surface)));
  if (has_ending(path, ".inc")) return write_file(path, pov_text(drawn(surface)));
  return unknown_ending(path);
}

}  // namespace tremolo
