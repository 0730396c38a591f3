#include "formats/mesh/mesh_reader.h"

#include <filesystem>
#include <string_view>

#include "common/text.h"
#include "formats/file/input_file.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

enum class MeshFormat { kMsh, kVtk, kVtu, kVeg, kVegb, kInp, kBdf, kUnknown };

MeshFormat format_of_first_line(std::string_view text) {
  TextScanner scanner(text, "");
  const std::string_view first = scanner.peek();
  if (first == "$MeshFormat") return MeshFormat::kMsh;
  if (first == "<?xml" || first == "<VTKFile") return MeshFormat::kVtu;
  if (without_mark(text).starts_with("# vtk DataFile")) return MeshFormat::kVtk;
  // A .veg file may open with comments.
  TextScanner uncommented(text, "", {.comment = '#'});
  const std::string_view keyword = uncommented.peek();
  const std::string upper = upper_case(first);
  if (upper == "*INCLUDE,") return MeshFormat::kInp;  // VegaFEM has no comma there
  for (const std::string_view abaqus : {"*HEADING", "*NODE", "*PART"})
    if (upper == abaqus || upper == std::string(abaqus) + ",") return MeshFormat::kInp;
  if (upper == "BEGIN" || upper == "SOL" || upper == "CEND") return MeshFormat::kBdf;
  if (keyword.starts_with("*VERTICES") || keyword.starts_with("*INCLUDE")) return MeshFormat::kVeg;
  return MeshFormat::kUnknown;
}

MeshFormat format_of_extension(const std::string& extension) {
  if (extension == ".msh") return MeshFormat::kMsh;
  if (extension == ".vtk") return MeshFormat::kVtk;
  if (extension == ".vtu" || extension == ".pvtu") return MeshFormat::kVtu;
  if (extension == ".veg") return MeshFormat::kVeg;
  if (extension == ".vegb") return MeshFormat::kVegb;
  if (extension == ".inp") return MeshFormat::kInp;
  if (extension == ".bdf" || extension == ".nas" || extension == ".fem") return MeshFormat::kBdf;
  return MeshFormat::kUnknown;
}

}  // namespace

Result<MeshFile> read_tet_mesh(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".node" || extension == ".ele") return read_tetgen(path);
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  MeshFormat format = format_of_first_line(*text);
  if (format == MeshFormat::kUnknown) format = format_of_extension(extension);
  switch (format) {
    case MeshFormat::kMsh:
      return read_msh(*text, path);
    case MeshFormat::kVtk:
      return read_vtk(*text, path);
    case MeshFormat::kVtu:
      return read_vtu(*text, path);
    case MeshFormat::kVeg:
      return read_veg(*text, path);
    case MeshFormat::kVegb:
      return read_vegb(*text, path);
    case MeshFormat::kInp:
      return read_inp(*text, path);
    case MeshFormat::kBdf:
      return read_bdf(*text, path);
    case MeshFormat::kUnknown:
      break;
  }
  return content_error(path +
                       ", line 1: expected a tetrahedral mesh (.msh 2.2 or 4.1, .vtk, .vtu, .pvtu, "
                       ".inp, .bdf, .veg, "
                       ".vegb, .node/.ele), found " +
                       quoted_text(TextScanner(*text, path).rest_of_line()) +
                       ". A surface is known by the extension of its name: .obj, .ply, .stl, .off, "
                       ".gltf, .glb, .fbx, .dae, .3ds and the others of assimp");
}

}  // namespace tremolo
