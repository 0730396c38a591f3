// check_mesh FILE: the quality of a mesh for its next reader. One line: tetrahedra, smallest
// dihedral angle in degrees, volume in m^3, parts. Exit code 3 and a message if they would refuse
// it, or if an element is inverted.
#include <cstdio>

#include "common/mesh/mesh_check.h"
#include "common/mesh/mesh_quality.h"
#include "formats/mesh/mesh_reader.h"

int main(int count, char** words) {
  using namespace tremolo;
  if (count != 2) {
    std::fprintf(stderr, "usage: check_mesh FILE\n");
    return exit_code({ErrorKind::kUsage, ""});
  }
  const auto refuse = [](const Error& error) {
    std::fprintf(stderr, "check_mesh: %s\n", error.message.c_str());
    return exit_code(error);
  };
  Result<MeshFile> file = read_tet_mesh(words[1]);
  if (!file) return refuse(file.error());
  const Result<MeshReport> report = check_mesh(file->mesh);
  if (!report) return refuse(report.error());
  if (report->flipped > 0)
    return refuse(content_error(std::to_string(report->flipped) + " inverted tetrahedra"));
  const MeshQuality quality = mesh_quality(file->mesh);
  std::printf("%zu %.1f %.4g %zu\n", file->mesh.tetrahedra.size(), quality.min_dihedral_deg,
              quality.volume, report->parts);
  return 0;
}
