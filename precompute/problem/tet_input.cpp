#include "precompute/problem/tet_input.h"

#include <optional>
#include <utility>

#include "common/mesh/coincident_vertices.h"
#include "common/number_text.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// Extents outside these bounds, in m, suggest a missing unit; surfaces use the same bounds.
constexpr double kVeryLarge = 100;
constexpr double kVerySmall = 1e-3;

// Rejects options for surfaces, which would otherwise be ignored silently.
void refuse_surface_options(const SolidFiles& files) {
  const SurfaceMeshOptions& meshing = files.meshing;
  const std::pair<bool, const char*> given[] = {
      {meshing.tets > 0, "--tets"},         {meshing.size > 0, "--size"},
      {meshing.error > 0, "--error"},       {meshing.thicken > 0, "--thicken"},
      {meshing.fill_holes, "--fill-holes"}, {meshing.keep_crumbs, "--keep-crumbs"}};
  for (const auto& [is_given, name] : given)
    if (is_given)
      throw Failure({ErrorKind::kUsage, std::string(name) +
                                            " applies to meshing a surface: " + files.mesh +
                                            " is tetrahedra already, which are taken as they are"});
}

void to_metres(const SolidFiles& files, double metres, TetMesh& mesh) {
  for (Eigen::Vector3d& x : mesh.vertices) {
    x *= metres;
    if (!x.allFinite())
      throw Failure(content_error(files.mesh + ": in units of " + number_text(metres) +
                                  " m its coordinates are too large for a number"));
  }
}

// Considers vertices of tetrahedra only, as unused ones may lie anywhere. Indices are not yet
// checked.
double extent(const TetMesh& mesh) {
  std::vector<Eigen::Vector3d> used;
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (const VertexId v : tet)
      if (v >= 0 && static_cast<std::size_t>(v) < mesh.vertices.size())
        used.push_back(mesh.vertices[v]);
  return bounding_box(used).diagonal();
}

// Vertices that lie at one place are joined by --merge. Without it they are counted, as bodies that
// were written separately, or that may slide on each other, have them on purpose.
void join_or_count(bool merge, bool imported, MeshFile& file) {
  if (merge && imported)
    throw Failure({ErrorKind::kUsage,
                   "an imported basis has rows for the vertices of its mesh: --merge would change "
                   "the mesh alone"});
  const Coincidences found = find_coincidences(file.mesh);
  if (merge) {
    merge_vertices(found, file.mesh);
    file.notes.push_back(
        std::to_string(found.pairs) +
        " pairs of coincident vertices are merged (--merge): each second one stays, "
        "in no tetrahedron");
  } else if (found.pairs > 0) {
    file.notes.push_back(std::to_string(found.pairs) + kCoincidentNote);
  }
}

}  // namespace

MeshFile load_tetrahedra(const SolidFiles& files, bool imported) {
  refuse_surface_options(files);
  const bool surface_has_it = !files.render.empty();
  const std::optional<LengthUnit>& unit =
      files.mesh_unit || surface_has_it ? files.mesh_unit : files.unit;
  if (unit && imported)
    throw Failure({ErrorKind::kUsage,
                   "an imported basis and its forces are in the units of their mesh: --unit and "
                   "--mesh-unit would change the mesh alone"});
  MeshFile file = unwrap(read_tet_mesh(files.mesh));
  if (unit) {
    to_metres(files, unit->metres, file.mesh);
    file.notes.push_back("the mesh's unit: " + unit->text + ", given");
  }
  const std::string flag = surface_has_it ? "--mesh-unit" : "--unit";
  if (!unit && files.unit)
    file.notes.push_back(
        "--unit " + files.unit->text +
        " applies to the render surface; the mesh's coordinates are taken as metres "
        "(else: --mesh-unit)");
  const double size = extent(file.mesh);
  if (!unit && size > 0 && (size > kVeryLarge || size < kVerySmall))
    file.notes.push_back("the mesh is " + number_text(size) +
                         " m across: if its unit is not 1 m, say so, as in " + flag + " mm or " +
                         flag + " cm");
  join_or_count(files.merge, imported, file);
  return file;
}

}  // namespace tremolo
