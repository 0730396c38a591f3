#include "runtime/io/scenes/scene_reader.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/file/input_file.h"
#include "runtime/integrator.h"
#include "runtime/io/scenes/copies.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/io/scenes/part_readers.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/io/scenes/toml_keys.h"
#include "runtime/split.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr const char* kBodies = "bodies";
constexpr const char* kCloths = "cloths";
// Keys of the scene that bodies of kind "cloth" have; parse_mixed() reads them.
constexpr const char* kClothSurroundings[] = {"wind", "gust", "gust-hz", "cloths-pass"};

// Reads a number, or rows [t, value], each for the time from t on.
void read_course(TomlKeys& keys, const char* key, double& value, std::vector<ValueFrom>& course) {
  const toml::node* node = keys.find(key);
  const toml::array* rows = node == nullptr ? nullptr : node->as_array();
  if (rows == nullptr) return keys.read(key, value);
  for (const toml::node& row : *rows)
    if (const auto numbers = numbers_of(row); numbers && numbers->size() == 2)
      course.push_back({(*numbers)[0], (*numbers)[1]});
  if (rows->empty() || course.size() != rows->size())
    keys.fail(key, std::string("'") + key + "' must be a number or a list of [t, value]");
}

template <class Names>
std::string list_of(const Names& names) {
  std::string list;
  for (const std::string_view name : names) list += (list.empty() ? "" : ", ") + std::string(name);
  return list;
}

void read_method(TomlKeys& keys, SceneBody& body) {
  IntegratorOptions& options = body.options;
  keys.read("integrator", body.integrator);
  const auto names = integrator_names();
  if (std::find(names.begin(), names.end(), body.integrator) == names.end())
    keys.fail("integrator",
              "unknown integrator '" + body.integrator + "'; there are " + list_of(names));
  read_course(keys, "alpha", options.alpha, body.alphas);
  read_course(keys, "beta", options.beta, body.betas);
  if (const auto damping = read_damping_ratio(keys)) put_damping(*damping, options);
  keys.read("newmark-beta", options.newmark_beta);
  keys.read("newmark-gamma", options.newmark_gamma);
  keys.read("tolerance", options.tolerance);
  keys.read("max-iterations", options.max_iterations);
  std::string split = "default";
  keys.read_text_or_number("split", split);
  const Result<SplitOptions> parsed = parse_split(split);
  if (parsed)
    options.split = *parsed;
  else
    keys.fail("split", parsed.error().message);
  keys.read("safety", options.split.safety);
}

// The model of a body that deforms.
void read_model(TomlKeys& keys, SceneBody& body) {
  keys.read_path("model", body.model);
  if (!keys.has("model")) keys.fail("model", "it has no key `model`");
  keys.read("made-by", body.made_by);
  keys.read("modes", body.model_options.modes);
  keys.read("linear", body.model_options.linear);
  keys.read("hull", body.model_options.hull);
}

// The matter of a rigid body. Its shape is read with its contact.
void read_rigid(TomlKeys& keys, RigidSolid& solid) {
  keys.read_path("mesh", solid.mesh);
  if (keys.has("mass")) keys.read("mass", solid.mass.emplace());
  if (keys.has("density")) keys.read("density", solid.density.emplace());
  if (keys.has("inertia")) keys.read("inertia", solid.inertia.emplace());
  if (!keys.has("mesh") && !keys.has("shape"))
    keys.fail("kind", "a rigid body needs a `shape` or a `mesh`");
}

void read_what(TomlKeys& keys, SceneBody& body) {
  constexpr FrameKind kKinds[] = {FrameKind::kFixed, FrameKind::kDriven, FrameKind::kFree,
                                  FrameKind::kFree,  FrameKind::kFree,   FrameKind::kFree};
  // Tables of the last two kinds are read elsewhere.
  const std::size_t kind =
      keys.read_word("kind", {"fixed", "driven", "free", "rigid", "tets", "cloth"}, 0);
  body.kind = kKinds[kind];
  if (kind == 3)
    read_rigid(keys, body.rigid.emplace());
  else
    read_model(keys, body);
  body.pose = read_pose(keys);
  keys.read("velocity", body.velocity);
  keys.read("spin", body.spin);
  keys.read("acceleration-limit", body.acceleration_limit);
  read_body_contact(keys, body);
  if (body.rigid && body.rigid->mesh.empty()) body.rigid->shape.swap(body.contact.shape);
  body.settled = keys.read_word("start", {"rest", "static"}, 0) == 1;
  keys.read("probe", body.columns.probes);
  keys.read("coordinate", body.columns.coordinates);
  keys.read("velocities", body.columns.velocities);
}

Result<SceneBody> read_body(const toml::table& table, std::size_t number, SceneFile& file,
                            Copies& copies) {
  SceneBody body;
  const std::string what = told_name(table, "body", number);
  TomlKeys keys(table, file.path, what);
  if (!keys.has("name")) keys.fail("name", "it has no `name`");
  read_folder_name(keys, body.name);
  read_what(keys, body);
  copies = read_copies(keys);
  read_method(keys, body);
  if (Status s = take(body.loads, read_loads(keys, file.path, what, file.files)); !s)
    return s.error();
  if (Status s = read_bones(keys, file.path, what, file.files, body); !s) return s.error();
  if (Status s = take(body.motion, read_motion(keys, file.path, what, file.files, true)); !s)
    return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return body;
}

Status refuse_cloths(const toml::table& table, const std::string& path) {
  if (!table.contains(kCloths)) return Success{};
  const toml::source_region where = table.find(kCloths)->second.source();
  if (table.contains(kBodies))
    return error_at(
        path, where,
        "[[bodies]] and [[cloths]] do not go together: next to other bodies a cloth is one of "
        "[[bodies]] with kind = \"cloth\"");
  return error_at(path, where, std::string("a scene with [[cloths]]: ") + kClothCommands);
}

// The names of a body of another kind and of its copies. Its own reader reports its errors.
void add_guest_names(const toml::table& table, const std::string& path,
                     std::set<std::string>& names) {
  struct Named {
    std::string name;
    Pose pose;
  };
  TomlKeys keys(table, path, "");
  std::vector<Named> bodies;
  add_copies(Named{table["name"].value_or(std::string()), {}}, read_copies(keys), bodies);
  for (const Named& body : bodies) names.insert(body.name);
}

// The bodies that a hand or a joint names by these keys must exist.
Status check_held(const toml::table& table, const std::string& path, const std::string& what,
                  std::initializer_list<const char*> keys, const Scene& scene) {
  for (const char* key : keys) {
    const std::string name = table[key].value_or(std::string());
    const auto named = [&name](const SceneBody& body) { return body.name == name; };
    if (scene.guests.contains(name) || std::any_of(scene.bodies.begin(), scene.bodies.end(), named))
      continue;
    return error_at(path, table[key].node()->source(),
                    what + ": " + key + ": there is no body '" + name + "'");
  }
  return Success{};
}

}  // namespace

Result<bool> is_world(std::string_view text, const std::string& path) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  if (Status s = refuse_cloths(*table, path); !s) return s.error();
  return (*table)[kBodies].is_array();
}

Result<SceneFile> read_world(const std::string& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return parse_world(*text, path);
}

Result<SceneFile> parse_world(std::string_view text, const std::string& path, OtherKinds others) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  return read_scene(*table, path, others);
}

Result<SceneFile> read_scene(const toml::table& table, const std::string& path, OtherKinds others) {
  if (Status s = refuse_cloths(table, path); !s) return s.error();
  SceneFile file;
  file.path = path;
  TomlKeys keys(table, path, "");
  keys.read("step", file.scene.step);
  keys.read("duration", file.scene.duration);
  keys.read("sleep", file.scene.sleep);
  read_outputs(keys, file.outputs);
  if (Status s = read_gravity(keys, path, file.scene.gravity, file.files); !s) return s.error();
  std::size_t number = 0;
  for (const toml::table* entry : keys.read_tables(kBodies)) {
    ++number;
    if (const bool cloth = is_of_cloth(*entry); cloth || is_of_tets(*entry)) {
      if (others == OtherKinds::kRefused)
        return error_at(path, entry->source(),
                        std::string("a body of kind \"") + (cloth ? "cloth" : "tets") +
                            "\" next to others: " + kMixedCommands);
      add_guest_names(*entry, path, file.scene.guests);
      if (cloth)
        for (const char* key : kClothSurroundings) keys.find(key);
      continue;
    }
    Copies copies;
    Result<SceneBody> body = read_body(*entry, number, file, copies);
    if (!body) return body.error();
    add_copies(*body, copies, file.scene.bodies);
  }
  number = 0;
  for (const toml::table* entry : keys.read_tables("colliders")) {
    Result<SceneCollider> collider = read_collider(*entry, ++number, path, file.files);
    if (!collider) return collider.error();
    file.scene.colliders.push_back(std::move(*collider));
  }
  number = 0;
  for (const toml::table* entry : keys.read_tables("hands")) {
    Result<SceneHand> hand = read_hand(*entry, ++number, path, file.files);
    if (!hand) return hand.error();
    if (Status s = check_held(*entry, path, "hand " + std::to_string(number), {"body"}, file.scene);
        !s)
      return s.error();
    file.scene.hands.push_back(std::move(*hand));
  }
  number = 0;
  for (const toml::table* entry : keys.read_tables("joints")) {
    Result<SceneJoint> joint = read_joint(*entry, ++number, path);
    if (!joint) return joint.error();
    const std::string what = "joint " + std::to_string(number);
    if (Status s = check_held(*entry, path, what, {"body"}, file.scene); !s) return s.error();
    // A body may have the world's name.
    const Status other = check_held(*entry, path, what, {"to"}, file.scene);
    if (!other && joint->to != kWorldName) return other.error();
    if (!other) joint->to.clear();
    file.scene.joints.push_back(std::move(*joint));
  }
  if (Status s = keys.finish(); !s) return s.error();
  if (Status s = check_scene(file.scene); !s) return error_of_file(path, s.error());
  return file;
}

}  // namespace tremolo
