#include "runtime/io/exchange/glb_writer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "runtime/io/exchange/creased_animation.h"
#include "runtime/io/exchange/glb_file.h"
#include "runtime/io/exchange/json_text.h"

namespace tremolo {
namespace {

// Lists of a .glb's top level about bodies; the entries are JSON.
struct GlbScene {
  std::vector<std::string> nodes, meshes, skins, samplers, channels;
  std::vector<std::size_t> below_root, beside_root;
  std::size_t times = 0;  // the accessor of the keys' times
  bool moves = false;     // there are at least two frames
};

// Poses of one node over time in glTF's form, x, y, z, w. The sign follows the previous frame,
// since viewers interpolate linearly between keys.
struct NodeKeys {
  std::vector<float> translations, rotations;
  bool translates = false, rotates = false;
};

NodeKeys node_keys(const AnimatedBody& body, std::size_t bone, std::size_t frames) {
  NodeKeys keys;
  Eigen::Vector4d last = poses_at(body, 0)[bone].rotation.coeffs();
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const Pose& pose = poses_at(body, frame)[bone];
    Eigen::Vector4d turn = pose.rotation.coeffs().normalized();
    if (turn.dot(last) < 0.0) turn = -turn;
    last = turn;
    for (const double x : pose.position) keys.translations.push_back(static_cast<float>(x));
    for (const double x : turn) keys.rotations.push_back(static_cast<float>(x));
  }
  const auto changes = [](const std::vector<float>& values, std::size_t width) {
    for (std::size_t i = width; i < values.size(); ++i)
      if (values[i] != values[i % width]) return true;
    return false;
  };
  keys.translates = changes(keys.translations, 3);
  keys.rotates = changes(keys.rotations, 4);
  return keys;
}

// between: glTF's word for values between two keys; empty: linear.
void add_channel(GlbScene& scene, std::size_t node, const char* what, std::size_t output,
                 const std::string& between = {}) {
  scene.channels.push_back("{\"sampler\":" + json_number(scene.samplers.size()) +
                           ",\"target\":{\"node\":" + json_number(node) + ",\"path\":\"" + what +
                           "\"}}");
  scene.samplers.push_back("{\"input\":" + json_number(scene.times) +
                           ",\"output\":" + json_number(output) +
                           (between.empty() ? "" : ",\"interpolation\":\"" + between + "\"") + "}");
}

// A body that is not there has the size zero.
void add_size_keys(GlbFile& file, GlbScene& scene, const AnimatedBody& body, std::size_t node) {
  if (body.shown.empty() || !scene.moves) return;
  std::vector<float> sizes;
  for (const std::uint8_t shown : body.shown) sizes.insert(sizes.end(), 3, shown != 0 ? 1.F : 0.F);
  add_channel(scene, node, "scale", file.add_floats(GlbPart::kMotion, 3, sizes), "STEP");
}

// Adds a node at the first pose, with the others as keys if they differ. members: further members.
std::size_t add_posed_node(GlbFile& file, GlbScene& scene, const AnimatedBody& body,
                           std::size_t bone, std::string members, std::size_t frames) {
  const NodeKeys keys = node_keys(body, bone, frames);
  const std::vector<float> place(keys.translations.begin(), keys.translations.begin() + 3);
  const std::vector<float> turn(keys.rotations.begin(), keys.rotations.begin() + 4);
  if (keys.translates || place != std::vector<float>{0, 0, 0})
    members += ",\"translation\":" + json_numbers(place);
  if (keys.rotates || turn != std::vector<float>{0, 0, 0, 1})
    members += ",\"rotation\":" + json_numbers(turn);
  scene.nodes.push_back("{" + members + "}");
  const std::size_t node = scene.nodes.size() - 1;
  if (keys.translates)
    add_channel(scene, node, "translation",
                file.add_floats(GlbPart::kMotion, 3, keys.translations));
  if (keys.rotates)
    add_channel(scene, node, "rotation", file.add_floats(GlbPart::kMotion, 4, keys.rotations));
  return node;
}

void add_weight_keys(GlbFile& file, GlbScene& scene, const Animation& animation, std::size_t body,
                     const GlbShape& shape, std::size_t node) {
  if (shape.targets.empty() || !scene.moves) return;
  std::vector<float> all;
  for (std::size_t frame = 0; frame < animation.frames(); ++frame) {
    const std::vector<float> weights = shape_weights(animation, body, frame, shape);
    all.insert(all.end(), weights.begin(), weights.end());
  }
  add_channel(scene, node, "weights", file.add_floats(GlbPart::kMotion, 1, all));
}

std::string name_of_bone(const AnimatedBody& body, std::size_t bone) {
  return bone < body.bone_names.size() ? body.bone_names[bone]
                                       : body.name + " bone " + std::to_string(bone);
}

void add_body(GlbFile& file, GlbScene& scene, const Animation& animation, std::size_t number,
              const GlbShape& shape, GlbReport& report) {
  const AnimatedBody& body = animation.bodies[number];
  std::vector<std::string> further;
  std::string members =
      "\"name\":" + json_string(body.name) + ",\"mesh\":" + json_number(scene.meshes.size());
  const bool on_bones = body.weights.cols() > 0;
  if (on_bones) {
    further = add_bone_weights(file, body.weights, report.bones_a_vertex);
    report.four_bones_error = std::max(report.four_bones_error, four_bones_error(animation, body));
  }
  const std::vector<float> first = shape_weights(animation, number, 0, shape);
  scene.meshes.push_back(mesh_text(body.name, shape, further, first));
  if (!on_bones) {
    const std::size_t node = add_posed_node(file, scene, body, 0, members, animation.frames());
    scene.below_root.push_back(node);
    add_size_keys(file, scene, body, node);
    return add_weight_keys(file, scene, animation, number, shape, node);
  }
  // A skinned mesh is placed by its joints; the transform of its own node is ignored.
  std::vector<std::size_t> joints;
  for (std::size_t b = 0; b < body.bones(); ++b)
    joints.push_back(add_posed_node(file, scene, body, b,
                                    "\"name\":" + json_string(name_of_bone(body, b)),
                                    animation.frames()));
  scene.below_root.insert(scene.below_root.end(), joints.begin(), joints.end());
  members += ",\"skin\":" + json_number(scene.skins.size());
  scene.skins.push_back("{\"name\":" + json_string(body.name + " skeleton") +
                        ",\"joints\":" + json_numbers(joints) + "}");
  scene.nodes.push_back("{" + members + "}");
  scene.beside_root.push_back(scene.nodes.size() - 1);
  add_weight_keys(file, scene, animation, number, shape, scene.nodes.size() - 1);
}

// Adds the root, which rotates z up to y up and has the bodies as children.
std::vector<std::size_t> add_root(GlbScene& scene, bool z_up) {
  std::vector<std::size_t> roots = scene.beside_root;
  if (scene.below_root.empty()) return roots;
  roots.insert(roots.begin(), scene.nodes.size());
  const double half = std::sqrt(0.5);
  std::string text = "{\"name\":\"tremolo\"";
  if (z_up) text += ",\"rotation\":" + json_numbers(std::vector<double>{-half, 0.0, 0.0, half});
  scene.nodes.push_back(text + ",\"children\":" + json_numbers(scene.below_root) + "}");
  return roots;
}

// Before any of the large arrays is made.
Status check_sizes(const std::string& path, const Animation& animation, const GlbOptions& options) {
  double bytes = 0.0;
  for (std::size_t k = 0; k < animation.shapes.size(); ++k) {
    const AnimatedShape& shape = animation.shapes[k];
    const std::size_t targets = target_ranges(animation, k, options.plain).targets.size();
    const std::size_t further = options.normals && targets > 0 ? options.normal_targets : 0;
    if (targets <= kMostGlbTargets && targets + further > kMostGlbTargets)
      return content_error(path + ": '" + shape.name + "' has " + std::to_string(targets) +
                           " morph targets, and programs hold at most " +
                           std::to_string(kMostGlbTargets) + ": expected at most " +
                           std::to_string(kMostGlbTargets - targets) + " of normals, found " +
                           std::to_string(further));
    if (targets > kMostGlbTargets)
      return content_error(
          path + ": '" + shape.name + "' moves in " + std::to_string(targets) +
          " coordinates, each of which would be a morph target, and programs hold at most " +
          std::to_string(kMostGlbTargets) +
          " of them: keep the first ones only, or write a point cache, which has no such limit");
    bytes += (options.normals ? 24.0 : 12.0) * static_cast<double>(shape.surface.vertices.size()) *
             static_cast<double>(targets + 1);
    bytes += 12.0 * static_cast<double>(shape.surface.vertices.size() * further);
  }
  if (bytes > 4e9)
    return content_error(path + ": it would have " + std::to_string(bytes / 1e9) +
                         " GB, and a .glb file at most 4: keep fewer coordinates");
  return Success{};
}

Status check_textures(const Animation& animation, const GlbOptions& options) {
  for (const GlbTexture& texture : options.textures) {
    bool fits = false;
    std::string names;
    for (const AnimatedShape& shape : animation.shapes)
      for (const std::string& name : shape.surface.materials) {
        const bool named = texture.material.empty() || name == texture.material;
        fits = fits || (named && !shape.surface.uvs.empty());
        if (!shape.surface.uvs.empty()) names += (names.empty() ? "'" : ", '") + name + "'";
      }
    if (!fits)
      return usage_error(
          texture.path + ": there is no " +
          (texture.material.empty() ? "surface" : "material '" + texture.material + "'") +
          " with texture coordinates that it could lie on" +
          (names.empty() ? "" : "; those that have some are " + names));
  }
  return Success{};
}

Status check_times(const std::vector<float>& times) {
  for (std::size_t i = 1; i < times.size(); ++i)
    if (times[i] <= times[i - 1])
      return content_error("frames at t = " + std::to_string(times[i]) +
                           " s lie closer than the floats of a .glb can tell apart");
  return Success{};
}

std::vector<std::string> top_level(const Animation& animation, const GlbScene& scene,
                                   const std::vector<std::size_t>& roots, const GlbLists& lists) {
  std::vector<std::string> members = {
      "\"asset\":{\"version\":\"2.0\",\"generator\":\"Tremolo " TREMOLO_VERSION
      "\",\"extras\":{\"first_frame_s\":" +
          json_number(animation.times[0]) + "}}",
      "\"scene\":0",
      "\"scenes\":[{\"nodes\":" + json_numbers(roots) + "}]",
      "\"nodes\":" + json_list(scene.nodes),
      "\"meshes\":" + json_list(scene.meshes),
      "\"materials\":" + json_list(lists.materials)};
  if (!lists.textures.empty()) {
    members.push_back("\"textures\":" + json_list(lists.textures));
    members.emplace_back("\"samplers\":[{\"magFilter\":9729,\"minFilter\":9987}]");
  }
  if (!scene.skins.empty()) members.push_back("\"skins\":" + json_list(scene.skins));
  if (!scene.channels.empty())
    members.push_back(
        "\"animations\":[{\"name\":\"motion\",\"channels\":" + json_list(scene.channels) +
        ",\"samplers\":" + json_list(scene.samplers) + "}]");
  return members;
}

}  // namespace

Result<GlbReport> write_glb(const std::string& path, const Animation& given,
                            const GlbOptions& options) {
  if (Status s = check_animation(given); !s) return s.error();
  // Without normals programs draw every edge sharp.
  const std::optional<Animation> creased =
      options.normals ? split_creases(given) : std::optional<Animation>();
  const Animation& animation = creased ? *creased : given;
  for (const AnimatedBody& body : animation.bodies) {
    if (body.weights.cols() > 0)
      if (Status s = check_all_shown(path, body); !s) return s.error();
    if (!body.displacements.empty())
      return usage_error(path + ": body '" + body.name +
                         "' has no modes, by which .glb moves vertices; .usda moves each");
  }
  if (Status s = check_textures(animation, options); !s) return s.error();
  if (Status s = check_sizes(path, animation, options); !s) return s.error();
  GlbFile file;
  GlbLists lists;
  GlbReport report;
  GlbScene scene;
  if (Status s = add_textures(file, options, lists); !s) return s.error();
  std::vector<float> times;
  for (const double t : animation.times)
    times.push_back(static_cast<float>(t - animation.times[0]));
  if (Status s = check_times(times); !s) return s.error();
  scene.moves = times.size() > 1;
  if (scene.moves) scene.times = file.add_floats(GlbPart::kMotion, 1, times, true);
  std::vector<GlbShape> shapes;
  for (std::size_t k = 0; k < animation.shapes.size(); ++k)
    shapes.push_back(add_shape(file, animation, k, options, lists, report));
  for (std::size_t b = 0; b < animation.bodies.size(); ++b)
    add_body(file, scene, animation, b, shapes[animation.bodies[b].shape], report);
  const std::vector<std::size_t> roots = add_root(scene, options.z_up);
  if (Status s = file.write(path, top_level(animation, scene, roots, lists), report.bytes); !s)
    return s.error();
  return report;
}

}  // namespace tremolo
