// Options of `tremolo view`.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// Fields are named after the flags. body: its model, load and integrator, as for `tremolo run`.
struct ViewerOptions {
  std::string file;
  std::string beside;  // of cloth: a second scene, shown next to the first
  RunOptions body;
  bool offscreen = false;
  int frames = 1;
  double from = 0.0;   // s
  double rate = 60.0;  // pictures a simulated second
  std::string size = "1280x720";
  std::string out;     // a folder of PNGs
  std::string video;   // a file
  std::string camera;  // AZIMUTH,ELEVATION[,ZOOM]; empty: the usual one
  std::string up = "auto";
  std::string background = "studio";
  std::string colour = "body";      // or moved, or stress
  double moved_full = 0.0;          // m; 0: the largest that was seen
  double stress_full = 0.0;         // Pa; 0: the largest that was seen
  std::vector<std::string> paints;  // "#rrggbb", or BODY=#rrggbb
  std::vector<std::string> textures;
  bool wire = false;
  bool follow = false;
  bool no_colliders = false;
  int lights = 0;  // 0: as many as suit
  double slow = 1.0;
  std::string record_hand;
  double duration = 0.0;  // of a window, s by the clock; 0: until it is closed
  bool measure = false;
  bool paused = false;
  bool json = false;
};

}  // namespace tremolo
