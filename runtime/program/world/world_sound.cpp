#include "runtime/program/world/world_sound.h"

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

}  // namespace

Result<WorldSound> WorldSound::create(const std::string& listen, const SceneWorld& world) {
  WorldSound sound;
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
    if (selector.empty() && name.empty() && model.default_load().vertices.empty()) continue;
    Result<Ear> ear = Ear::create(selector, model);
    if (!ear)
      return Error{ear.error().kind, "body '" + world.name(i) + "': " + ear.error().message};
    sound.heard_.push_back({i, std::move(*ear)});
  }
  if (sound.heard_.empty())
    return content_error(
        "--wav: no body of the scene has a default load: say where to --listen, as BODY:SELECTOR");
  return sound;
}

void WorldSound::add(const SceneWorld& world) {
  double place = 0.0;
  for (const HeardBody& heard : heard_) place += heard.ear.place(world.body(heard.body).state().q);
  track_.add(place);
}

}  // namespace tremolo
