#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/io/exchange/glb_file.h"
#include "runtime/io/exchange/json_text.h"

namespace tremolo {
namespace {

constexpr double kBodyColour[3] = {0.8, 0.8, 0.8};  // linear, the default
constexpr double kSceneryColour[3] = {0.25, 0.27, 0.3};

std::string member(const std::string& name, std::size_t value) {
  return json_string(name) + ":" + json_number(value);
}

// Members in braces.
std::string object(const std::vector<std::string>& members) {
  std::string text = json_list(members);
  text.front() = '{';
  text.back() = '}';
  return text;
}

// Converts an sRGB byte to linear light (IEC 61966-2-1).
double light(std::uint8_t byte) {
  const double v = byte / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

std::size_t add_colours(GlbFile& file, const std::vector<Colour>& colours) {
  std::vector<std::uint16_t> values;
  const auto sixteen_bits = [](double share) {
    return static_cast<std::uint16_t>(std::lround(65535.0 * share));
  };
  for (const Colour& colour : colours) {
    // Unpainted parts have the colour of a surface without colours.
    for (std::size_t k = 0; k < 3; ++k)
      values.push_back(sixteen_bits(colour[3] == 0 ? kBodyColour[k] : light(colour[k])));
    values.push_back(sixteen_bits(1.0));
  }
  return file.add(GlbPart::kColours, {GlbComponent::kShort, 4, true, false}, values.data(),
                  2 * values.size(), colours.size());
}

// glTF's v runs downwards in the image.
std::size_t add_uvs(GlbFile& file, const std::vector<Eigen::Vector2f>& uvs) {
  std::vector<float> values;
  for (const Eigen::Vector2f& uv : uvs) {
    values.push_back(uv[0]);
    values.push_back(1.0f - uv[1]);
  }
  return file.add_floats(GlbPart::kUvs, 2, values);
}

// In two bytes where the numbers allow it: the largest one is glTF's mark for a new strip.
std::size_t add_indices(GlbFile& file, const std::vector<VertexId>& corners, std::size_t vertices) {
  if (vertices < 65536) {
    const std::vector<std::uint16_t> small(corners.begin(), corners.end());
    if (vertices < 65535)
      return file.add(GlbPart::kIndices, {GlbComponent::kShort, 1, false, false}, small.data(),
                      2 * small.size(), small.size());
  }
  return file.add(GlbPart::kIndices, {GlbComponent::kInt, 1, false, false}, corners.data(),
                  sizeof(VertexId) * corners.size(), corners.size());
}

// The texture of a material, which is the last that names it or all.
const std::size_t* texture_of(const GlbOptions& options, const std::string& material,
                              const GlbLists& lists) {
  const std::size_t* found = nullptr;
  for (std::size_t k = 0; k < options.textures.size(); ++k)
    if (const std::string& name = options.textures[k].material; name.empty() || name == material)
      found = &lists.images[k];
  return found;
}

std::string material_text(const AnimatedShape& shape, const std::string& name, bool scenery,
                          const std::size_t* texture) {
  const bool own_colour = texture != nullptr || !shape.surface.colours.empty();
  std::string text = "{\"name\":" + json_string(name) + ",\"pbrMetallicRoughness\":{";
  if (texture != nullptr)
    text += "\"baseColorTexture\":{\"index\":" + json_number(*texture) + "},";
  else if (!own_colour) {
    const auto& colour = scenery ? kSceneryColour : kBodyColour;
    text += "\"baseColorFactor\":" +
            json_numbers(std::array<double, 4>{colour[0], colour[1], colour[2], 1.0}) + ",";
  }
  return text + "\"metallicFactor\":0,\"roughnessFactor\":0.6},\"doubleSided\":true}";
}

// The triangles of each material.
void add_primitives(GlbFile& file, const AnimatedShape& shape, const GlbOptions& options,
                    bool scenery, GlbLists& lists, GlbShape& out) {
  const RenderSurface& surface = shape.surface;
  std::vector<std::vector<VertexId>> corners(surface.materials.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const VertexId corner : surface.triangles[t])
      corners[surface.material_of[t]].push_back(corner);
  for (std::size_t m = 0; m < corners.size(); ++m) {
    if (corners[m].empty()) continue;
    const std::size_t* texture = texture_of(options, surface.materials[m], lists);
    // A texture without a material name applies to all surfaces with texture coordinates.
    if (texture != nullptr && surface.uvs.empty()) texture = nullptr;
    out.primitives.push_back(
        {add_indices(file, corners[m], surface.vertices.size()), lists.materials.size()});
    lists.materials.push_back(material_text(shape, surface.materials[m], scenery, texture));
  }
}

void add_targets(GlbFile& file, const MorphTargets& morphs, GlbShape& out) {
  const std::size_t rows = morphs.positions.rows();
  for (Eigen::Index k = 0; k < morphs.positions.cols(); ++k) {
    const std::span<const float> places(morphs.positions.col(k).data(), rows);
    std::vector<std::string> members = {
        member("POSITION", file.add_floats(GlbPart::kVectors, 3, places, true))};
    if (morphs.normals.cols() > 0) {
      const std::span<const float> normals(morphs.normals.col(k).data(), rows);
      members.push_back(member("NORMAL", file.add_floats(GlbPart::kVectors, 3, normals)));
    }
    if (k == 0)
      out.attributes = members;
    else
      out.targets.push_back(object(members));
  }
  // Programs read POSITION of all targets or of none.
  const Eigen::Index first = morphs.positions.cols();
  if (morphs.normals.cols() <= first) return;
  const std::size_t still = file.add_zeros(3, rows / 3);
  for (Eigen::Index k = first; k < morphs.normals.cols(); ++k) {
    const std::span<const float> normals(morphs.normals.col(k).data(), rows);
    out.targets.push_back(
        object({member("POSITION", still),
                member("NORMAL", file.add_floats(GlbPart::kVectors, 3, normals))}));
  }
}

// "image/png" or "image/jpeg" by the file's first bytes; empty: neither.
std::string image_type(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return "image/png";
  return bytes.starts_with("\xff\xd8\xff") ? "image/jpeg" : "";
}

}  // namespace

Status add_textures(GlbFile& file, const GlbOptions& options, GlbLists& lists) {
  for (const GlbTexture& texture : options.textures) {
    Result<std::string> bytes = read_whole_file(texture.path);
    if (!bytes) return bytes.error();
    const std::string type = image_type(*bytes);
    if (type.empty())
      return content_error(texture.path + ": a texture is a .png or a .jpg file, and this is none");
    const std::string name = std::filesystem::path(texture.path).stem().string();
    const std::size_t image = file.add_image(name, type, std::move(*bytes));
    lists.images.push_back(lists.textures.size());
    lists.textures.push_back("{\"sampler\":0,\"source\":" + json_number(image) + "}");
  }
  return Success{};
}

GlbShape add_shape(GlbFile& file, const Animation& animation, std::size_t shape,
                   const GlbOptions& options, GlbLists& lists, GlbReport& report) {
  const AnimatedShape& known = animation.shapes[shape];
  GlbShape out;
  out.ranges = target_ranges(animation, shape, options.plain);
  MorphTargets morphs = morph_targets(known, out.ranges, options.normals);
  out.bent =
      add_bent_normals(animation, shape, out.ranges, options.plain, options.normal_targets, morphs);
  add_targets(file, morphs, out);
  if (!known.surface.uvs.empty())
    out.attributes.push_back(member("TEXCOORD_0", add_uvs(file, known.surface.uvs)));
  if (!known.surface.colours.empty())
    out.attributes.push_back(member("COLOR_0", add_colours(file, known.surface.colours)));
  const bool scenery =
      std::all_of(animation.bodies.begin(), animation.bodies.end(),
                  [&](const AnimatedBody& body) { return body.shape != shape || body.collider; });
  add_primitives(file, known, options, scenery, lists, out);
  report.vertices += known.surface.vertices.size();
  report.targets = std::max(report.targets, out.ranges.targets.size());
  report.normal_targets = std::max(report.normal_targets, out.bent.targets);
  report.dropped += static_cast<std::size_t>(known.modes.cols()) - out.ranges.targets.size();
  const MorphError error = morph_error(animation, shape, out.ranges, morphs, out.bent.weights);
  report.position_error = std::max(report.position_error, error.position);
  report.normal_mean = std::max(report.normal_mean, error.normal_mean);
  report.normal_max = std::max(report.normal_max, error.normal_max);
  return out;
}

std::vector<float> shape_weights(const Animation& animation, std::size_t body, std::size_t frame,
                                 const GlbShape& shape) {
  std::vector<float> weights =
      target_weights(coordinates_at(animation, animation.bodies[body], frame), shape.ranges);
  const Eigen::MatrixXf& further = shape.bent.weights[body];
  for (Eigen::Index k = 0; k < further.rows(); ++k)
    weights.push_back(further(k, static_cast<Eigen::Index>(frame)));
  return weights;
}

double four_bones_error(const Animation& animation, const AnimatedBody& body) {
  constexpr Eigen::Index kRead = 4;
  constexpr std::size_t kFrames = 64;
  if (body.weights.cols() <= kRead) return 0.0;
  AnimatedBody read = body;
  for (Eigen::Index v = 0; v < read.weights.rows(); ++v) {
    auto row = read.weights.row(v);
    Eigen::VectorXd sorted = row.transpose();
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    for (double& share : row)
      if (share < sorted[kRead - 1]) share = 0.0;
    row /= row.sum();
  }
  const std::size_t looks = std::min(kFrames, animation.frames());
  const AnimatedShape& shape = animation.shape_of(body);
  std::vector<double> all(3 * shape.surface.vertices.size()), four(all.size());
  double worst = 0.0;
  for (std::size_t k = 0; k < looks; ++k) {
    const std::size_t frame = looks < 2 ? 0 : k * (animation.frames() - 1) / (looks - 1);
    world_positions(animation, body, frame, all);
    world_positions(animation, read, frame, four);
    const Eigen::Index count = all.size() / 3;
    const Eigen::Map<const Eigen::Matrix3Xd> a(all.data(), 3, count), b(four.data(), 3, count);
    worst = std::max(worst, (a - b).colwise().norm().maxCoeff());
  }
  const double size = largest_extent(shape);
  return size > 0.0 ? worst / size : 0.0;
}

std::vector<std::string> add_bone_weights(GlbFile& file, const BoneWeights& weights,
                                          std::size_t& most) {
  constexpr std::size_t kSet = 4;
  const std::size_t vertices = weights.rows();
  std::vector<std::vector<Eigen::Index>> bones(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    const auto row = weights.row(v);
    for (Eigen::Index b = 0; b < row.size(); ++b)
      if (row[b] > 0.0) bones[v].push_back(b);
    // Viewers that read four shall have the heaviest.
    std::stable_sort(bones[v].begin(), bones[v].end(),
                     [&row](Eigen::Index a, Eigen::Index b) { return row[a] > row[b]; });
    most = std::max(most, bones[v].size());
  }
  std::vector<std::string> members;
  for (std::size_t first = 0; first < most; first += kSet) {
    std::vector<std::uint16_t> joints(kSet * vertices, 0);
    std::vector<float> shares(kSet * vertices, 0.0f);
    for (std::size_t v = 0; v < vertices; ++v)
      for (std::size_t k = first; k < std::min(first + kSet, bones[v].size()); ++k) {
        joints[kSet * v + k - first] = static_cast<std::uint16_t>(bones[v][k]);
        shares[kSet * v + k - first] =
            static_cast<float>(weights(static_cast<Eigen::Index>(v), bones[v][k]));
      }
    const std::string set = std::to_string(first / kSet);
    members.push_back(
        member("JOINTS_" + set, file.add(GlbPart::kJoints, {GlbComponent::kShort, 4, false, false},
                                         joints.data(), 2 * joints.size(), vertices)));
    members.push_back(member("WEIGHTS_" + set, file.add_floats(GlbPart::kWeights, 4, shares)));
  }
  return members;
}

std::string mesh_text(const std::string& name, const GlbShape& shape,
                      const std::vector<std::string>& further, const std::vector<float>& weights) {
  std::vector<std::string> attributes = shape.attributes;
  attributes.insert(attributes.end(), further.begin(), further.end());
  std::vector<std::string> primitives;
  for (const GlbShape::Primitive& part : shape.primitives) {
    std::string text = "{\"attributes\":" + object(attributes) +
                       ",\"indices\":" + json_number(part.indices) +
                       ",\"material\":" + json_number(part.material);
    if (!shape.targets.empty()) text += ",\"targets\":" + json_list(shape.targets);
    primitives.push_back(text + "}");
  }
  std::string text = "{\"name\":" + json_string(name) + ",\"primitives\":" + json_list(primitives);
  if (!shape.targets.empty()) {
    std::vector<std::string> names;
    for (const TargetRange& range : shape.ranges.targets)
      names.push_back("\"q" + json_number(range.coordinate) + "\"");
    for (std::size_t k = 0; k < shape.bent.targets; ++k)
      names.push_back("\"normal" + json_number(k) + "\"");
    text += ",\"weights\":" + json_numbers(weights) +
            ",\"extras\":{\"targetNames\":" + json_list(names) + "}";
  }
  return text + "}";
}

}  // namespace tremolo
