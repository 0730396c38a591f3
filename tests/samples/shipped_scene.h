// The scenes of assets/scenes, for tests that run them.
#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace tremolo::testing {

// The text of assets/scenes/NAME.toml with the models of this build.
inline std::string shipped_scene(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(TREMOLO_SOURCE_DIR "/assets/scenes/" + name + ".toml").rdbuf();
  std::string scene = text.str();
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{"../../build/models", TREMOLO_MODEL_DIR},
        {"\"earthquake.csv\"", "\"" TREMOLO_SOURCE_DIR "/assets/scenes/earthquake.csv\""}})
    for (std::size_t at = 0; (at = scene.find(from, at)) != std::string::npos; at += to.size())
      scene.replace(at, from.size(), to);
  return scene;
}

}  // namespace tremolo::testing
