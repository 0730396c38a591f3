#include "precompute/mesher/surface_input.h"

#include <cstdio>

#include "common/length_unit.h"
#include "formats/surface/surface_reader.h"

namespace tremolo {

Result<SurfaceInput> load_surface(const std::string& path, const std::string& unit,
                                  const SurfaceMeshOptions& options) {
  SurfaceReadOptions reading;
  if (!unit.empty()) {
    const Result<double> metres = metres_per_unit(unit);
    if (!metres) return metres.error();
    reading.metres_per_unit = *metres;
  }
  Result<SurfaceFile> file = read_surface(path, reading);
  if (!file) return file.error();
  Result<MeshedSurface> meshed = mesh_surface(file->surface, options);
  if (!meshed) return Error{meshed.error().kind, path + ": " + meshed.error().message};
  SurfaceInput input;
  input.render = std::move(file->surface);
  input.mesh = std::move(meshed->mesh);
  input.format = std::move(file->format);
  char text[300];
  std::snprintf(
      text, sizeof(text),
      "a surface of %zu vertices and %zu triangles in %zu object%s, %.4g m across; unit: ",
      input.render.vertices.size(), input.render.triangles.size(), input.render.objects.size(),
      input.render.objects.size() == 1 ? "" : "s", meshed->report.diagonal);
  input.notes.push_back(input.format + ": " + text + file->unit);
  input.notes.insert(input.notes.end(), file->notes.begin(), file->notes.end());
  const std::vector<std::string> lines = describe(meshed->report);
  input.notes.insert(input.notes.end(), lines.begin(), lines.end());
  return input;
}

}  // namespace tremolo
