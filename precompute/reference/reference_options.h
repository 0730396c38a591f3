// `tremolo-precompute reference`: what it is asked for.
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
  ProblemRequest solid;     // the mesh and what is on it
  std::string config_path;  // of --config; empty: none
  bool statics = false;     // --static: equilibrium under the whole load
  TimeSettings time;
  double duration = 1.0;                              // s
  std::optional<std::string> load;                    // of the default load; impulse
  double scale = 1.0;                                 // of the default load
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2, from t = 0 on, not scaled
  double tolerance = 1e-9;
  int max_iterations = 60;
  std::vector<std::string> probes;   // vertex ids or selectors
  std::string out;                   // folder; empty: nothing is written
  int every = 1;                     // step that is recorded
  std::vector<std::string> compare;  // basis files
  std::optional<int> modes;          // their first coordinates
  bool json = false;
  std::vector<std::string> petsc_options;  // what stood behind --
};

// The command line behind the word `reference`, or the exit code when there is nothing more to do
// (the text has been printed).
std::variant<ReferenceOptions, int> parse_reference_line(int count, char** words);

// Numbers within their ranges. Throws Failure (kContent).
void check_reference(const ReferenceOptions& options);

// Does it all: needs a PetscSession; results and JSON go to stdout, progress to stderr. Throws
// Failure.
void run_reference(const ReferenceOptions& options);

}  // namespace tremolo
