#include "runtime/viewer/cloth/cloth_hand_record.h"

#include <filesystem>
#include <utility>

#include "runtime/cloth/cloth_model.h"
#include "runtime/viewer/live/recorded_text.h"

namespace tremolo {

void ClothHandRecord::before_step(const ClothWorld& world, std::size_t cloth, std::size_t particle,
                                  const Eigen::Vector3d& way) {
  const ClothScene& scene = world.scene();
  if (!std::exchange(holds_, true)) {
    ClothHand taken;
    taken.cloth = scene.cloths[cloth].name;
    taken.particle = world.model(cloth).parts().vertex_of_particle(particle);
    taken.from = world.time();
    taken.motion = hand_motion();
    add_hand_key(taken.motion, world.time(), Eigen::Vector3d::Zero());
    hands_.push_back(std::move(taken));
  }
  add_hand_key(hands_.back().motion, static_cast<double>(world.steps() + 1) * scene.options.step,
               way);
}

void ClothHandRecord::end(double time) {
  if (std::exchange(holds_, false)) hands_.back().until = time;
}

void ClothHandRecord::clear() {
  hands_.clear();
  holds_ = false;
}

Status write_recorded_cloth(const std::string& path, const ClothFile& file, const ClothScene& now,
                            const std::vector<ClothHand>& hands) {
  toml::table table = moved_scene(file.text, file.path, std::filesystem::path(path).parent_path());
  table.insert_or_assign("step", now.options.step);
  table.insert_or_assign("integrator", now.integrator);
  table.insert_or_assign("tolerance", now.options.tolerance);
  table.insert_or_assign("max-iterations", now.options.max_iterations);
  table.insert_or_assign("duration", now.duration);
  std::vector<toml::table> tables;
  for (const ClothHand& hand : hands) {
    toml::table one{{"cloth", hand.cloth},
                    {"at", static_cast<std::int64_t>(hand.particle)},
                    {"from", hand.from}};
    if (hand.until < kForEver) one.insert("until", hand.until);
    one.insert("motion", hand_motion_table(hand.motion));
    tables.push_back(std::move(one));
  }
  return write_scene_with_hands(path, table, tables);
}

}  // namespace tremolo
