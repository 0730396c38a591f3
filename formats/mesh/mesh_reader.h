// Tetrahedral mesh files -> TetMesh. docs/meshes.md lists the formats.
#pragma once

#include <string>
#include <vector>

#include "common/material.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// A material that the file itself gives to one of its regions.
struct FileMaterial {
  std::string region;
  Material material;
  std::string problem;  // why it cannot be used; empty if it can
};

// mesh: vertices in the file's order, coordinates as they stand in the file (taken as metres),
// tetrahedra in the file's order and orientation: check_mesh() is still to see them. Of quadratic
// tetrahedra the mesh has `edges`, which straighten_edges() is still to see.
// format: what was read, "MSH 4.1 binary". notes: sentences about what was left out.
// materials: of regions, in the order of the file; not checked.
struct MeshFile {
  TetMesh mesh;
  std::string format;
  std::vector<std::string> notes;
  std::vector<FileMaterial> materials = {};
};

// Recognises the format by the file's first line, then by its extension. Cells that are not
// tetrahedra are skipped and noted; named groups become node sets, groups of tetrahedra regions as
// well. Nothing in the file is trusted: memory is bounded by its size. Errors: kSystem for a file
// that is missing or unreadable, kContent with line (text) or byte offset (binary), what was
// expected and what was found for all others.
Result<MeshFile> read_tet_mesh(const std::string& path);

}  // namespace tremolo
