// Options of one body, as flags or the keys of a scene's table name them. body_scene.h makes a
// scene of them.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "common/result.h"
#include "runtime/integrator.h"

namespace tremolo {

// A model, its damping, and what its load acts on. The names are those of the flags; units SI.
struct LoadedModelOptions {
  std::string model;    // path of the basis file
  int modes = 0;        // leading coordinates to keep; 0: all
  bool linear = false;  // without the cubic and quartic terms
  std::string rescale;  // "young=PA,density=KG/M3": another material (run_body.h)
  std::string at;       // vertex or selector; with force; else the model's default load
  std::string force;    // "X,Y,Z" in N, shared by the vertices, on a face by area
  double alpha = 0.0, beta = 0.0;
  std::string damping_ratio;  // common/damping_ratios.h; empty: alpha and beta
};

// One body.
struct RunOptions : LoadedModelOptions {
  std::string name;   // the scene's table; empty: the stem of the model's file
  std::string scene;  // path of the scene; empty: none
  std::string integrator{kDefaultIntegrator};
  double step = 3e-3;
  double duration = 30.0;
  std::string load = "square";  // impulse, square, sine, chirp, ramp, constant, none
  SignalShape shape;            // of the load: --frequency, --sweep, --load-duration
  std::string signal;           // CSV of the load's course in time, instead of `load`
  double scale = 1.0;
  std::string deflect;  // "5%": the load is scaled to this motion; empty: it is not
  std::string start;    // start_state.h; empty: at rest
  double newmark_beta = 0.25, newmark_gamma = 0.5;
  std::string split = "default";
  double safety = 0.9;
  double tolerance = 1e-6;
  int max_iterations = 20;
  std::vector<std::string> probes;       // vertices or selectors whose displacement is recorded
  std::vector<std::string> coordinates;  // "I", "I-J", "all": coordinates whose q is recorded
  bool velocities = false;               // of probes and coordinates too
  std::string out;                       // directory for CSV, plots and surfaces; empty: none
  int every = 1;                         // steps per CSV row
  bool plot = false;
  int surfaces = 0;                    // surface files, evenly spaced in time
  std::string surface_format = "ply";  // ply, obj or inc
  std::string wav;                     // sound; empty: none
  int sound_steps = 1;                 // steps a sample of it; 0: as many as its modes need
  std::string save, restore;           // files of the world at the end and the start; empty: none
  std::string listen;                  // vertex or selector; empty: that of the default load
  bool hull = false;                   // of the solid's boundary, not of a render surface
};

// The contents of a scene file: one table a body, keys as the long flags; `model`, the path of the
// basis file, `signal` and a file of `start` are relative to the scene file. Errors: kContent with
// file, line and the wrong key or type.
Result<std::vector<RunOptions>> parse_scene(std::string_view text, const std::string& path);

// The flags of a command line, as parsed, and whether one, such as "--step", was given.
struct GivenFlags {
  RunOptions values;
  std::function<bool(const char*)> given;
};

// Flags that are given replace the options of the same quantity. --wav without
// --step chooses the step.
void put_over(const GivenFlags& flags, RunOptions& options);

}  // namespace tremolo

// The flags of `tremolo run` that other programs take too.

namespace CLI {
class App;
}

namespace tremolo {

// Adds the flags of a body's model (except --modes), integrator, load and start.
void add_body_flags(CLI::App& app, RunOptions& options);
// Parts of them that are those of any model.
void add_modes_flag(CLI::App& app, LoadedModelOptions& options);
void add_material_flags(CLI::App& app, LoadedModelOptions& options);
void add_damping_flags(CLI::App& app, LoadedModelOptions& options);
void add_force_flags(CLI::App& app, LoadedModelOptions& options);

}  // namespace tremolo
