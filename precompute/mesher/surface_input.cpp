#include "precompute/mesher/surface_input.h"

#include "common/format_text.h"
#include "common/length_unit.h"
#include "formats/surface/surface_reader.h"
#include "precompute/mesher/surface_mesher.h"

namespace tremolo {

Result<MesherAnswer> load_surface(const std::string& path, const std::string& unit,
                                  const SurfaceMeshOptions& options) {
  SurfaceReadOptions reading;
  if (!unit.empty()) {
    const Result<double> metres = metres_per_unit(unit);
    if (!metres) return metres.error();
    reading.metres_per_unit = *metres;
  }
  Result<SurfaceFile> file = read_surface(path, reading);
  if (!file) return file.error();
  const RenderSurface& surface = file->surface;
  Result<MeshedSurface> meshed = mesh_surface(surface, options);
  if (!meshed) return Error{meshed.error().kind, path + ": " + meshed.error().message};
  MesherAnswer answer{std::move(meshed->mesh), file->format, {}};
  answer.notes.push_back(
      file->format +
      text(": a surface of %zu vertices and %zu triangles in %zu object%s, %.4g m across; unit: ",
           surface.vertices.size(), surface.triangles.size(), surface.objects.size(),
           surface.objects.size() == 1 ? "" : "s", meshed->report.diagonal) +
      file->unit);
  answer.notes.insert(answer.notes.end(), file->notes.begin(), file->notes.end());
  const std::vector<std::string> lines = describe(meshed->report);
  answer.notes.insert(answer.notes.end(), lines.begin(), lines.end());
  return answer;
}

}  // namespace tremolo
