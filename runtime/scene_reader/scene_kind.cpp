#include "runtime/scene_reader/scene_kind.h"

#include <algorithm>

#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {
namespace {

bool is_of_tets(const toml::node& body) {
  const toml::table* table = body.as_table();
  return table != nullptr && (*table)["kind"].value_or(std::string_view()) == "tets";
}

}  // namespace

Result<SceneKind> scene_kind(std::string_view text, const std::string& path) {
  const Result<toml::table> table = parse_toml(text, path);
  if (!table) return table.error();
  if (table->contains("cloths")) {
    if (!table->contains("bodies")) return SceneKind::kCloth;
    return error_at(path, table->find("cloths")->second.source(),
                    "[[bodies]] and [[cloths]] do not go together: a scene has the ones or the "
                    "others; take them apart into two files");
  }
  const toml::array* bodies = (*table)["bodies"].as_array();
  if (bodies == nullptr) return SceneKind::kBodies;
  const std::ptrdiff_t tets = std::count_if(bodies->begin(), bodies->end(), is_of_tets);
  if (tets == 0) return SceneKind::kWorld;
  if (static_cast<std::size_t>(tets) == bodies->size()) return SceneKind::kTets;
  return error_at(path, bodies->source(),
                  "bodies of kind \"tets\" and others do not meet in one scene: take two scenes");
}

}  // namespace tremolo
