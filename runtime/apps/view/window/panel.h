// The panel with the user's settings and the readouts.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "runtime/apps/view/live/mode_orbits.h"
#include "runtime/apps/view/live/runner.h"
#include "runtime/apps/view/stage/stage.h"

namespace tremolo {

inline constexpr float kPanelWidth = 330.0f;  // pixels

// Facts of a body, computed once.
struct ModeFacts {
  std::string name;
  // Amount of each coordinate that moves the drawn surface by a sixth of its size, kg^1/2 m.
  std::vector<double> full;
  std::vector<double> hz;        // frequencies
  const Model* model = nullptr;  // not owned
};
std::vector<ModeFacts> mode_facts(const SceneWorld& world);

// A mode shown oscillating while the world is paused.
struct Swing {
  std::size_t body = 0;
  int mode = 0;
  double share = 0.7;  // of ModeFacts::full
  double began = 0.0;  // s
};

// A mode's periodic motion of any amplitude, shown in place of a body's state.
struct OrbitShow {
  std::size_t body = 0;  // whose orbits they are
  int mode = 1;          // from 1
  float percent = 5.0f;  // amplitude, of the body's size
  bool plays = false;
  double began = 0.0;                // s
  std::optional<ModeOrbits> orbits;  // empty: not found yet
  std::string trouble;
  bool opens = false;  // the section is open at the start
};

// Settings of the panel. Whoever draws the panel fulfils the `wants_` requests and clears them.
struct PanelState {
  std::size_t body = 0;
  float rate = 1.0f;
  float alpha = 0.0f, log_beta = -7.0f;
  std::array<float, 3> gravity{};
  // False: the scene changes the value with time, or guests of the world have it, too.
  bool gravity_is_ours = true, damping_is_ours = true;
  float step_ms = 3.0f;
  float firmness = 1.0f;
  ColourBy colour = ColourBy::kBody;
  bool knows_stress = false, knows_degrees = false;  // of some body
  std::vector<std::string> guests;  // "NAME: METHOD" of each; with some the step is fixed
  bool wire = false, colliders = true, panel = true;
  int lights = 8, coarser = 1;
  std::string shown_by;  // the card
  std::optional<Swing> swing;
  OrbitShow orbit;
  std::array<char, 200> record_to{};
  bool recording = false, records_hand = false;
  std::string record_trouble;
  bool wants_reset = false, wants_frame = false, wants_record = false;
};

// Readouts about the pictures.
struct PictureCosts {
  double prepare_ms = 0.0, panel_ms = 0.0, draw_ms = 0.0, pictures_per_s = 0.0;
  float full = 0.0f;  // the value shown in red: m or Pa
};

// The settings of the world at its start.
PanelState first_panel(const LiveWorld& live, double rate);

// Builds one frame, between ImGui's NewFrame and Render. moment: the state shown.
void build_panel(PanelState& state, Runner& runner, OrbitFinder& finder,
                 const std::vector<ModeFacts>& modes, const WorldMoment& moment,
                 const PictureCosts& costs);

// Takes orbits that have been found.
void receive_orbits(OrbitFinder& finder, OrbitShow& orbit);
// The coordinates of the shown orbit now; empty: none is played.
std::optional<Eigen::VectorXd> shown_orbit(const OrbitShow& orbit);

// Mouse control of the camera and of pulled bodies. The left button on a body pulls it, in the
// plane through the grabbed point that faces the camera. The left button elsewhere and the right
// button rotate the camera about its target, the middle button and shift move it, the wheel zooms.
class Mouse {
 public:
  Mouse(Runner& runner, Camera& camera) : runner_(runner), camera_(camera) {}

  // aspect: of the window, width over height.
  void button(int button, bool down, bool shift, double aspect);
  void move(double x, double y, double aspect);
  void wheel(double turns);
  // Call it once per picture: it finds whether the last press has hit a body.
  void update(double aspect);
  // The hand's stiffness relative to the suitable one.
  double firmness = 1.0;
  bool pulls() const { return drag_ == Drag::kPull; }

 private:
  enum class Drag { kNone, kOrbit, kPan, kAsks, kPull };
  void pull_to(double aspect, Runner::Clock::time_point event);

  Runner& runner_;
  Camera& camera_;
  Drag drag_ = Drag::kNone;
  double x_ = 0.5, y_ = 0.5;
  Eigen::Vector3d taken_ = Eigen::Vector3d::Zero();  // where the ray met the body, m
  Runner::Clock::time_point last_event_;
};

}  // namespace tremolo
