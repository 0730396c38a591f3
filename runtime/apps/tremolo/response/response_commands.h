// `tremolo response` and `tremolo backbone`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/apps/tremolo/run/run_options.h"

namespace tremolo {

// Flags of both commands.
struct PeriodicOptions : LoadedModelOptions {
  double static_scale = 0.0;  // the load's constant part
  std::string gravity;        // "X,Y,Z", m/s^2; empty: none
  int harmonics = 5;
  int most_harmonics = 0;  // 0: the usual ones, or `harmonics` if that is more
  double harmonic_share = 1e-3;
  double longest_step = 0.1;  // along the curve
  int most_points = 4000;
  bool no_stability = false;
  std::string probe;           // vertex or selector; empty: the vertex that moves most in the mode
  std::string csv, page, out;  // outputs; empty: none
  std::vector<std::string> orbit_files;  // a period of one motion, by their endings
  std::string orbit_at = "peak";         // orbit_file.h
  int orbit_frames = 32;                 // of a period
  double orbit_seconds = 0.0;            // that a period lasts in the files; 0: its own
  bool json = false;
};

struct ResponseOptions : PeriodicOptions {
  std::vector<std::string> load_scales = {"1"};  // each a list as in "1,2,5"
  std::vector<std::string> load_harmonics;       // "K:SCALE[:DEGREES]"; empty: 1:1
  double from = 0.0, to = 0.0;                   // Hz
  std::optional<double> folds_to;                // the folds are followed to this load scale
  bool branches = false;                         // branches at branch points are followed
  bool by_stepping = false;                      // the stable points by time stepping too
};

struct BackboneOptions : PeriodicOptions {
  int mode = 1;
  bool damped = false;               // the ridge of the response curves instead of free motion
  std::string to_amplitude = "10%";  // of the size, or a length as in 0.02m
};

void add_response_flags(CLI::App& app, ResponseOptions& options);
void add_backbone_flags(CLI::App& app, BackboneOptions& options);

// The exit code; errors are printed on stderr.
int response_command(const ResponseOptions& options);
int backbone_command(const BackboneOptions& options);

}  // namespace tremolo
