#include "formats/surface_scene.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <cmath>
#include <filesystem>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "common/number_text.h"
#include "formats/folder_files.h"
#include "formats/surface_answer.h"

namespace tremolo {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// What one vertex and one triangle take in a RenderSurface.
constexpr std::uint64_t kVertexBytes = 48;
constexpr std::uint64_t kTriangleBytes = 20;

// Why a scene cannot become a surface.
struct Refusal {
  std::string message;
};

std::string_view text_of(const aiString& text) {
  return {text.data, std::min<std::size_t>(text.length, sizeof(text.data) - 1)};
}

// Names as they are asked for, each made printable and different from those before.
class UniqueNames {
 public:
  explicit UniqueNames(std::string nameless) : nameless_(std::move(nameless)) {}

  std::string take(std::string_view wanted) {
    // Room for a number.
    std::string name = printable_text(wanted, kLongestName - 16);
    if (name.find_first_not_of(' ') == std::string::npos) name = nameless_;
    if (taken_.insert(name).second) return name;
    std::uint64_t& count = repeats_.try_emplace(name, 1).first->second;
    for (;;) {
      std::string numbered = name + " " + std::to_string(++count);
      if (taken_.insert(numbered).second) return numbered;
    }
  }

 private:
  std::string nameless_;
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::uint64_t> repeats_;
};

// Empty if an importer made it up: "<OFFRoot>".
std::string_view given_name(const aiString& text) {
  const std::string_view name = text_of(text);
  return name.starts_with('<') && name.ends_with('>') ? std::string_view() : name;
}

Matrix4d matrix_of(const aiMatrix4x4& m) {
  Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return matrix;
}

// Where a node puts its meshes. normals: the cofactors, which are the inverse transposed times the
// determinant and exist for flat transforms too; turned for mirrors, so that outside stays outside.
struct Placement {
  explicit Placement(const Matrix4d& world)
      : linear(world.topLeftCorner<3, 3>()), offset(world.topRightCorner<3, 1>()) {
    const double determinant = linear.determinant();
    mirrored = determinant < 0;
    for (int i = 0; i < 3; ++i)
      normals.col(i) = linear.col((i + 1) % 3).cross(linear.col((i + 2) % 3));
    if (mirrored) normals = -normals;
  }

  Eigen::Matrix3d linear;
  Vector3d offset;
  Eigen::Matrix3d normals;
  bool mirrored = false;
};

std::uint8_t channel_byte(float value) {
  // Written so that NaN becomes 0.
  return static_cast<std::uint8_t>(value > 0 ? std::lround(std::min(value, 1.0F) * 255.0F) : 0);
}

// One mesh after the other, each where its node puts it.
class Flattener {
 public:
  Flattener(const aiScene& scene, std::uint64_t bytes) : scene_(scene), bytes_(bytes) {}

  void add_nodes(double file_scale);
  void fill_normals();
  void note_what_was_left_out(std::vector<std::string>& notes) const;

  RenderSurface surface;

 private:
  void add_mesh(const aiMesh& mesh, const Placement& place);
  bool take_vertex(const aiMesh& mesh, unsigned index, const Placement& place);
  VertexId vertex_of(const aiMesh& mesh, unsigned index, const Placement& place);
  std::uint32_t material_of(unsigned index);

  const aiScene& scene_;
  std::uint64_t bytes_;
  std::vector<VertexId> taken_;  // of the mesh at hand: the surface's vertices of the mesh's
  std::vector<bool> has_normal_;
  bool any_normal_ = false;
  bool any_uv_ = false;
  bool any_colour_ = false;
  UniqueNames object_names_{"object"};
  UniqueNames material_names_{"material"};
  std::unordered_map<unsigned, std::uint32_t> materials_;
  std::uint64_t points_ = 0;
  std::uint64_t lines_ = 0;
  std::uint64_t polygons_ = 0;
  std::uint64_t not_finite_ = 0;
  std::uint64_t skinned_ = 0;
};

constexpr VertexId kNotTaken = -1;
constexpr VertexId kNotFinite = -2;

std::uint32_t Flattener::material_of(unsigned index) {
  const auto [entry, fresh] =
      materials_.try_emplace(index, static_cast<std::uint32_t>(surface.materials.size()));
  if (fresh) {
    aiString name;
    if (index < scene_.mNumMaterials && scene_.mMaterials[index] != nullptr)
      scene_.mMaterials[index]->Get(AI_MATKEY_NAME, name);
    surface.materials.push_back(material_names_.take(text_of(name)));
  }
  return entry->second;
}

// Gives every vertex all channels: which of them the surface has is seen at the end.
VertexId Flattener::vertex_of(const aiMesh& mesh, unsigned index, const Placement& place) {
  VertexId& taken = taken_[index];
  if (taken != kNotTaken) return taken;
  const aiVector3D& at = mesh.mVertices[index];
  const Vector3d x = place.linear * Vector3d(at.x, at.y, at.z) + place.offset;
  if (!x.allFinite()) return taken = kNotFinite;
  taken = static_cast<VertexId>(surface.vertices.size());
  surface.vertices.push_back(x);

  Vector3d n = Vector3d::Zero();
  if (mesh.mNormals != nullptr) {
    const aiVector3D& given = mesh.mNormals[index];
    n = (place.normals * Vector3d(given.x, given.y, given.z)).stableNormalized();
  }
  const bool good = n.allFinite() && std::abs(n.norm() - 1) < 1e-6;
  surface.normals.push_back(good ? Vector3f(n.cast<float>()) : Vector3f(0, 0, 1));
  has_normal_.push_back(good);
  any_normal_ |= good;

  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
  if (mesh.mTextureCoords[0] != nullptr) {
    uv = {mesh.mTextureCoords[0][index].x, mesh.mTextureCoords[0][index].y};
    any_uv_ = true;
  }
  surface.uvs.push_back(uv.allFinite() ? uv : Eigen::Vector2f(0, 0));

  Colour colour = {255, 255, 255, 255};
  if (mesh.mColors[0] != nullptr) {
    const aiColor4D& given = mesh.mColors[0][index];
    colour = {channel_byte(given.r), channel_byte(given.g), channel_byte(given.b),
              channel_byte(given.a)};
    any_colour_ = true;
  }
  surface.colours.push_back(colour);
  return taken;
}

void Flattener::add_mesh(const aiMesh& mesh, const Placement& place) {
  if (mesh.mVertices == nullptr || mesh.mFaces == nullptr) return;
  const std::uint64_t vertices = surface.vertices.size() + std::uint64_t{mesh.mNumVertices};
  const std::uint64_t triangles = surface.triangles.size() + std::uint64_t{mesh.mNumFaces};
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<VertexId>::max());
  if (vertices > kMost || triangles > kMost ||
      vertices * kVertexBytes + triangles * kTriangleBytes > bytes_)
    throw Refusal{"its scene shows so many copies of its meshes that they need more than " +
                  number_text(std::ceil(static_cast<double>(bytes_) / 1e6)) + " MB"};
  if (mesh.HasBones() || mesh.mNumAnimMeshes > 0) ++skinned_;
  taken_.assign(mesh.mNumVertices, kNotTaken);
  const auto object = static_cast<std::uint32_t>(surface.objects.size() - 1);
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) {
      ++(face.mNumIndices < 2 ? points_ : face.mNumIndices == 2 ? lines_ : polygons_);
      continue;
    }
    Triangle triangle = {};
    for (int corner = 0; corner < 3; ++corner) {
      const unsigned index = face.mIndices[corner];
      if (index >= mesh.mNumVertices)
        throw Refusal{"face " + std::to_string(f) + " of a mesh names vertex " +
                      std::to_string(index) + " of " + std::to_string(mesh.mNumVertices)};
      triangle[corner] = vertex_of(mesh, index, place);
    }
    if (std::find(triangle.begin(), triangle.end(), kNotFinite) != triangle.end()) {
      ++not_finite_;
      continue;
    }
    if (place.mirrored) std::swap(triangle[1], triangle[2]);
    surface.triangles.push_back(triangle);
    surface.object_of.push_back(object);
    surface.material_of.push_back(material_of(mesh.mMaterialIndex));
  }
}

// Walks without recursion: a file may nest its nodes as deep as it likes.
void Flattener::add_nodes(double file_scale) {
  struct Visit {
    const aiNode* node;
    Matrix4d parent;
  };
  Matrix4d root = Matrix4d::Identity();
  root.topLeftCorner<3, 3>() *= 1.0 / file_scale;
  std::vector<Visit> stack = {{scene_.mRootNode, root}};
  while (!stack.empty()) {
    const auto [node, parent] = stack.back();
    stack.pop_back();
    const Matrix4d world = parent * matrix_of(node->mTransformation);
    const std::size_t before = surface.triangles.size();
    surface.objects.emplace_back();
    std::string_view name = given_name(node->mName);
    const Placement place(world);
    for (unsigned m = 0; m < node->mNumMeshes; ++m) {
      if (node->mMeshes[m] >= scene_.mNumMeshes) throw Refusal{"a node names a mesh that is not"};
      const aiMesh& mesh = *scene_.mMeshes[node->mMeshes[m]];
      if (name.empty()) name = given_name(mesh.mName);
      add_mesh(mesh, place);
    }
    if (surface.triangles.size() == before)
      surface.objects.pop_back();
    else
      surface.objects.back() = object_names_.take(name);
    for (unsigned child = node->mNumChildren; child-- > 0;)
      stack.push_back({node->mChildren[child], world});
  }
  if (!any_uv_) surface.uvs.clear();
  if (!any_colour_) surface.colours.clear();
}

// Vertices without a normal get that of their triangles, weighted by area.
void Flattener::fill_normals() {
  if (!any_normal_) {
    surface.normals.clear();
    return;
  }
  if (std::find(has_normal_.begin(), has_normal_.end(), false) == has_normal_.end()) return;
  std::vector<Vector3d> sums(surface.vertices.size(), Vector3d::Zero());
  for (const Triangle& triangle : surface.triangles) {
    const Vector3d& a = surface.vertices[triangle[0]];
    const Vector3d twice_area =
        (surface.vertices[triangle[1]] - a).cross(surface.vertices[triangle[2]] - a);
    for (const VertexId v : triangle) sums[v] += twice_area;
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const Vector3d n = sums[v].stableNormalized();
    // A vertex of flat triangles only keeps what stands there.
    if (!has_normal_[v] && n.allFinite() && std::abs(n.norm() - 1) < 1e-6)
      surface.normals[v] = n.cast<float>();
  }
}

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void Flattener::note_what_was_left_out(std::vector<std::string>& notes) const {
  if (points_ > 0) notes.push_back(counted(points_, "point", "points") + " left out");
  if (lines_ > 0) notes.push_back(counted(lines_, "line", "lines") + " left out");
  if (polygons_ > 0)
    notes.push_back(counted(polygons_, "polygon", "polygons") +
                    " that could not be cut into triangles left out");
  if (not_finite_ > 0)
    notes.push_back(counted(not_finite_, "triangle", "triangles") +
                    " with coordinates that are no numbers left out");
  if (skinned_ > 0) notes.push_back("skins and shapes that move: taken in their rest pose");
}

// The file's unit, m, and what of it assimp has put into the root's transform.
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

Unit unit_of(const aiScene& scene, const std::string& extension) {
  Unit unit;
  if (extension == "gltf" || extension == "glb" || extension == "x3d" || extension == "x3db") {
    unit.words = "metres, as the format has it";
  } else if (extension == "ifc" || extension == "ifczip") {
    unit.words = "metres, into which the file's unit was turned";
  } else if (extension == "dae" || extension == "zae") {
    // assimp multiplies the root, which has no transform of its own, by the unit.
    const double scale = scene.mRootNode->mTransformation.a1;
    if (is_unit(scale)) {
      unit.applied = scale;
      unit.metres = decimal(scene.mRootNode->mTransformation.a1);
      unit.words = "the file's unit of " + number_text(unit.metres) + " m";
    }
  } else if (extension == "fbx") {
    double centimetres = 0;
    if (metadata_number(scene, "UnitScaleFactor", centimetres) && is_unit(centimetres)) {
      unit.metres = centimetres * 0.01;
      unit.words = "the file's unit of " + number_text(unit.metres) + " m";
    } else {
      unit.metres = 0.01;
      unit.words = "centimetres, as the format has it";
    }
  } else if (extension == "3mf" || extension == "amf") {
    unit.metres = 1e-3;
    unit.words = "millimetres, as the format has it where a file does not say (not looked at)";
  }
  return unit;
}

std::string format_name(const aiScene& scene, const std::string& extension) {
  static const std::unordered_map<std::string, std::string> names = {
      {"obj", "Wavefront OBJ"}, {"ply", "PLY"},       {"stl", "STL"},           {"off", "OFF"},
      {"gltf", "glTF"},         {"glb", "GLB"},       {"fbx", "Autodesk FBX"},  {"dae", "Collada"},
      {"3ds", "3D Studio"},     {"3mf", "3MF"},       {"blend", "Blender"},     {"x3d", "X3D"},
      {"amf", "AMF"},           {"dxf", "DXF"},       {"lwo", "LightWave LWO"}, {"ac", "AC3D"},
      {"x", "DirectX X"},       {"ms3d", "MilkShape"}};
  const auto known = names.find(extension);
  if (known != names.end()) return known->second;
  aiString importer;
  if (scene.mMetaData != nullptr) scene.mMetaData->Get("SourceAsset_Format", importer);
  std::string name = printable_text(text_of(importer), kLongestName);
  return name.empty() ? extension : name;
}

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

void set_up(Assimp::Importer& importer) {
  // Triangles for bones, where a file has bones alone, are not the author's.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_TEXTURES, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, false);
  // Axes stay as the file has them: selectors speak of the coordinates its author saw.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
}

}  // namespace

Result<SurfaceFile> import_surface(const std::string& path, std::uint64_t bytes) {
  Assimp::Importer importer;
  auto* files = new FolderFiles(path);
  importer.SetIOHandler(files);  // which deletes it
  set_up(importer);
  const aiScene* scene =
      importer.ReadFile(std::filesystem::absolute(path).string(), aiProcess_Triangulate);
  const auto note_refused = [files](std::vector<std::string>& notes) {
    for (const std::string& name : files->refused())
      notes.push_back("not opened, since it is no file in this folder: " + name);
  };
  if (scene == nullptr || scene->mRootNode == nullptr) {
    std::vector<std::string> reasons = {importer.GetErrorString()};
    note_refused(reasons);
    std::string message;
    for (const std::string& reason : reasons)
      if (!reason.empty()) message += (message.empty() ? "" : "; ") + reason;
    if (message.empty() || message.starts_with("No suitable reader"))
      message = "it is not of the format that its extension says";
    return content_error(message);
  }
  const std::string extension = lower_extension(path);
  const Unit unit = unit_of(*scene, extension);
  SurfaceFile file;
  file.format = format_name(*scene, extension);
  file.metres_per_unit = unit.metres;
  file.unit = unit.words;
  Flattener flattener(*scene, bytes);
  try {
    flattener.add_nodes(unit.applied);
  } catch (const Refusal& refusal) {
    return content_error(refusal.message);
  }
  flattener.fill_normals();
  flattener.note_what_was_left_out(file.notes);
  if (scene->mNumAnimations > 0) file.notes.push_back("movements left out: taken in the rest pose");
  note_refused(file.notes);
  file.surface = std::move(flattener.surface);
  if (file.surface.triangles.empty()) {
    std::string message = "it holds no triangles";
    for (const std::string& note : file.notes) message += "; " + note;
    return content_error(message);
  }
  for (std::string& note : file.notes) note = printable_text(note, kLongestMessage);
  return file;
}

}  // namespace tremolo
