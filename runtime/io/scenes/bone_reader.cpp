#include <cstddef>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/io/scenes/part_readers.h"

namespace tremolo {
namespace {

Result<SceneBone> read_bone(const toml::table& table, const std::string& body, std::size_t number,
                            const std::string& path, std::vector<std::string>& files) {
  SceneBone bone;
  std::string what = body + ", bone " + std::to_string(number);
  if (const auto name = table["name"].value_exact<std::string>())
    what = body + ", bone '" + *name + "'";
  TomlKeys keys(table, path, what);
  keys.read("name", bone.name);
  if (!keys.has("name")) keys.fail("name", "it has no `name`");
  keys.read("parent", bone.parent);
  keys.read("head", bone.head);
  bone.tail = bone.head;
  keys.read("tail", bone.tail);
  if (Status s = take(bone.motion, read_motion(keys, path, what, files)); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return bone;
}

// A row a drawn vertex, a column a bone.
Status read_weights(const std::string& csv, SceneBody& body) {
  const Result<std::string> text = read_whole_file(csv);
  if (!text) return text.error();
  const std::size_t bones = body.bones.size();
  const auto rows = parse_rows(*text, csv, {bones},
                               "a weight for each of the " + std::to_string(bones) + " bones");
  if (!rows) return rows.error();
  body.bone_weights.resize(std::ssize(*rows), bones);
  for (std::size_t row = 0; row < rows->size(); ++row)
    body.bone_weights.row(row) =
        Eigen::RowVectorXd::Map((*rows)[row].data(), static_cast<Eigen::Index>(bones));
  const std::string problem = weights_problem(body.bone_weights);
  return problem.empty() ? Status(Success{}) : content_error(csv + ": " + problem);
}

}  // namespace

Status read_bones(TomlKeys& keys, const std::string& path, const std::string& what,
                  std::vector<std::string>& files, SceneBody& body) {
  std::string csv;
  keys.read("rig", body.rig);
  keys.read("clip", body.clip);
  keys.read("bone-blend", body.bone_blend);
  keys.read_path("bone-weights", csv);
  for (const toml::table* entry : keys.read_tables("bones")) {
    Result<SceneBone> bone = read_bone(*entry, what, body.bones.size() + 1, path, files);
    if (!bone) return bone.error();
    body.bones.push_back(std::move(*bone));
  }
  if (csv.empty() || !keys.good()) return Success{};
  if (body.bones.empty()) keys.fail("bone-weights", "there are no [[bodies.bones]]");
  if (keys.has("bone-blend"))
    keys.fail("bone-blend", "`bone-weights` and `bone-blend` say one thing: leave one out");
  if (!keys.good()) return Success{};
  files.push_back(csv);
  return read_weights(csv, body);
}

}  // namespace tremolo
