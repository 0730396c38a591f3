#include "runtime/apps/view/live/hand_record.h"

#include <sstream>
#include <string_view>
#include <utility>
#include <variant>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

std::vector<Keyframe>& keys_of(Motion& motion) {
  return std::get<KeyframeMotion>(motion.parts.front()).keys;
}

// True for keys whose value is a file name relative to the scene's folder.
bool names_file(std::string_view key, const toml::node& node) {
  if (!node.is_string()) return false;
  for (const char* known : {"model", "mesh", "file", "signal", "bone-weights", "gravity"})
    if (key == known) return true;
  return false;
}

struct Folders {
  fs::path old_one, new_one;
};

void move_paths(toml::node& node, const Folders& folders);

void move_paths(toml::table& table, const Folders& folders) {
  for (auto&& [key, value] : table) {
    if (!names_file(key.str(), value)) {
      move_paths(value, folders);
      continue;
    }
    toml::value<std::string>& text = *value.as_string();
    text = named_from(folders.new_one, folders.old_one / *text);
  }
}

void move_paths(toml::node& node, const Folders& folders) {
  if (toml::table* table = node.as_table()) move_paths(*table, folders);
  if (toml::array* array = node.as_array())
    for (toml::node& entry : *array) move_paths(entry, folders);
}

}  // namespace

std::string named_from(const fs::path& folder, const fs::path& file) {
  std::error_code ignored;
  const fs::path there = fs::weakly_canonical(file, ignored);
  const fs::path from = fs::weakly_canonical(folder.empty() ? "." : folder, ignored);
  const fs::path relative = there.lexically_relative(from);
  return (relative.empty() ? there : relative).generic_string();
}

toml::table moved_scene(const std::string& text, const std::string& file, const fs::path& folder) {
  toml::table table = toml::parse(text);
  move_paths(table, {fs::path(file).parent_path(), folder});
  return table;
}

Motion hand_motion() {
  Motion motion;
  motion.parts = {KeyframeMotion{.keys = {}, .interpolation = Interpolation::kLinear}};
  return motion;
}

void add_hand_key(Motion& motion, double time, const Eigen::Vector3d& way) {
  std::vector<Keyframe>& keys = keys_of(motion);
  const std::size_t count = keys.size();
  if (count > 1 && keys[count - 1].pose.position == way && keys[count - 2].pose.position == way)
    keys.pop_back();
  keys.push_back({time, {way, Eigen::Quaterniond::Identity()}});
}

toml::array hand_motion_table(const Motion& motion) {
  toml::array keys;
  for (const Keyframe& key : std::get<KeyframeMotion>(motion.parts.front()).keys) {
    toml::array row{key.time};
    for (const double x : key.pose.position) row.push_back(x);
    keys.push_back(std::move(row));
  }
  toml::table table{{"kind", "keyframes"}, {"interpolation", "linear"}, {"keys", std::move(keys)}};
  return toml::array{std::move(table)};
}

Status write_scene_with_hands(const std::string& path, toml::table& table,
                              const std::vector<toml::table>& hands) {
  if (!table.contains("hands")) table.insert("hands", toml::array{});
  for (const toml::table& hand : hands) table["hands"].as_array()->push_back(hand);
  if (table["hands"].as_array()->empty()) table.erase("hands");
  std::ostringstream text;
  text << "# Recorded by tremolo view: a hand does what the mouse did.\n" << table << "\n";
  return write_file(path, text.str());
}

void HandRecord::before_step(const LiveWorld& live) {
  const LiveHand& hand = live.hand();
  const SceneWorld& world = live.world();
  if (!hand.holds()) return end(world.time());
  const double h = world.step_size();
  if (!holds_) {
    SceneHand taken;
    taken.body = hand.name(world);
    taken.at = std::to_string(hand.vertex());
    taken.stiffness = hand.springs().stiffness;
    taken.damping = hand.springs().damping;
    taken.from = world.time();
    taken.motion = hand_motion();
    hands_.push_back(std::move(taken));
    add_hand_key(hands_.back().motion, world.time(), Eigen::Vector3d::Zero());
    holds_ = true;
  }
  add_hand_key(hands_.back().motion, static_cast<double>(world.steps() + 1) * h, hand.way());
}

void HandRecord::end(double time) {
  if (!std::exchange(holds_, false)) return;
  hands_.back().until = time;
}

void HandRecord::clear() {
  hands_.clear();
  holds_ = false;
}

}  // namespace tremolo
