// One reader per format, behind read_tet_mesh(). Each takes the bytes of the file and its path,
// which is for errors and for finding a second file in the same folder.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {

// Gmsh's MSH 2.x and 4.1, text and binary in both byte orders. Physical groups become node sets.
Result<MeshFile> read_msh(std::string_view text, const std::string& path);
// VTK legacy unstructured grid, text and binary (big-endian).
Result<MeshFile> read_vtk(std::string_view text, const std::string& path);
// VTK XML unstructured grid: text, base64 or raw, inside the elements or appended, compressed by zlib
// or LZ4 or not, of one piece or several.
Result<MeshFile> read_vtu(std::string_view text, const std::string& path);
// VegaFEM's .veg. *INCLUDE takes files from the same folder, each once.
Result<MeshFile> read_veg(std::string_view text, const std::string& path);
// VegaFEM's .vegb, version 1, tetrahedra.
Result<MeshFile> read_vegb(std::string_view bytes, const std::string& path);
// Abaqus's input file: solids of all parts at the positions of their instances, with node and
// element sets.
Result<MeshFile> read_inp(std::string_view text, const std::string& path);
// Nastran's bulk data, small, large and free field. Properties (PID) and sets become node sets.
Result<MeshFile> read_bdf(std::string_view text, const std::string& path);
// TetGen's NAME.node and NAME.ele; path is either of the two.
Result<MeshFile> read_tetgen(const std::string& path);
// The same of their contents.
Result<MeshFile> read_tetgen_texts(std::string_view nodes, const std::string& node_path,
                                   std::string_view elements, const std::string& ele_path);

}  // namespace tremolo
