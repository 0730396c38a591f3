// The flags of `tremolo view`, and the two ways in which it shows: a window, pictures without a
// display.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/apps/view/live/viewed_scene.h"
#include "runtime/io/scenes/scene_keys.h"

namespace tremolo {

// Options of `tremolo view`. Fields are named after the flags. body: its model, load and
// integrator, as for `tremolo run`.
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
  int lights = 0;     // 0: as many as suit
  std::string orbit;  // MODE:AMPLITUDE (live/mode_orbits.h), in place of the state; empty: none
  double slow = 1.0;
  std::string record_hand;
  double duration = 0.0;  // of a window, s by the clock; 0: until it is closed
  bool measure = false;
  bool paused = false;
  bool json = false;
};

// All files that the view reads: those of the scene, and pictures of --texture.
std::vector<NamedFile> inputs_of_view(const ViewerOptions& options,
                                      std::vector<NamedFile> of_scene);

// Checks the existing pictures in --out, the film and the recorded hand. Errors: kUsage if one of
// them is an input or another of them, or for flags that exclude each other; kSystem if one cannot
// be written.
Status check_view_outputs(const ViewerOptions& options, const std::vector<NamedFile>& inputs);

// True if the file is a scene of that kind; also false for an unreadable file, which other readers
// report.
bool is_scene_of(SceneKind kind, const std::string& file);

// Ends the program with the code, or the printed error. The calling process sees that a signal
// ended it.
int end_view(const Result<int>& code);

// `tremolo view`: the window. Shows the scene until the window is closed. The exit code; errors are
// printed on stderr.
int window_command(const ViewerOptions& options, const ViewedScene& viewed);

// `tremolo view --offscreen`: pictures without a display. Renders the frames and writes them.
// Returns the exit code; errors are printed on stderr. A body whose step fails stays at rest; all
// frames are still written, and the exit code is that of the step.
int offscreen_command(const ViewerOptions& options, const ViewedScene& viewed);

}  // namespace tremolo
