// The output of the child process in which assimp runs: a file may have taken the child over.
#include <cmath>

#include "formats/surface/surface_answer.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<SurfaceFile> file =
      decode_surface(std::as_bytes(std::span(bytes.data(), bytes.size())));
  check_error(file);
  if (!file) return;
  const RenderSurface& surface = file->surface;
  const std::size_t s = surface.vertices.size(), t = surface.triangles.size();
  const auto none_or = [](std::size_t size, std::size_t count) {
    return size == 0 || size == count;
  };
  if (t == 0 || surface.object_of.size() != t || surface.material_of.size() != t ||
      !none_or(surface.normals.size(), s) || !none_or(surface.uvs.size(), s) ||
      !none_or(surface.colours.size(), s) || surface.objects.empty() || surface.materials.empty())
    finding("a surface whose parts do not fit");
  for (const Eigen::Vector3d& x : surface.vertices)
    if (!x.allFinite()) finding("a coordinate that is not finite");
  for (const Triangle& triangle : surface.triangles)
    for (VertexId v : triangle)
      if (v < 0 || static_cast<std::size_t>(v) >= s) finding("a corner that is not there");
  for (std::size_t i = 0; i < t; ++i)
    if (surface.object_of[i] >= surface.objects.size() ||
        surface.material_of[i] >= surface.materials.size())
      finding("a triangle of an object or a material that is not there");
}
