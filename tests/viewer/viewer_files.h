// Common parts of the viewer's tests: the program, its pictures, systems on which it cannot draw.
#pragma once

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/apps/view/offscreen/egl_context.h"
#include "tests/support/run_program.h"

namespace tremolo::testing {

inline const std::string kView = TREMOLO_BIN_DIR "/tremolo view ";

inline std::string sample_model(const std::string& name) {
  return TREMOLO_MODEL_DIR "/" + name + ".tremolo";
}

// Why pictures cannot be made here; empty where they can.
inline std::string no_pictures() {
  const auto context = EglContext::create();
  return context ? "" : context.error().message;
}

struct Shots {
  ProgramResult result;
  nlohmann::json json;
};

// Off-screen pictures in FOLDER/out; flags behind the model's or scene's name.
inline Shots shoot(const std::string& folder, const std::string& what, const std::string& flags) {
  Shots shots;
  shots.result =
      run_program(folder, kView + what + " --offscreen --json --out '" + folder + "/out' " + flags);
  shots.json = nlohmann::json::parse(shots.result.out, nullptr, false);
  return shots;
}

// The window of `tremolo view WHAT` with the mouse at its middle X, Y, in pixels, closed after some
// seconds. no_window: why there is none here; empty where there was one.
struct Windowed {
  Shots shots;
  std::string no_window;
};

// before: variables of the script's.
inline Windowed use_window(const std::string& folder, const std::string& before,
                           const std::string& middle, const std::string& what) {
  Windowed run;
  auto& [result, json] = run.shots;
  result = run_program(folder, before + TREMOLO_SOURCE_DIR "/tests/viewer/window.sh . 9 " + middle +
                                   " " + kView + what + " --lights 2 --size 780x580 --json");
  if (result.code == 77) run.no_window = "there is no Xvfb or no xdotool";
  if (result.code == 1 && result.err.find("no window with OpenGL") != std::string::npos)
    run.no_window = result.err;
  json = nlohmann::json::parse(result.out, nullptr, false);
  return run;
}

// Dragged from there.
inline Windowed drag_in_window(const std::string& folder, const std::string& middle,
                               const std::string& what) {
  return use_window(folder, "", middle, what);
}

// Each of the keys, as xdotool names them, is held down until it repeats.
inline Windowed hold_keys(const std::string& folder, const std::string& keys,
                          const std::string& what) {
  return use_window(folder, "HOLD='" + keys + "' ", "390 290", what);
}

}  // namespace tremolo::testing
