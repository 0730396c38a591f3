// Tetrahedral mesh files -> TetMesh. docs/meshes.md lists the formats.
#pragma once

#include <string>
#include <vector>

#include "common/material.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// A material in the file for one of its regions.
struct FileMaterial {
  std::string region;
  Material material;
  std::string problem;  // why it cannot be used; empty if it can
};

// The contents of a mesh file.
struct MeshFile {
  // Vertices in the file's order with its coordinates (as metres), tetrahedra in the file's order
  // and orientation, before check_mesh(). Quadratic tetrahedra have `edges`, before
  // straighten_edges().
  TetMesh mesh;
  std::string format;                        // "MSH 4.1 binary"
  std::vector<std::string> notes;            // sentences about omitted parts
  std::vector<FileMaterial> materials = {};  // of regions, in the order of the file; not checked
};

// Recognises the format by the file's first line, then by its extension. Cells other than
// tetrahedra are skipped and noted; named groups become node sets, groups of tetrahedra regions as
// well. The file is untrusted: memory is bounded by its size. Errors: kSystem for a file that is
// missing or unreadable, else kContent with line (text) or byte offset (binary), the expected and
// the found text.
Result<MeshFile> read_tet_mesh(const std::string& path);

}  // namespace tremolo
