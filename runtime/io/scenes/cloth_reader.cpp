#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/io/scenes/copies.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/io/scenes/part_readers.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {
namespace {

constexpr const char* kClothTables = "cloths";

// Along an edge of the grid the particles are counted by an int somewhere: no grid is larger.
constexpr int kMostAlongAnEdge = 10000;

std::size_t read_count(TomlKeys& keys, const char* key) {
  int count = 0;
  keys.read(key, count);
  if (keys.has(key) && keys.good() && !(count >= 2 && count <= kMostAlongAnEdge))
    keys.fail(key,
              std::string("'") + key + "' must be from 2 to " + std::to_string(kMostAlongAnEdge));
  return keys.good() ? static_cast<std::size_t>(count) : 0;
}

// Reads a direction of any length but zero and normalises it.
void read_direction(TomlKeys& keys, const char* key, Eigen::Vector3d& direction) {
  keys.read(key, direction);
  if (!(direction.norm() > 0.0)) return keys.fail(key, std::string("'") + key + "' has no length");
  direction.normalize();
}

void read_grid(TomlKeys& keys, ClothGrid& grid) {
  grid.columns = read_count(keys, "columns");
  grid.rows = read_count(keys, "rows");
  keys.read("width", grid.width);
  keys.read("height", grid.height);
  keys.read("corner", grid.corner);
  read_direction(keys, "along", grid.along);
  read_direction(keys, "across", grid.across);
}

// columns and rows, or a file.
void read_shape(TomlKeys& keys, SceneCloth& cloth) {
  keys.read_path("file", cloth.file);
  const Pose pose = read_pose(keys);
  cloth.position = pose.position;
  cloth.rotation = pose.rotation;
  if (!keys.has("file")) {
    if (!keys.has("columns") || !keys.has("rows"))
      keys.fail("columns", "it needs `columns` and `rows`, or a `file`");
    return read_grid(keys, cloth.grid);
  }
  for (const char* key : {"columns", "rows", "width", "height", "corner", "along", "across"})
    if (keys.has(key))
      keys.fail(key, std::string("`") + key + "` applies only to a grid: leave it or `file` out");
}

// Reads [stiffness, damping], or the stiffness alone, which leaves the damping unchanged.
void read_law(TomlKeys& keys, const char* key, SpringLaw& law) {
  const toml::node* node = keys.find(key);
  if (node == nullptr || !node->is_array()) return keys.read(key, law.stiffness);
  const std::vector<double> numbers = keys.read_numbers(key, 2, 2);
  if (numbers.size() == 2) law = {numbers[0], numbers[1]};
}

// A missing mesh is reported at the key `file`, not at a pin that needs it.
Status check_mesh(TomlKeys& keys, const SceneCloth& cloth) {
  if (cloth.file.empty()) return Success{};
  const auto seen = examine_input(cloth.file);
  if (seen) return Success{};
  keys.fail("file", seen.error().message);
  Error error = keys.finish().error();
  error.kind = seen.error().kind;
  return error;
}

// The cloth and its copies. Places by coordinates are those of the cloth that was read.
std::vector<SceneCloth> copies_of(const SceneCloth& cloth, const Copies& copies) {
  if (copies.all() == 1 && !copies.random_turns) return {cloth};
  struct Named {
    std::string name;
    Pose pose;
  };
  const Pose pose{cloth.position, cloth.rotation};
  std::vector<Named> places;
  add_copies(Named{cloth.name, pose}, copies, places);
  std::vector<SceneCloth> cloths(places.size(), cloth);
  for (std::size_t i = 0; i < places.size(); ++i) {
    cloths[i].name = places[i].name;
    cloths[i].position = places[i].pose.position;
    cloths[i].rotation = places[i].pose.rotation;
    cloths[i].named_at = pose;
  }
  return cloths;
}

// All keys of a cloth. what: its name in errors.
Status read_cloth_keys(TomlKeys& keys, const std::string& path, const std::string& what,
                       std::vector<std::string>& files, SceneCloth& cloth) {
  read_folder_name(keys, cloth.name);
  read_shape(keys, cloth);
  keys.read("density", cloth.density);
  read_law(keys, "structural", cloth.structural);
  read_law(keys, "shear", cloth.shear);
  read_law(keys, "bend", cloth.bend);
  keys.read("drag", cloth.drag);
  keys.read("thickness", cloth.thickness);
  keys.read("friction", cloth.friction);
  keys.read("restitution", cloth.restitution);
  keys.read("crumple", cloth.crumple);
  cloth.settled = keys.read_word("start", {"rest", "static"}, 0) == 1;
  for (const char* key : {"alpha", "beta", "damping-ratio"})
    if (keys.has(key))
      keys.fail(key,
                "a cloth's springs have their own dampers: `structural`, `shear` and `bend` are "
                "[stiffness, damping]");
  if (!keys.good()) return keys.finish().error();
  if (Status s = check_mesh(keys, cloth); !s) return s;
  return read_pins(keys, path, what, files, cloth);
}

Result<std::vector<SceneCloth>> read_cloth(const toml::table& table, std::size_t number,
                                           const std::string& path,
                                           std::vector<std::string>& files) {
  SceneCloth cloth;
  const std::string what = told_name(table, "cloth", number);
  TomlKeys keys(table, path, what);
  if (number > 1) cloth.name += "-" + std::to_string(number);
  for (const char* key : {"load", "loads", "signal", "force"})
    if (keys.has(key))
      keys.fail(key,
                "loads act on a cloth that is one of [[bodies]], with kind = \"cloth\": write it "
                "as one, or hold it with [[hands]] here");
  for (const char* key : {"velocity", "spin"})
    if (keys.has(key))
      keys.fail(key,
                "cloths of [[cloths]] begin at rest: write it as one of [[bodies]], with kind = "
                "\"cloth\"");
  const Copies copies = read_copies(keys);
  if (Status s = read_cloth_keys(keys, path, what, files, cloth); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return copies_of(cloth, copies);
}

Result<SceneBall> read_ball(const toml::table& table, std::size_t number, const std::string& path,
                            std::vector<std::string>& files) {
  SceneBall ball;
  const std::string what = told_name(table, "ball", number);
  TomlKeys keys(table, path, what);
  ball.name = "ball-" + std::to_string(number);
  keys.read("name", ball.name);
  keys.read("radius", ball.radius);
  keys.read("mass", ball.mass);
  keys.read("position", ball.position);
  keys.read("velocity", ball.velocity);
  keys.read("spin", ball.spin);
  keys.read("fixed", ball.fixed);
  keys.read("friction", ball.friction);
  keys.read("restitution", ball.restitution);
  if (Status s = take(ball.motion, read_motion(keys, path, what, files, true)); !s)
    return s.error();
  if (!ball.motion.parts.empty() && !ball.fixed)
    keys.fail(
        "motion",
        "`motion` applies only to a ball with `fixed = true`: others move under their forces");
  for (const char* key : {"mass", "velocity", "spin"})
    if (ball.fixed && keys.has(key))
      keys.fail(key, std::string("`") + key + "` applies only to a ball that is not fixed");
  if (Status s = keys.finish(); !s) return s.error();
  return ball;
}

// cloths: those of the scene, read already; a hand that names none holds the first one.
Result<ClothHand> read_cloth_hand(const toml::table& table, std::size_t number,
                                  const std::string& path, std::vector<std::string>& files,
                                  const std::vector<SceneCloth>& cloths) {
  ClothHand hand;
  const std::string what = "hand " + std::to_string(number);
  TomlKeys keys(table, path, what);
  if (!keys.has("at")) keys.fail("at", "it has no `at`");
  if (!cloths.empty()) hand.cloth = cloths.front().name;
  keys.read("cloth", hand.cloth);
  const auto named = [&hand](const SceneCloth& cloth) { return cloth.name == hand.cloth; };
  const auto cloth = std::find_if(cloths.begin(), cloths.end(), named);
  if (cloth == cloths.end())
    keys.fail("cloth", "there is no cloth '" + hand.cloth + "'");
  else
    hand.particle = read_particle(keys, "at", *cloth);
  keys.read("from", hand.from);
  keys.read("until", hand.until);
  if (Status s = take(hand.motion, read_motion(keys, path, what, files)); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return hand;
}

void read_cloth_method(TomlKeys& keys, ClothScene& scene) {
  keys.read("integrator", scene.integrator);
  keys.read("tolerance", scene.options.tolerance);
  keys.read("max-iterations", scene.options.max_iterations);
  keys.read("halvings", scene.options.halvings);
  constexpr NodalSolver kSolvers[] = {NodalSolver::kAutomatic, NodalSolver::kCholesky,
                                      NodalSolver::kConjugateGradients};
  scene.options.solver =
      kSolvers[keys.read_word("solver", {"automatic", "cholesky", "conjugate-gradients"}, 0)];
}

void read_wind(TomlKeys& keys, ClothScene& scene) {
  keys.read("wind", scene.wind);
  keys.read("gust", scene.gust);
  keys.read("gust-hz", scene.gust_hz);
  for (const char* key : {"gust", "gust-hz"})
    if (keys.has(key) && !keys.has("wind"))
      keys.fail(key, "it varies the `wind`, [vx, vy, vz] in m/s, which is not given");
}

// There is no contact between cloths, so a scene with several must allow them to pass through each
// other. table: which has them.
void read_cloths_pass(TomlKeys& keys, const char* table, std::size_t cloths) {
  bool may_pass = false;
  keys.read("cloths-pass", may_pass);
  if (cloths > 1 && !may_pass)
    keys.fail(table,
              "cloth does not touch cloth: several in one scene go through each other, which "
              "`cloths-pass = true` allows");
}

// The tables of one kind, each by `read`.
template <class Value, class Read>
Status read_all(TomlKeys& keys, const char* key, const std::string& path,
                std::vector<std::string>& files, std::vector<Value>& values, const Read& read) {
  std::size_t number = 0;
  for (const toml::table* entry : keys.read_tables(key)) {
    Result<Value> value = read(*entry, ++number, path, files);
    if (!value) return value.error();
    values.push_back(std::move(*value));
  }
  return Success{};
}

}  // namespace

namespace {

// around: the world's step, duration, gravity and wind.
Result<std::vector<ClothSceneBody>> read_cloth_body(const toml::table& table, std::size_t number,
                                                    const std::string& path,
                                                    std::vector<std::string>& files,
                                                    const ClothScene& around) {
  ClothSceneBody body;
  body.scene = around;
  const std::string what = told_name(table, "body", number);
  TomlKeys keys(table, path, what);
  keys.find("kind");
  if (!keys.has("name")) keys.fail("name", "it has no `name`");
  if (keys.has("contact-margin"))
    keys.fail("contact-margin",
              "the contact of a cloth begins at its `thickness`, m: leave `contact-margin` out");
  keys.read("velocity", body.velocity);
  keys.read("spin", body.spin);
  const Copies copies = read_copies(keys);
  read_cloth_method(keys, body.scene);
  read_contact_stiffness(keys, body.contact);
  keys.read("probe", body.probes);
  if (Status s = take(body.loads, read_loads(keys, path, what, files)); !s) return s.error();
  SceneCloth cloth;
  if (Status s = read_cloth_keys(keys, path, what, files, cloth); !s) return s.error();
  if (!body.spin.isZero(0.0) && !cloth.pins.empty())
    keys.fail(
        "spin",
        "pins hold the cloth, so that it cannot spin: leave `spin` or `pins` out, or give the "
        "pins a `motion`");
  for (const char* key : {"velocity", "spin"})
    if (cloth.settled && keys.has(key))
      keys.fail(key, "start = \"static\" means at rest: leave one of both out");
  if (Status s = keys.finish(); !s) return s.error();
  std::vector<ClothSceneBody> bodies;
  for (SceneCloth& copy : copies_of(cloth, copies)) {
    body.scene.cloths = {std::move(copy)};
    bodies.push_back(body);
  }
  return bodies;
}

}  // namespace

Status read_cloth_bodies(const toml::table& table, MixedFile& mixed) {
  const SceneFile& file = mixed.file;
  ClothScene around;
  around.options.step = file.scene.step;
  around.duration = file.scene.duration;
  around.gravity = file.scene.gravity;
  TomlKeys keys(table, file.path, "");
  read_wind(keys, around);
  std::size_t number = 0;
  for (const toml::table* entry : keys.read_tables("bodies")) {
    ++number;
    if (!is_of_cloth(*entry)) continue;
    Result<std::vector<ClothSceneBody>> bodies =
        read_cloth_body(*entry, number, file.path, mixed.file.files, around);
    if (!bodies) return bodies.error();
    std::move(bodies->begin(), bodies->end(), std::back_inserter(mixed.cloths));
  }
  read_cloths_pass(keys, "bodies", mixed.cloths.size());
  if (!keys.good()) return keys.finish();
  for (const ClothSceneBody& body : mixed.cloths)
    if (Status s = check_scene(body.scene); !s) return error_of_file(file.path, s.error());
  return Success{};
}

Result<ClothFile> parse_cloths(std::string_view text, const std::string& path) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  ClothFile file;
  file.path = path;
  file.text = text;
  ClothScene& scene = file.scene;
  TomlKeys keys(*table, path, "");
  keys.read("step", scene.options.step);
  keys.read("duration", scene.duration);
  read_cloth_method(keys, scene);
  read_outputs(keys, file.outputs);
  if (Status s = read_gravity(keys, path, scene.gravity, file.files); !s) return s.error();
  read_wind(keys, scene);
  std::vector<std::string>& files = file.files;
  std::vector<std::vector<SceneCloth>> with_copies;
  if (Status s = read_all(keys, kClothTables, path, files, with_copies, read_cloth); !s)
    return s.error();
  for (std::vector<SceneCloth>& cloths : with_copies)
    std::move(cloths.begin(), cloths.end(), std::back_inserter(scene.cloths));
  read_cloths_pass(keys, kClothTables, scene.cloths.size());
  if (Status s = read_all(keys, "balls", path, files, scene.balls, read_ball); !s) return s.error();
  if (Status s = read_all(keys, "colliders", path, files, scene.colliders, read_collider); !s)
    return s.error();
  const auto read_hand_of = [&scene](const toml::table& entry, std::size_t number,
                                     const std::string& from, std::vector<std::string>& known) {
    return read_cloth_hand(entry, number, from, known, scene.cloths);
  };
  if (Status s = read_all(keys, "hands", path, files, scene.hands, read_hand_of); !s)
    return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  if (Status s = check_scene(scene); !s) return error_of_file(path, s.error());
  return file;
}

}  // namespace tremolo
