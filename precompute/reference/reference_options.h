// Options of `tremolo-precompute reference`.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/load_signal.h"
#include "precompute/problem/problem_request.h"
#include "precompute/reference/time_integration.h"

namespace tremolo {

struct ReferenceOptions {
  ProblemRequest solid;     // mesh, materials, fixed vertices and loads
  std::string config_path;  // value of --config; empty: none
  bool statics = false;     // --static: equilibrium under the whole load
  TimeSettings time;
  double duration = 1.0;                              // s
  std::optional<std::string> load;                    // signal of the default load; none: impulse
  double scale = 1.0;                                 // factor of the default load
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2, from t = 0 on, not scaled
  std::string support_motion;  // file of the support's poses; empty: it stands
  // First motion of a free body that flies: rad/s about its centre of mass, and m/s, world.
  std::optional<Eigen::Vector3d> spin, velocity;
  double tolerance = 1e-9;
  int max_iterations = 60;
  std::vector<std::string> probes;   // vertex ids or selectors
  std::string out;                   // folder; empty: nothing is written
  int every = 1;                     // steps between recorded ones
  std::vector<std::string> compare;  // basis files to compare with
  std::optional<int> modes;          // use only their first coordinates
  bool json = false;
  std::vector<std::string> petsc_options;  // words after --
};

// Parses the words after `reference`. Returns the exit code if the program ends here (the text has
// been printed).
std::variant<ReferenceOptions, int> parse_reference_line(int count, char** words);

// Checks the ranges of all numbers. Throws Failure (kContent).
void check_reference(const ReferenceOptions& options);

// Runs the reference. Needs a PetscSession; results and JSON go to stdout, progress to stderr.
// Throws Failure.
void run_reference(const ReferenceOptions& options);

// `tremolo-precompute reference` of a body that moves through the world: its support follows a
// given motion, or it has none and flies (docs/theory.md, "The unreduced body").

// True if the options ask for it.
bool moves_in_world(const ReferenceOptions& options);

// Runs it, as run_reference. Throws Failure: kUsage for flags that exclude each other, kContent for
// a motion that does not cover the run, for a support motion of a free body, or for spin or
// velocity of a fixed one.
void run_in_world(const ReferenceOptions& options);

}  // namespace tremolo
