#include <array>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/text.h"
#include "formats/file/folder_files.h"
#include "formats/file/input_file.h"
#include "formats/polygons/polygon_mesh.h"
#include "formats/surface/gltf_data.h"
#include "formats/surface/surface_answer.h"
#include "formats/surface/surface_flattener.h"

namespace tremolo {
namespace {

// The file's unit, m, and the part of it that assimp has put into the root's transform.
struct Unit {
  double metres = 1;
  std::string words = "the file does not say; taken as metres";
  double applied = 1;
};

// The double that a text would have given: 0.01 for the float next to it.
double decimal(float value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double number = value;
  std::from_chars(text.data(), end, number);
  return number;
}

bool metadata_number(const aiScene& scene, const char* key, double& value) {
  if (scene.mMetaData == nullptr) return false;
  float single = 0;
  if (scene.mMetaData->Get(key, single)) {
    value = decimal(single);
    return true;
  }
  return scene.mMetaData->Get(key, value);
}

bool is_unit(double metres) {
  return std::isfinite(metres) && metres > 0;
}

// scene: null where assimp has not read the file.
Unit unit_of(const aiScene* scene, const std::string& extension) {
  Unit unit;
  if (extension == "gltf" || extension == "glb" || extension == "x3d" || extension == "x3db") {
    unit.words = "metres, as the format has it";
  } else if (extension == "ifc" || extension == "ifczip") {
    unit.words = "metres, into which the file's unit was turned";
  } else if (extension == "dae" || extension == "zae") {
    // assimp multiplies the root, which has no transform of its own, by the unit.
    const double scale = scene->mRootNode->mTransformation.a1;
    if (is_unit(scale)) {
      unit.applied = scale;
      unit.metres = decimal(scene->mRootNode->mTransformation.a1);
      unit.words = "the file's unit of " + number_text(unit.metres) + " m";
    }
  } else if (extension == "fbx") {
    double centimetres = 0;
    if (metadata_number(*scene, "UnitScaleFactor", centimetres) && is_unit(centimetres)) {
      unit.metres = centimetres * 0.01;
      unit.words = "the file's unit of " + number_text(unit.metres) + " m";
    } else {
      unit.metres = 0.01;
      unit.words = "centimetres, as the format has it";
    }
  } else if (extension == "3mf" || extension == "amf") {
    unit.metres = 1e-3;
    unit.words = "millimetres, as the format has it; what the file says of it is not read";
  }
  return unit;
}

std::string format_name(const aiScene* scene, const std::string& extension) {
  static const std::unordered_map<std::string, std::string> names = {
      {"obj", "Wavefront OBJ"}, {"ply", "PLY"},       {"stl", "STL"},           {"off", "OFF"},
      {"gltf", "glTF"},         {"glb", "GLB"},       {"fbx", "Autodesk FBX"},  {"dae", "Collada"},
      {"3ds", "3D Studio"},     {"3mf", "3MF"},       {"blend", "Blender"},     {"x3d", "X3D"},
      {"amf", "AMF"},           {"dxf", "DXF"},       {"lwo", "LightWave LWO"}, {"ac", "AC3D"},
      {"x", "DirectX X"},       {"ms3d", "MilkShape"}};
  const auto known = names.find(extension);
  if (known != names.end()) return known->second;
  aiString importer;
  if (scene != nullptr && scene->mMetaData != nullptr)
    scene->mMetaData->Get("SourceAsset_Format", importer);
  std::string name = printable_text(text_of(importer), kLongestName);
  return name.empty() ? extension : name;
}

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  return lower_case(extension);
}

// The error of assimp, replaced where its text is misleading.
std::string reason(const std::string& said) {
  if (said.empty() || said.starts_with("No suitable reader"))
    return "it is not of the format that its extension says";
  return said;
}

void set_up(Assimp::Importer& importer) {
  // assimp's triangles for a file with only bones are not the author's.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_TEXTURES, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, false);
  // Axes stay as the file has them: selectors speak of the coordinates its author saw.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
}

using PolygonReader = Result<PolygonMesh>(std::string_view bytes, const std::string& name);

// The formats that we read ourselves; null for others.
PolygonReader* polygon_reader(const std::string& extension) {
  if (extension == "obj") return parse_obj_polygons;
  if (extension == "ply") return parse_ply_polygons;
  if (extension == "stl") return parse_stl_polygons;
  if (extension == "off")
    return
        [](std::string_view text, const std::string& /*name*/) { return parse_off_polygons(text); };
  return nullptr;
}

// "line 12: expected ...": the caller puts the file's name before it.
Error without_name(Error error) {
  while (error.message.starts_with(", ") || error.message.starts_with(": "))
    error.message.erase(0, 2);
  return error;
}

Status finish_notes(SurfaceFile& file) {
  if (file.surface.triangles.empty()) {
    std::string message = "it holds no triangles: export the shape as a mesh of polygons";
    for (const std::string& note : file.notes) message += "; " + note;
    return content_error(message);
  }
  for (std::string& note : file.notes) note = printable_text(note, kLongestMessage);
  return Success{};
}

Result<SurfaceFile> import_polygons(const std::string& path, const std::string& extension,
                                    PolygonReader* parse, std::uint64_t bytes) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  Result<PolygonMesh> mesh = parse(*text, "");
  if (!mesh) return without_name(mesh.error());
  if (mesh->vertices.size() * kVertexBytes + mesh->corners.size() * kTriangleBytes > bytes)
    return content_error("its vertices and triangles need more than " +
                         number_text(std::ceil(static_cast<double>(bytes) / 1e6)) + " MB");
  SurfaceFile file;
  const Unit unit = unit_of(nullptr, extension);
  file.format = format_name(nullptr, extension);
  file.metres_per_unit = unit.metres;
  file.unit = unit.words;
  file.surface = render_surface_of(std::move(*mesh), file.notes);
  if (Status s = finish_notes(file); !s) return s.error();
  return file;
}

// Hands assimp the file in terms that it understands.
Status make_gltf_plain(const std::string& path, bool glb, FolderFiles& files) {
  const std::string file = std::filesystem::absolute(path).string();
  auto plain = plain_gltf(files.contents(file), glb,
                          [&files](const std::string& name) { return files.contents(name); });
  if (!plain) return plain.error();
  if (*plain) files.replace_file(std::move(**plain));
  return Success{};
}

Result<SurfaceFile> import_by_assimp(const std::string& path, const std::string& extension,
                                     std::uint64_t bytes) {
  // Never deleted: a scene of deeply nested nodes takes itself apart by recursion, and the process
  // ends soon.
  Assimp::Importer& importer = *new Assimp::Importer;
  auto* files = new FolderFiles(path);
  importer.SetIOHandler(files);  // which deletes it
  set_up(importer);
  const auto note_refused = [files](std::vector<std::string>& notes) {
    for (const std::string& name : files->refused())
      notes.push_back("not opened, since it is no file in this folder: " + name);
  };
  const auto refusal = [&note_refused](std::string message) {
    std::vector<std::string> refused;
    note_refused(refused);
    for (const std::string& note : refused) message += "; " + note;
    return content_error(std::move(message));
  };
  if (extension == "gltf" || extension == "glb")
    if (Status s = make_gltf_plain(path, extension == "glb", *files); !s)
      return refusal(s.error().message);
  const aiScene* scene =
      importer.ReadFile(std::filesystem::absolute(path).string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr)
    return refusal(reason(importer.GetErrorString()));
  const Unit unit = unit_of(scene, extension);
  SurfaceFile file;
  file.format = format_name(scene, extension);
  file.metres_per_unit = unit.metres;
  file.unit = unit.words;
  Flattener flattener(*scene, bytes);
  try {
    flattener.add_nodes(unit.applied);
  } catch (const Refusal& refused) {
    return content_error(refused.message);
  }
  flattener.fill_normals();
  flattener.note_what_was_left_out(file.notes);
  if (!flattener.take_rig(file.notes) && scene->mNumAnimations > 0)
    file.notes.push_back("movements left out: taken in the rest pose");
  note_refused(file.notes);
  file.surface = std::move(flattener.surface);
  if (Status s = finish_notes(file); !s) return s.error();
  return file;
}

}  // namespace

Result<SurfaceFile> import_surface(const std::string& path, std::uint64_t bytes) {
  const std::string extension = lower_extension(path);
  if (PolygonReader* parse = polygon_reader(extension))
    return import_polygons(path, extension, parse, bytes);
  return import_by_assimp(path, extension, bytes);
}

}  // namespace tremolo
