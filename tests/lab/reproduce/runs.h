// All runs of one start of `tremolo reproduce`, from the store or made again.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tests/lab/reproduce/orbit.h"
#include "tests/lab/samples/sample_models.h"
#include "tests/lab/samples/thesis.h"
#include "tests/lab/work/store.h"

namespace tremolo::reproduce {

// program: a checksum of the running program; results of another build are not used.
struct Session {
  Store store;
  std::string directory;  // of the store, for checkpoints
  std::string program;
  unsigned threads = 1;
  std::vector<SampleModel> models;
  thesis::Thesis thesis = {};
  bool long_form = false;
};

// The factor of the model's default load in the 36 runs. The thesis gives no forces.
double load_factor(std::string_view model, SignalKind load);

// load_multiple: a further factor of the load, besides load_factor.
struct RunName {
  std::string model;
  std::string integrator;
  SignalKind load = SignalKind::kImpulse;
  double alpha = 0.0;
  double load_multiple = 1.0;
  double step = 3e-3;
  double duration = 30.0;

  // As the store's file is called: "beam-sine-a0.3-imexv", "-x3", "-h5ms", "-1s".
  std::string text() const;
};

// Seconds of step() alone, the smallest of three, and for how many steps.
struct Timing {
  double seconds = 0.0;
  std::int64_t steps = 0;
  double per_step() const { return seconds / static_cast<double>(steps); }
};

using Orbits = std::map<std::string, Orbit>;    // by RunName::text()
using Timings = std::map<std::string, Timing>;  // the same

// The methods of the 36 runs.
inline constexpr std::array kMethods = {"imexv-thesis", "imexv", "newmark", "imexv-adaptive",
                                        "ep4"};

// The load multiples of the stronger runs, and their methods.
inline constexpr std::array<double, 2> kStrongLoads = {3.0, 10.0};
inline constexpr std::array kStrongMethods = {"imexv", "imexv-adaptive", "ep4"};

// The 36 runs of one method; fewer where not all models are given.
std::vector<RunName> thesis_runs(const std::vector<SampleModel>& models,
                                 const std::string& integrator, double load_multiple = 1.0);

// Runs on several threads and prints on stderr how many of `what` are done. Throws a Failure as
// run_orbit and the store.
Orbits run_all(const Session& session, const std::vector<RunName>& runs, const std::string& what);

// Runs on this thread alone; the methods take turns within one model, load and damping. A run is
// timed over the steps that its orbit made.
Timings time_all(const Session& session, const Orbits& orbits);

}  // namespace tremolo::reproduce
