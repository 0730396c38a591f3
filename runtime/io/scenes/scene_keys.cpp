#include "runtime/io/scenes/scene_keys.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {

std::optional<DampingRatios> read_damping_ratio(TomlKeys& keys) {
  const toml::node* node = keys.find("damping-ratio");
  if (node == nullptr) return std::nullopt;
  const auto fail = [&](const std::string& problem) {
    keys.fail("damping-ratio", problem);
    return std::nullopt;
  };
  if (keys.has("alpha") || keys.has("beta"))
    return fail("`damping-ratio` gives the damping: leave `alpha` and `beta` out");
  const auto text = damping_text(*node);
  if (!text)
    return fail("'damping-ratio' must be a text such as \"2%\", a number or a list of them");
  Result<DampingRatios> damping = parse_damping(*text);
  if (!damping) return fail("'damping-ratio': " + damping.error().message);
  return std::move(*damping);
}

bool is_folder_name(const std::string& name) {
  return !name.empty() && name.front() != '.' &&
         name.find_first_not_of(
             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") ==
             std::string::npos;
}

void read_folder_name(TomlKeys& keys, std::string& name) {
  keys.read("name", name);
  if (keys.good() && !is_folder_name(name))
    keys.fail("name", "a name has letters, digits, '.', '_', '-' only");
}

std::string told_name(const toml::table& table, const char* kind, std::size_t number) {
  if (const auto name = table["name"].value_exact<std::string>())
    return std::string(kind) + " '" + *name + "'";
  return std::string(kind) + " " + std::to_string(number);
}

Status read_gravity(TomlKeys& keys, const std::string& path, SceneGravity& gravity,
                    std::vector<std::string>& files) {
  const toml::node* node = keys.find("gravity");
  if (node == nullptr) return Success{};
  if (const auto value = numbers_of(*node); value && value->size() == 3) {
    gravity.values = {Eigen::Vector3d(value->data())};
    return Success{};
  }
  std::vector<std::vector<double>> rows;
  if (const auto name = node->value_exact<std::string>()) {
    std::string csv;
    keys.read_path("gravity", csv);
    if (!keys.good()) return keys.finish();
    files.push_back(csv);
    const Result<std::string> text = read_whole_file(csv);
    if (!text) return text.error();
    if (Status s = take(rows, parse_rows(*text, csv, {4}, "a time and gravity (t, x, y, z)")); !s)
      return s;
  } else if (const toml::array* array = node->as_array()) {
    for (const toml::node& row : *array)
      if (const auto numbers = numbers_of(row); numbers && numbers->size() == 4)
        rows.push_back(*numbers);
    if (rows.size() != array->size()) rows.clear();
  }
  if (rows.empty())
    return error_at(path, node->source(),
                    "'gravity' must be [x, y, z] in m/s^2, a list of [t, x, y, z] or the name of a "
                    "CSV file with such lines");
  for (const std::vector<double>& row : rows) {
    gravity.times.push_back(row[0]);
    gravity.values.emplace_back(row[1], row[2], row[3]);
  }
  return Success{};
}

void read_surface_outputs(TomlKeys& keys, SceneOutputs& outputs) {
  keys.read("out", outputs.out);
  keys.read("every", outputs.every);
  keys.read("surfaces", outputs.surfaces);
  const std::vector<std::string_view> formats = {"ply", "obj", "inc"};
  outputs.surface_format = formats[keys.read_word("surface-format", formats, 0)];
}

void read_outputs(TomlKeys& keys, SceneOutputs& outputs) {
  read_surface_outputs(keys, outputs);
  keys.read("plot", outputs.plot);
}

namespace {

bool is_of_kind(const toml::node& body, std::string_view kind) {
  const toml::table* table = body.as_table();
  return table != nullptr && (*table)["kind"].value_or(std::string_view()) == kind;
}

}  // namespace

namespace {

// True if a collider moves or is that of a file: only worlds have these.
bool has_worlds_colliders(const toml::table& scene) {
  const toml::array* colliders = scene["colliders"].as_array();
  if (colliders == nullptr) return false;
  return std::any_of(colliders->begin(), colliders->end(), [](const toml::node& one) {
    const toml::table* table = one.as_table();
    return table != nullptr && (table->contains("motion") || table->contains("file"));
  });
}

// Keys of a body that bodies of tetrahedra have in worlds alone.
bool has_loads(const toml::node& body) {
  const toml::table& table = *body.as_table();
  return table.contains("load") || table.contains("loads") || table.contains("signal");
}

}  // namespace

bool is_of_tets(const toml::node& body) {
  return is_of_kind(body, "tets");
}
bool is_of_cloth(const toml::node& body) {
  return is_of_kind(body, "cloth");
}

Result<SceneKind> scene_kind(std::string_view text, const std::string& path) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  if (table->contains("cloths")) {
    if (!table->contains("bodies")) return SceneKind::kCloth;
    return error_at(
        path, table->find("cloths")->second.source(),
        "[[bodies]] and [[cloths]] do not go together: next to other bodies a cloth is one of "
        "[[bodies]] with kind = \"cloth\"");
  }
  const toml::array* bodies = (*table)["bodies"].as_array();
  if (bodies == nullptr) return SceneKind::kBodies;
  const bool tets = !bodies->empty() && std::all_of(bodies->begin(), bodies->end(), is_of_tets);
  const bool held = table->contains("hands") || table->contains("joints");
  const toml::array* gravity = (*table)["gravity"].as_array();
  const bool changes = table->contains("gravity") &&
                       (gravity == nullptr || (!gravity->empty() && (*gravity)[0].is_array()));
  const bool loaded = tets && std::any_of(bodies->begin(), bodies->end(), has_loads);
  return tets && !held && !loaded && !changes && !has_worlds_colliders(*table) ? SceneKind::kTets
                                                                               : SceneKind::kWorld;
}

}  // namespace tremolo
