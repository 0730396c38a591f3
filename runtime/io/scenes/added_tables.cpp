#include "runtime/io/scenes/added_tables.h"

#include <utility>
#include <vector>

#include "runtime/io/scenes/part_readers.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {

ClothScene surroundings_of(const MixedFile& scene) {
  ClothScene around;
  if (!scene.cloths.empty()) {
    around.wind = scene.cloths.front().scene.wind;
    around.gust = scene.cloths.front().scene.gust;
    around.gust_hz = scene.cloths.front().scene.gust_hz;
  }
  around.options.step = scene.file.scene.step;
  around.duration = scene.file.scene.duration;
  around.gravity = scene.file.scene.gravity;
  return around;
}

Result<MixedFile> parse_added_body(std::string_view table, const std::string& path,
                                   const ClothScene& around) {
  Result<toml::table> body = parse_toml(table, path);
  if (!body) return body.error();
  if (body->contains("copies"))
    return error_at(path, (*body)["copies"].node()->source(),
                    "bodies are added one by one: leave `copies` out");
  toml::table scene;
  scene.insert("bodies", toml::array{});
  scene["bodies"].as_array()->push_back(std::move(*body));
  Result<MixedFile> mixed = read_mixed(scene, path);
  if (!mixed) return mixed.error();
  mixed->set_guest_step(around.options.step);
  for (ClothSceneBody& cloth : mixed->cloths) {
    cloth.scene.gravity = around.gravity;
    cloth.scene.wind = around.wind;
    cloth.scene.gust = around.gust;
    cloth.scene.gust_hz = around.gust_hz;
    cloth.scene.duration = around.duration;
  }
  return mixed;
}

Result<SceneCollider> parse_added_collider(std::string_view table, const std::string& path) {
  const Result<toml::table> collider = parse_toml(table, path);
  if (!collider) return collider.error();
  std::vector<std::string> files;
  return read_collider(*collider, 1, path, files);
}

Result<SceneJoint> parse_added_joint(std::string_view table, const std::string& path) {
  const Result<toml::table> keys = parse_toml(table, path);
  if (!keys) return keys.error();
  return read_joint(*keys, 1, path);
}

Result<SceneLoad> parse_added_load(std::string_view table, const std::string& path) {
  const Result<toml::table> parsed = parse_toml(table, path);
  if (!parsed) return parsed.error();
  std::vector<std::string> files;
  TomlKeys keys(*parsed, path, "load");
  Result<std::vector<SceneLoad>> loads = read_load(keys, "square", files);
  if (!loads) return loads.error();
  if (Status s = keys.finish(); !s) return s.error();
  if (loads->empty()) return content_error(path + ": the load is \"none\"");
  return std::move(loads->front());
}

}  // namespace tremolo
