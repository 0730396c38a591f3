#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "runtime/io/scenes/copies.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/io/scenes/part_readers.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {
namespace {

constexpr std::string_view kTets = "tets";

void read_tets_method(TomlKeys& keys, TetBodyOptions& options) {
  constexpr DegreeKind kKinds[] = {DegreeKind::kLinear, DegreeKind::kQuadratic,
                                   DegreeKind::kAdaptive};
  options.degree.kind = kKinds[keys.read_word("degree", {"linear", "quadratic", "adaptive"}, 2)];
  keys.read("error", options.degree.error);
  keys.read("upper", options.degree.upper);
  keys.read("lower", options.degree.lower);
  keys.read("least-steps", options.degree.least_steps);
  keys.read("look-every", options.degree.every);
  constexpr RotationLaw kLaws[] = {RotationLaw::kLeastEnergy, RotationLaw::kCorners};
  options.law = kLaws[keys.read_word("rotation-law", {"least-energy", "corners"}, 0)];
  std::string method = tet_method_name(options.method);
  keys.read("integrator", method);
  if (const Result<TetMethod> parsed = parse_tet_method(method))
    options.method = *parsed;
  else
    keys.fail("integrator", parsed.error().message);
  for (const char* key : {"alpha", "beta"})
    if (const toml::node* node = keys.find(key); node != nullptr && node->is_array())
      keys.fail(key,
                "damping that changes in time is for reduced bodies: a body of tetrahedra has "
                "one value");
  keys.read("alpha", options.alpha);
  keys.read("beta", options.beta);
  if (const auto damping = read_damping_ratio(keys)) {
    options.alpha = damping->rayleigh.alpha;
    options.beta = damping->rayleigh.beta;
    if (damping->of_each_mode())
      keys.fail("damping-ratio",
                "the whole mesh has no modes: give alpha and beta, or F1:Z1,F2:Z2, the fractions "
                "of critical damping at two frequencies");
  }
  keys.read("drag", options.drag);
  keys.read("tolerance", options.tolerance);
  keys.read("linear-tolerance", options.linear_tolerance);
  keys.read("max-iterations", options.max_iterations);
  constexpr UnsolvedStep kUnsolved[] = {UnsolvedStep::kCut, UnsolvedStep::kTake,
                                        UnsolvedStep::kTakeContact};
  options.unsolved = kUnsolved[keys.read_word("unsolved", {"cut", "take", "take-contact"}, 2)];
  options.tangent = keys.read_word("tangent", {"exact", "frozen"}, 0) == 1 ? TangentKind::kFrozen
                                                                           : TangentKind::kExact;
}

// The scene of a body. copies: null: there are none; otherwise the body is next to bodies of other
// kinds, under their law of contact.
struct TetsPlace {
  const std::string& path;
  double step;
  Eigen::Vector3d gravity;
  Copies* copies;
  std::vector<std::string>* files = nullptr;  // CSV files that were read; only with copies
};

void read_tets_contact(TomlKeys& keys, const TetsPlace& scene, TetSceneBody& body) {
  if (scene.copies != nullptr) {
    *scene.copies = read_copies(keys);
    read_contact_law(keys, body.contact);
    body.friction = body.contact.friction;
    keys.read("probe", body.probes);
    if (keys.has("creep"))
      keys.fail("creep",
                "next to bodies of other kinds friction holds without creep: leave `creep` out");
    return;
  }
  keys.read("friction", body.friction);
  if (!(body.friction >= 0.0 && std::isfinite(body.friction)))
    keys.fail("friction", "friction must be at least 0");
  double creep = 1.0;  // of scenes written for a law whose friction crept; without effect
  keys.read("creep", creep);
  if (!(creep > 0.0 && std::isfinite(creep))) keys.fail("creep", "creep must be above 0 m/s");
}

Result<TetSceneBody> read_tets_body(const toml::table& table, std::size_t number,
                                    const TetsPlace& scene) {
  TetSceneBody body;
  const std::string what = told_name(table, "body", number);
  TomlKeys keys(table, scene.path, what);
  keys.read_word("kind", {kTets}, 0);
  if (!keys.has("name")) keys.fail("name", "it has no `name`");
  read_folder_name(keys, body.name);
  keys.read_path("model", body.model);
  if (!keys.has("model")) keys.fail("model", "it has no key `model`");
  keys.read("made-by", body.made_by);
  body.pose = read_pose(keys);
  keys.read("velocity", body.velocity);
  keys.read("spin", body.spin);
  body.settled = keys.read_word("start", {"rest", "static"}, 0) == 1;
  read_tets_contact(keys, scene, body);
  read_tets_method(keys, body.options);
  if (scene.copies != nullptr)
    if (Status s = take(body.loads, read_loads(keys, scene.path, what, *scene.files)); !s)
      return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  body.options.step = scene.step;
  body.options.gravity = scene.gravity;
  // The step is the scene's.
  if (!(scene.step > 0.0 && std::isfinite(scene.step)))
    return content_error(scene.path + ": step must be positive and finite (s)");
  if (Status s = check(body.options); !s)
    return content_error(scene.path + ": " + what + ": " + s.error().message);
  return body;
}

Status read_tets_colliders(TomlKeys& keys, TetScene& scene) {
  std::size_t number = 0;
  for (const toml::table* entry : keys.read_tables("colliders")) {
    Result<SceneCollider> collider = read_collider(*entry, ++number, scene.path, scene.files);
    if (!collider) return collider.error();
    if (!collider->motion.parts.empty() || !collider->file.empty())
      return content_error(scene.path + ": collider '" + collider->name +
                           "': bodies of tetrahedra touch shapes that stand still and have no "
                           "file: plane, sphere, capsule, box, cylinder");
    scene.colliders.push_back(std::move(*collider));
  }
  return Success{};
}

Status check_tets_scene(const TetScene& scene) {
  const auto problem = [&scene](const std::string& what) {
    return content_error(scene.path + ": " + what);
  };
  for (const auto& [name, value] : {std::pair{"step", scene.step}, {"duration", scene.duration}})
    if (!(value > 0.0 && std::isfinite(value)))
      return problem(std::string(name) + " must be positive and finite (s)");
  if (Status s = check(scene.group); !s) return problem(s.error().message);
  std::set<std::string> names;
  for (const TetSceneBody& body : scene.bodies)
    if (!names.insert(body.name).second)
      return problem("two bodies are called '" + body.name + "'");
  return Success{};
}

void read_tets_outputs(TomlKeys& keys, SceneOutputs& outputs) {
  read_surface_outputs(keys, outputs);
  if (outputs.every < 1) keys.fail("every", "'every' must be at least 1");
  if (outputs.surfaces < 0) keys.fail("surfaces", "'surfaces' must not be negative");
}

void read_tets_group(TomlKeys& keys, TetGroupOptions& options) {
  keys.read("sleep-speed", options.sleep_speed);
  keys.read("sleep-time", options.sleep_time);
  int threads = 1;
  keys.read("threads", threads);
  if (threads < 1 || threads > 256) keys.fail("threads", "'threads' must be 1 to 256");
  options.threads = static_cast<unsigned>(std::clamp(threads, 1, 256));
}

}  // namespace

Result<TetScene> parse_tets_scene(std::string_view text, const std::string& path) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  TetScene scene;
  scene.path = path;
  TomlKeys keys(*table, path, "");
  keys.read("step", scene.step);
  keys.read("duration", scene.duration);
  keys.read("gravity", scene.gravity);
  read_tets_group(keys, scene.group);
  read_tets_outputs(keys, scene.outputs);
  std::size_t number = 0;
  for (const toml::table* entry : keys.read_tables("bodies")) {
    Result<TetSceneBody> body =
        read_tets_body(*entry, ++number, {path, scene.step, scene.gravity, nullptr});
    if (!body) return body.error();
    scene.bodies.push_back(std::move(*body));
  }
  if (Status s = read_tets_colliders(keys, scene); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  if (Status s = check_tets_scene(scene); !s) return s.error();
  return scene;
}

Result<MixedFile> parse_mixed(std::string_view text, const std::string& path) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  return read_mixed(*table, path);
}

Result<MixedFile> read_mixed(const toml::table& table, const std::string& path) {
  Result<SceneFile> read = read_scene(table, path, OtherKinds::kSkipped);
  if (!read) return read.error();
  MixedFile mixed{std::move(*read), {}, {}};
  const SceneGravity& gravity = mixed.file.scene.gravity;
  std::set<std::string> names;
  for (const SceneBody& body : mixed.file.scene.bodies) names.insert(body.name);
  std::size_t number = 0;
  for (const toml::node& node : *table["bodies"].as_array()) {
    ++number;
    if (!is_of_tets(node)) continue;
    Copies copies;
    Result<TetSceneBody> body =
        read_tets_body(*node.as_table(), number,
                       {path, mixed.file.scene.step, gravity.at(0.0), &copies, &mixed.file.files});
    if (!body) return body.error();
    add_copies(*body, copies, mixed.tets);
  }
  if (Status s = read_cloth_bodies(table, mixed); !s) return s.error();
  std::vector<std::string> guests;
  for (const TetSceneBody& body : mixed.tets) guests.push_back(body.name);
  for (const ClothSceneBody& body : mixed.cloths) guests.push_back(body.name());
  for (const std::string& name : guests)
    if (!names.insert(name).second)
      return content_error(path + ": two bodies are called '" + name + "'");
  return mixed;
}

void MixedFile::set_guest_step(double step) {
  for (TetSceneBody& body : tets) body.options.step = step;
  for (ClothSceneBody& body : cloths) body.scene.options.step = step;
}

}  // namespace tremolo
