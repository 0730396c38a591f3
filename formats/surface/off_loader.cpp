#include "formats/surface/off_loader.h"

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/fast_atof.h>
#include <assimp/importerdesc.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "formats/surface/off_text.h"

namespace tremolo {
namespace {

constexpr aiImporterDesc kDescription = {
    "OFF Importer", "", "", "", aiImporterFlags_SupportTextFlavour, 0, 0, 0, 0, "off"};

std::string contents_of(const std::string& file, Assimp::IOSystem& files) {
  const auto close = [&files](Assimp::IOStream* stream) { files.Close(stream); };
  const std::unique_ptr<Assimp::IOStream, decltype(close)> stream(files.Open(file.c_str(), "rb"),
                                                                  close);
  if (stream == nullptr) throw std::runtime_error("it cannot be opened");
  std::string text(stream->FileSize(), '\0');
  if (stream->Read(text.data(), 1, text.size()) != text.size())
    throw std::runtime_error("it cannot be read to its end");
  return text;
}

// A vertex is one of the file's, or one of the file's for each colour that a face gives it.
struct Corners {
  std::vector<VertexId> source;     // of each vertex: the file's
  std::vector<OffNumbers> colours;  // of each vertex, or none
  std::vector<unsigned> vertex;     // of each corner
};

Corners take_corners(const OffMesh& off) {
  Corners corners;
  corners.vertex.reserve(off.corners.size());
  if (off.face_colours.empty()) {
    for (std::size_t v = 0; v < off.coordinates.size(); ++v)
      corners.source.push_back(static_cast<VertexId>(v));
    corners.colours = off.colours;
    corners.vertex.assign(off.corners.begin(), off.corners.end());
    return corners;
  }
  std::map<std::pair<VertexId, OffNumbers>, unsigned> taken;
  for (std::size_t f = 0; f + 1 < off.first.size(); ++f)
    for (std::size_t i = off.first[f]; i < off.first[f + 1]; ++i) {
      const OffNumbers& colour = off.face_colours[f];
      const auto [at, fresh] =
          taken.try_emplace({off.corners[i], colour}, static_cast<unsigned>(corners.source.size()));
      if (fresh) {
        corners.source.push_back(off.corners[i]);
        corners.colours.push_back(colour);
      }
      corners.vertex.push_back(at->second);
    }
  return corners;
}

// assimp's own is not exported.
struct NumberError : std::runtime_error {
  template <class... Texts>
  explicit NumberError(Texts&&... /*texts*/) : runtime_error("a coordinate is no number") {}
};

// Rounded as assimp rounds an OBJ's, to the bit. The text ends in a NUL.
aiVector3D position_of(const std::array<std::string_view, 3>& written) {
  aiVector3D position;
  for (unsigned axis = 0; axis < 3; ++axis)
    Assimp::fast_atoreal_move<ai_real, NumberError>(written[axis].data(), position[axis], false);
  return position;
}

void fill_vertices(const OffMesh& off, const Corners& corners, aiMesh& mesh) {
  const std::size_t count = corners.source.size();
  mesh.mNumVertices = static_cast<unsigned>(count);
  mesh.mVertices = new aiVector3D[count];
  if (!off.normals.empty()) mesh.mNormals = new aiVector3D[count];
  if (!corners.colours.empty()) mesh.mColors[0] = new aiColor4D[count];
  if (!off.uvs.empty()) {
    mesh.mTextureCoords[0] = new aiVector3D[count];
    mesh.mNumUVComponents[0] = 2;
  }
  for (std::size_t v = 0; v < count; ++v) {
    const std::size_t source = corners.source[v];
    mesh.mVertices[v] = position_of(off.coordinates[source]);
    if (mesh.mNormals != nullptr) {
      const OffNumbers& n = off.normals[source];
      mesh.mNormals[v] = {n[0], n[1], n[2]};
    }
    if (mesh.mTextureCoords[0] != nullptr) {
      const OffNumbers& uv = off.uvs[source];
      mesh.mTextureCoords[0][v] = {uv[0], uv[1], 0};
    }
    if (mesh.mColors[0] != nullptr) {
      const OffNumbers& c = corners.colours[v];
      mesh.mColors[0][v] = {c[0], c[1], c[2], c[3]};
    }
  }
}

void fill_faces(const OffMesh& off, const Corners& corners, aiMesh& mesh) {
  const std::size_t count = off.first.size() - 1;
  mesh.mNumFaces = static_cast<unsigned>(count);
  mesh.mFaces = new aiFace[count];
  for (std::size_t f = 0; f < count; ++f) {
    aiFace& face = mesh.mFaces[f];
    face.mNumIndices = static_cast<unsigned>(off.first[f + 1] - off.first[f]);
    face.mIndices = new unsigned[face.mNumIndices];
    std::copy_n(corners.vertex.begin() + off.first[f], face.mNumIndices, face.mIndices);
  }
}

}  // namespace

bool OffLoader::CanRead(const std::string& file, Assimp::IOSystem* /*files*/,
                        bool /*look_inside*/) const {
  return SimpleExtensionCheck(file, "off");
}

const aiImporterDesc* OffLoader::GetInfo() const {
  return &kDescription;
}

void OffLoader::InternReadFile(const std::string& file, aiScene* scene, Assimp::IOSystem* files) {
  const std::string text = contents_of(file, *files);
  Result<OffMesh> off = parse_off(text);
  if (!off) throw std::runtime_error(off.error().message);
  if (off->corners.empty()) throw std::runtime_error("it holds no faces");
  notes_ = std::move(off->notes);
  const Corners corners = take_corners(*off);
  auto* mesh = new aiMesh;
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { mesh };
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  const aiString name(AI_DEFAULT_MATERIAL_NAME);
  scene->mMaterials[0]->AddProperty(&name, AI_MATKEY_NAME);
  scene->mRootNode = new aiNode("<OFFRoot>");
  scene->mRootNode->mNumMeshes = 1;
  scene->mRootNode->mMeshes = new unsigned[1]{0};
  fill_vertices(*off, corners, *mesh);
  fill_faces(*off, corners, *mesh);
}

}  // namespace tremolo
