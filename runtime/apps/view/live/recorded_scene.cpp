#include <filesystem>
#include <string>

#include <toml++/toml.h>

#include "runtime/apps/view/live/hand_record.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

toml::array numbers(const Eigen::Vector3d& v) {
  return toml::array{v[0], v[1], v[2]};
}

toml::table table_of(const SceneHand& hand) {
  toml::table table{{"body", hand.body},
                    {"at", std::stoll(hand.at)},
                    {"stiffness", hand.stiffness},
                    {"damping", hand.damping},
                    {"from", hand.from}};
  if (hand.until < kForEver) table.insert("until", hand.until);
  table.insert("motion", hand_motion_table(hand.motion));
  return table;
}

const char* signal_name(SignalKind kind) {
  switch (kind) {
    case SignalKind::kImpulse:
      return "impulse";
    case SignalKind::kSquare:
      return "square";
    case SignalKind::kSine:
      return "sine";
    case SignalKind::kChirp:
      return "chirp";
    case SignalKind::kRamp:
      return "ramp";
    case SignalKind::kConstant:
      return "constant";
    default:
      return "none";
  }
}

// Table of a body that has no scene, or one without [[bodies]].
Result<toml::table> table_of(const SceneBody& body, const std::string& start,
                             const fs::path& folder) {
  if (!start.empty() && start != "static")
    return content_error("a scene with [[bodies]] cannot say --start " + start +
                         ": record a hand without it");
  toml::table table{{"name", body.name}, {"model", named_from(folder, body.model)}};
  if (!start.empty()) table.insert("start", start);
  if (body.model_options.modes > 0) table.insert("modes", body.model_options.modes);
  if (body.model_options.linear) table.insert("linear", true);
  if (body.model_options.hull) table.insert("hull", true);
  const IntegratorOptions& o = body.options;
  table.insert("newmark-beta", o.newmark_beta);
  table.insert("newmark-gamma", o.newmark_gamma);
  table.insert("tolerance", o.tolerance);
  table.insert("max-iterations", o.max_iterations);
  table.insert("safety", o.split.safety);
  if (o.split.rule == SplitRule::kThesis) table.insert("split", "thesis");
  if (o.split.rule == SplitRule::kCount) table.insert("split", o.split.count);
  for (const SceneLoad& load : body.loads) {
    if (load.signal.kind == SignalKind::kTable)
      return content_error("a recorded hand does not go with --signal: take a scene that says it");
    table.insert("load", signal_name(load.signal.kind));
    if (load.signal.kind == SignalKind::kSine) table.insert("frequency", load.signal.frequency);
    if (load.signal.kind == SignalKind::kChirp)
      table.insert("sweep", toml::array{load.signal.frequency, load.signal.last_frequency});
    if (load.signal.duration > 0.0) table.insert("load-duration", load.signal.duration);
    table.insert("scale", load.scale);
    if (load.at.empty()) continue;
    table.insert("at", load.at);
    table.insert("force", numbers(load.force));
  }
  return table;
}

// Writes the keys that may have changed since the scene was read.
void say_method(const LiveWorld& live, std::size_t i, toml::table& table) {
  const ContactBody& body = live.world().body(i);
  table.insert_or_assign("integrator", std::string(body.integrator().name()));
  // Values that the scene changes in time keep the scene's keys.
  const SceneBody& wanted = live.viewed().scene.bodies[i];
  if (body.options().ratios.of_each_mode()) {
    table.insert_or_assign("damping-ratio", ratios_text(body.options().ratios));
    table.erase("alpha");
    table.erase("beta");
    return;
  }
  table.erase("damping-ratio");
  if (wanted.alphas.empty()) table.insert_or_assign("alpha", body.options().alpha);
  if (wanted.betas.empty()) table.insert_or_assign("beta", body.options().beta);
}

Result<toml::table> begun_table(const LiveWorld& live, const fs::path& folder) {
  const ViewedScene& viewed = live.viewed();
  if (!viewed.text.empty()) return moved_scene(viewed.text, viewed.file, folder);
  toml::array bodies;
  for (std::size_t i = 0; i < viewed.scene.bodies.size(); ++i) {
    Result<toml::table> body = table_of(viewed.scene.bodies[i], viewed.starts[i], folder);
    if (!body) return body.error();
    bodies.push_back(std::move(*body));
  }
  toml::table table{{"duration", viewed.scene.duration}};
  table.insert("bodies", std::move(bodies));
  return table;
}

}  // namespace

Status write_recorded_scene(const std::string& path, const LiveWorld& live,
                            const std::vector<SceneHand>& hands) {
  Result<toml::table> begun = begun_table(live, fs::path(path).parent_path());
  if (!begun) return begun.error();
  toml::table& table = *begun;
  table.insert_or_assign("step", live.world().step_size());
  // Copies have one entry in the file, and one method.
  std::size_t at = 0;
  for (toml::node& node : *table["bodies"].as_array()) {
    toml::table& body = *node.as_table();
    if (is_of_tets(body) || is_of_cloth(body)) continue;  // these keep their methods
    const std::string name = body["name"].value_or<std::string>("");
    while (at < live.world().size() && live.world().name(at) != name &&
           !live.world().name(at).starts_with(name + "-"))
      ++at;
    if (at < live.world().size()) say_method(live, at, body);
  }
  std::vector<toml::table> tables;
  for (const SceneHand& hand : hands) tables.push_back(table_of(hand));
  return write_scene_with_hands(path, table, tables);
}

}  // namespace tremolo
