#include "formats/surface/surface_writer.h"

#include <cstdio>
#include <cstring>
#include <string_view>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

template <class... Values>
void append(std::string& text, const char* format, Values... values) {
  char line[128];
  std::snprintf(line, sizeof(line), format, values...);
  text += line;
}

template <class T>
void append_bytes(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string obj_text(const SurfaceMesh& surface) {
  std::string text;
  for (const Eigen::Vector3d& x : surface.vertices)
    append(text, "v %.9g %.9g %.9g\n", x[0], x[1], x[2]);
  for (const Triangle& t : surface.triangles)
    append(text, "f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

// colours: one a vertex, or none.
std::string ply_bytes(const SurfaceMesh& surface, const std::vector<Colour>& colours = {}) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
  append(bytes, "element vertex %zu\n", surface.vertices.size());
  bytes += "property float x\nproperty float y\nproperty float z\n";
  if (!colours.empty()) bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  append(bytes, "element face %zu\n", surface.triangles.size());
  bytes += "property list uchar int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    for (double value : surface.vertices[v]) append_bytes(bytes, static_cast<float>(value));
    for (std::size_t channel = 0; !colours.empty() && channel < 3; ++channel)
      append_bytes(bytes, colours[v][channel]);
  }
  for (const Triangle& t : surface.triangles) {
    bytes += '\3';
    for (VertexId v : t) append_bytes(bytes, v);
  }
  return bytes;
}

std::string pov_text(const SurfaceMesh& surface) {
  std::string text = "#declare Surface = mesh2 {\n  vertex_vectors {\n";
  const auto vectors = [&text](const std::vector<Eigen::Vector3d>& list) {
    append(text, "    %zu", list.size());
    for (const Eigen::Vector3d& x : list)
      append(text, ",\n    <%.7g, %.7g, %.7g>", x[0], x[1], x[2]);
    text += "\n  }\n";
  };
  vectors(surface.vertices);
  text += "  normal_vectors {\n";
  vectors(vertex_normals(surface));
  append(text, "  face_indices {\n    %zu", surface.triangles.size());
  for (const Triangle& t : surface.triangles) append(text, ",\n    <%d, %d, %d>", t[0], t[1], t[2]);
  return text + "\n  }\n}\n";
}

bool ends_with(std::string_view path, std::string_view ending) {
  return path.size() > ending.size() && path.substr(path.size() - ending.size()) == ending;
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
  if (ends_with(path, ".obj")) return write_file(path, obj_text(surface));
  if (ends_with(path, ".ply")) return write_file(path, ply_bytes(surface));
  if (ends_with(path, ".inc")) return write_file(path, pov_text(surface));
  return Error{ErrorKind::kUsage, path + ": a surface ends in .obj, .ply or .inc"};
}

Status write_painted_surface(const std::string& path, const SurfaceMesh& surface,
                             const std::vector<Colour>& colours) {
  if (!ends_with(path, ".ply"))
    return Error{ErrorKind::kUsage, path + ": a painted surface ends in .ply"};
  return write_file(path, ply_bytes(surface, colours));
}

}  // namespace tremolo
