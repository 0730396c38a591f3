#include "runtime/apps/tremolo/output/world_sound.h"

#include <algorithm>
#include <string_view>

namespace tremolo {
namespace {

// "bell" is the name of "bell", and of its copies "bell-1", "bell-2" ...
bool is_named(std::string_view body, std::string_view name) {
  if (!body.starts_with(name)) return false;
  const std::string_view rest = body.substr(name.size());
  return rest.empty() || (rest.size() > 1 && rest[0] == '-' &&
                          rest.find_first_not_of("0123456789", 1) == std::string_view::npos);
}

bool is_any_named(const SceneWorld& world, std::string_view name) {
  for (std::size_t i = 0; i < world.size(); ++i)
    if (is_named(world.name(i), name)) return true;
  return false;
}

// The method of a body in the world.
IntegratorOptions options_of(const SceneWorld& world, std::size_t body) {
  IntegratorOptions options = world.scene().bodies[body].options;
  options.step = world.step_size();
  options.moving_frame = world.body(body).frame() != FrameKind::kFixed;
  return options;
}

}  // namespace

int steps_a_sample(const SceneWorld& world) {
  int most = 1;
  for (std::size_t i = 0; i < world.size(); ++i)
    most = std::max(most, steps_a_sample(world.body(i).model(), world.scene().bodies[i].integrator,
                                         options_of(world, i), 1.0 / world.step_size()));
  return most;
}

std::vector<std::string> sound_warnings(const SceneWorld& world, double rate) {
  std::vector<std::string> warnings;
  std::vector<const Model*> seen;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    if (std::find(seen.begin(), seen.end(), &model) != seen.end()) continue;
    seen.push_back(&model);
    const std::string warning =
        sound_warning(model, world.scene().bodies[i].integrator, options_of(world, i), rate);
    if (!warning.empty()) warnings.push_back("body '" + world.name(i) + "': " + warning);
  }
  return warnings;
}

Result<WorldSound> WorldSound::create(const std::string& listen, const SceneWorld& world,
                                      int steps) {
  WorldSound sound(steps, steps * world.step_size());
  std::string name, selector = listen;
  // Selectors have colons of their own: "near:0,0,1".
  if (const std::size_t colon = listen.find(':'); colon != std::string::npos)
    if (is_any_named(world, std::string_view(listen).substr(0, colon))) {
      name = listen.substr(0, colon);
      selector = listen.substr(colon + 1);
    }
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    if (!name.empty() && !is_named(world.name(i), name)) continue;
    const bool named = !name.empty() || !selector.empty() || world.size() == 1;
    if (!named && model.default_load().vertices.empty()) continue;
    if (model.modes() == 0 && name.empty()) {
      sound.left_out_.push_back(i);
      continue;
    }
    Result<Ear> ear = Ear::create(selector, model, 1.0 / sound.interval_);
    if (!ear)
      return Error{ear.error().kind, "body '" + world.name(i) + "': " + ear.error().message};
    sound.heard_.push_back({i, std::move(*ear)});
  }
  if (sound.heard_.empty() && !sound.left_out_.empty())
    return content_error(
        "--wav: no body of the scene has modes, and rigid bodies, tetrahedra and cloth make no "
        "sound");
  if (sound.heard_.empty())
    return content_error(
        "--wav: no body of the scene has a default load: say where to --listen, as BODY:SELECTOR");
  return sound;
}

}  // namespace tremolo
