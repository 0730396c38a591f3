// Tetrahedral mesh files -> TetMesh, and Gmsh's back. docs/meshes.md lists the formats.
#pragma once

#include <string>
#include <string_view>
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

// Gmsh's MSH 2.x and 4.1, text and binary in both byte orders. Physical groups become node sets.
Result<MeshFile> read_msh(std::string_view text, const std::string& path);
// VTK legacy unstructured grid, text and binary (big-endian).
Result<MeshFile> read_vtk(std::string_view text, const std::string& path);
// VTK XML unstructured grid: text, base64 or raw, inside the elements or appended, compressed by
// zlib or LZ4 or not, of one piece or several; and .pvtu, whose pieces are such files beside it.
Result<MeshFile> read_vtu(std::string_view text, const std::string& path);
// VegaFEM's .veg. *INCLUDE takes files from the same folder, each once.
Result<MeshFile> read_veg(std::string_view text, const std::string& path);
// VegaFEM's .vegb, version 1, tetrahedra.
Result<MeshFile> read_vegb(std::string_view bytes, const std::string& path);
// Abaqus's input file and those that it includes: solids of all parts, where their instances place
// them, with node and element sets.
Result<MeshFile> read_inp(std::string_view text, const std::string& path);
// Nastran's bulk data, small, large and free field. Properties (PID) and sets become node sets.
Result<MeshFile> read_bdf(std::string_view text, const std::string& path);
// TetGen's NAME.node and NAME.ele; path is either of the two.
Result<MeshFile> read_tetgen(const std::string& path);
// The same of their contents.
Result<MeshFile> read_tetgen_texts(std::string_view nodes, const std::string& node_path,
                                   std::string_view elements, const std::string& ele_path);

// Writes one block of tetrahedra without tags; node sets are left out (MSH 2.2 has none). Written
// whole or not at all. Errors: kSystem if the file cannot be written.
Status write_msh(const std::string& path, const TetMesh& mesh);

}  // namespace tremolo
