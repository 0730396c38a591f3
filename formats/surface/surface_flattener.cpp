#include "formats/surface/surface_flattener.h"

#include <algorithm>
#include <assimp/scene.h>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Dense>

#include "common/text.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr VertexId kNotTaken = -1;
constexpr VertexId kNotFinite = -2;

// Empty if an importer made it up: "<OFFRoot>", "$ColladaAutoName$_0".
std::string_view given_name(const aiString& text) {
  const std::string_view name = text_of(text);
  const bool made_up =
      (name.starts_with('<') && name.ends_with('>')) || name.starts_with("$ColladaAutoName$");
  return made_up ? std::string_view() : name;
}

std::uint8_t channel_byte(float value) {
  // Written so that NaN becomes 0.
  return static_cast<std::uint8_t>(value > 0 ? std::lround(std::min(value, 1.0F) * 255.0F) : 0);
}

}  // namespace

// The transform of a node's meshes. normals: the cofactor matrix, which is the inverse transposed
// times the determinant and exists for singular transforms, too; negated for mirrored ones, so that
// normals stay outward.
struct Flattener::Placement {
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
  const bool skinned = !skin_.empty() && skin_[index](0, 4) > 0;
  const Placement own = skinned ? Placement(Matrix4d(skin_[index].leftCols<4>())) : place;
  const Vector3d x = own.linear * Vector3d(at.x, at.y, at.z) + own.offset;
  if (!x.allFinite()) return taken = kNotFinite;
  taken = static_cast<VertexId>(surface.vertices.size());
  surface.vertices.push_back(x);

  Vector3d n = Vector3d::Zero();
  if (mesh.mNormals != nullptr) {
    const aiVector3D& given = mesh.mNormals[index];
    n = (own.normals * Vector3d(given.x, given.y, given.z)).stableNormalized();
  }
  const bool good = n.allFinite() && std::abs(n.norm() - 1) < 1e-6;
  surface.normals.push_back(good ? Vector3f(n.cast<float>()) : Vector3f(0, 0, 1));
  has_normal_.push_back(good);

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
  constexpr std::uint64_t kMost = std::numeric_limits<VertexId>::max();
  if (vertices > kMost || triangles > kMost ||
      vertices * kVertexBytes + triangles * kTriangleBytes > bytes_)
    throw Refusal{"its scene shows so many copies of its meshes that they need more than " +
                  number_text(std::ceil(static_cast<double>(bytes_) / 1e6)) + " MB"};
  if (mesh.mNumAnimMeshes > 0) ++morphed_;
  taken_.assign(mesh.mNumVertices, kNotTaken);
  find_skin(mesh);
  const auto object = static_cast<std::uint32_t>(surface.objects.size() - 1);
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) {
      ++(face.mNumIndices < 2    ? left_out_.points
         : face.mNumIndices == 2 ? left_out_.lines
                                 : left_out_.polygons);
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
      ++left_out_.not_finite;
      continue;
    }
    const auto& skin = skin_.empty()
                           ? Eigen::Matrix<double, 4, 5>(Eigen::Matrix<double, 4, 5>::Zero())
                           : skin_[face.mIndices[0]];
    const bool mirrored =
        skin(0, 4) > 0 ? skin.topLeftCorner<3, 3>().determinant() < 0 : place.mirrored;
    if (mirrored) std::swap(triangle[1], triangle[2]);
    surface.triangles.push_back(triangle);
    surface.object_of.push_back(object);
    surface.material_of.push_back(material_of(mesh.mMaterialIndex));
  }
}

// Blends G_b B_b by the weights: G_b where the joint is, B_b its inverse bind matrix.
void Flattener::find_skin(const aiMesh& mesh) {
  skin_.clear();
  if (!mesh.HasBones()) return;
  skin_.assign(mesh.mNumVertices, Eigen::Matrix<double, 4, 5>::Zero());
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const Matrix4d* place = rig_->place_of(text_of(bone.mName));
    if (place == nullptr) continue;
    const Matrix4d placed = *place * matrix_of(bone.mOffsetMatrix);
    for (unsigned k = 0; k < bone.mNumWeights; ++k) {
      const aiVertexWeight& weight = bone.mWeights[k];
      if (weight.mVertexId >= mesh.mNumVertices || !(weight.mWeight > 0)) continue;
      skin_[weight.mVertexId].leftCols<4>() += weight.mWeight * placed;
      skin_[weight.mVertexId](0, 4) += weight.mWeight;
    }
  }
  for (auto& blended : skin_)
    if (blended(0, 4) > 0) blended.leftCols<4>() /= blended(0, 4);
}

// Walks without recursion: a file may nest its nodes as deep as it likes.
void Flattener::add_nodes(double file_scale) {
  struct Visit {
    const aiNode* node;
    Matrix4d parent;
  };
  Matrix4d root = Matrix4d::Identity();
  root.topLeftCorner<3, 3>() *= 1.0 / file_scale;
  rig_.emplace(scene_, root);
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
      if (mesh.HasBones()) rig_->add_skin(mesh, taken_);
      carriers_.resize(surface.vertices.size(), rig_->bone_of(node));
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

bool Flattener::take_rig(std::vector<std::string>& notes) {
  if (!rig_ || rig_->empty()) return false;
  carriers_.resize(surface.vertices.size(), kNoParent);
  surface.rig = rig_->finish(carriers_, notes);
  return surface.rig != nullptr;
}

void Flattener::fill_normals() {
  fill_missing_normals(surface, has_normal_);
}

void Flattener::note_what_was_left_out(std::vector<std::string>& notes) const {
  note_left_out(left_out_, notes);
  if (morphed_ > 0) notes.push_back("shapes that morph: taken in their rest shape");
}

}  // namespace tremolo
