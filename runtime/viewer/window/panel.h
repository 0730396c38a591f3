// The panel: what the user sets and reads beside the bodies.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "runtime/viewer/live/runner.h"
#include "runtime/viewer/stage/stage.h"

namespace tremolo {

inline constexpr float kPanelWidth = 330.0f;  // pixels

// Facts of a body, found once. full: how much of each coordinate moves the drawn surface by a sixth
// of its size, kg^1/2 m. hz: frequencies.
struct ModeFacts {
  std::string name;
  std::vector<double> full, hz;
};
std::vector<ModeFacts> mode_facts(const SceneWorld& world);

// A mode that is shown to and fro while the world is paused.
struct Swing {
  std::size_t body = 0;
  int mode = 0;
  double share = 0.7;  // of ModeFacts::full
  double began = 0.0;  // s
};

// What the panel sets. A wish is fulfilled by who draws the panel, and then taken back.
struct PanelState {
  std::size_t body = 0;
  float rate = 1.0f;
  float alpha = 0.0f, log_beta = -7.0f;
  std::array<float, 3> gravity{};
  // False: the scene's own changes with time.
  bool gravity_is_ours = true, damping_is_ours = true;
  float step_ms = 3.0f;
  float firmness = 1.0f;
  ColourBy colour = ColourBy::kBody;
  bool knows_stress = false;  // of some body
  bool wire = false, colliders = true, panel = true;
  int lights = 8, coarser = 1;
  std::string shown_by;  // the card
  std::optional<Swing> swing;
  std::array<char, 200> record_to{};
  bool recording = false, records_hand = false;
  std::string record_trouble;
  bool wants_reset = false, wants_frame = false, wants_record = false;
};

// What it shows of the pictures.
struct PictureCosts {
  double prepare_ms = 0.0, panel_ms = 0.0, draw_ms = 0.0, pictures_per_s = 0.0;
  float full = 0.0f;  // what is red: m or Pa
};

// Begins with what the world has.
PanelState first_panel(const LiveWorld& live, double rate);

// One frame of it, between ImGui's NewFrame and Render. moment: what is shown.
void build_panel(PanelState& state, Runner& runner, const std::vector<ModeFacts>& modes,
                 const WorldMoment& moment, const PictureCosts& costs);

}  // namespace tremolo
