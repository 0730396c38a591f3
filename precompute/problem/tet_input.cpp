#include "precompute/problem/tet_input.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "common/mesh/mesh_check.h"
#include "common/text.h"
#include "common/units.h"
#include "formats/surface/surface_reader.h"
#include "precompute/system/child_program.h"
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

namespace {

constexpr int kAnswerDescriptor = 3;  // file descriptor on which the child writes its answer

// An anonymous file in memory; it is freed when its descriptor closes.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("tremolo-mesh", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw Failure(os_error("no file in memory for tremolo-mesh"));
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }
  int descriptor() const { return descriptor_; }

  std::vector<std::byte> contents() const {
    struct stat status = {};
    if (::fstat(descriptor_, &status) != 0) throw Failure(os_error("the answer of tremolo-mesh"));
    std::vector<std::byte> bytes(status.st_size);
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t count =
          ::pread(descriptor_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) throw Failure(os_error("the answer of tremolo-mesh"));
      at += count;
    }
    return bytes;
  }

 private:
  int descriptor_;
};

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

// Builds the child's command line; options that were not given are left out.
std::vector<std::string> mesher_arguments(const SolidFiles& files) {
  const SurfaceMeshOptions& meshing = files.meshing;
  std::vector<std::string> arguments = {"tremolo-mesh", files.mesh, "--answer",
                                        std::to_string(kAnswerDescriptor)};
  const auto add = [&arguments](const char* flag, const std::string& value) {
    arguments.emplace_back(flag);
    arguments.push_back(value);
  };
  if (meshing.size > 0) add("--size", number(meshing.size));
  if (meshing.tets > 0) add("--tets", std::to_string(meshing.tets));
  if (meshing.error > 0) add("--error", number(meshing.error));
  if (meshing.thicken > 0) add("--thicken", number(meshing.thicken));
  if (files.unit) add("--unit", files.unit->text);
  if (meshing.fill_holes) arguments.emplace_back("--fill-holes");
  if (meshing.keep_crumbs) arguments.emplace_back("--keep-crumbs");
  return arguments;
}

// Returns the child's wait status.
int run_mesher(const SolidFiles& files, const MemoryFile& answer) {
  std::string looked_at;
  const std::string program = program_beside("tremolo-mesh", looked_at);
  if (program.empty())
    throw Failure(system_error(
        files.mesh + ": a surface is cut by tremolo-mesh, which is not beside this program (" +
        looked_at + "): build it with `cmake --build --preset release --target tremolo-mesh`"));
  return run_child(program, mesher_arguments(files),
                   PassedDescriptor{answer.descriptor(), kAnswerDescriptor}, false);
}

// Turns the drawn triangles that the mesher turned, and the normals that faced in with them.
void turn_drawn(const std::vector<std::int32_t>& turned, RenderSurface& surface) {
  for (const std::int32_t t : turned) {
    std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  }
  if (surface.normals.empty()) return;
  std::vector<Eigen::Vector3d> outwards(surface.vertices.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : surface.triangles) {
    const Eigen::Vector3d& a = surface.vertices[t[0]];
    const Eigen::Vector3d normal = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a);
    for (const VertexId v : t) outwards[v] += normal;
  }
  std::vector<char> seen(surface.vertices.size(), 0);
  for (const std::int32_t t : turned)
    for (const VertexId v : surface.triangles[t]) {
      if (seen[v] != 0) continue;
      seen[v] = 1;
      if (outwards[v].dot(surface.normals[v].cast<double>()) < 0)
        surface.normals[v] = -surface.normals[v];
    }
}

}  // namespace

CutSurface cut_surface(const SolidFiles& files) {
  CutSurface result;
  result.render =
      std::move(unwrap(read_surface(files.mesh, {files.unit ? files.unit->metres : 0.0})).surface);
  const MemoryFile answer;
  const int status = run_mesher(files, answer);
  const std::vector<std::byte> bytes = answer.contents();
  if (WIFSIGNALED(status))
    throw Failure(system_error(files.mesh + ": tremolo-mesh was ended by signal " +
                               std::to_string(WTERMSIG(status)) + " (" +
                               ::strsignal(WTERMSIG(status)) + ")"));
  if (bytes.empty())
    throw Failure(system_error(files.mesh + ": tremolo-mesh ended without an answer, exit " +
                               "code " + std::to_string(WEXITSTATUS(status))));
  Result<MesherAnswer> cut = decode_answer(bytes);
  if (!cut && cut.error().message.rfind(files.mesh, 0) != 0)
    throw Failure({cut.error().kind, files.mesh + ": " + cut.error().message});
  result.cut = unwrap(std::move(cut));
  const auto& turned = result.cut.turned;
  if (!turned.empty() && (turned.front() < 0 || static_cast<std::size_t>(turned.back()) >=
                                                    result.render.triangles.size()))
    throw Failure(system_error(files.mesh + " changed while it was being read"));
  turn_drawn(turned, result.render);
  return result;
}

}  // namespace tremolo
