// All runs of one start of `tremolo reproduce`, from the store or made anew.
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
struct Workshop {
  Store store;
  std::string directory;  // of the store, for checkpoints
  std::string program;
  unsigned threads = 1;
  std::vector<SampleModel> models;
  thesis::Thesis thesis = {};
  bool long_form = false;
};

// How hard the 36 runs push, times the model's default load. The thesis gives no forces.
double load_factor(std::string_view model, SignalKind load);

// "another" is the factor beside load_factor.
struct RunName {
  std::string model;
  std::string integrator;
  SignalKind load = SignalKind::kImpulse;
  double alpha = 0.0;
  double another = 1.0;
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

// Who makes the 36 runs.
inline constexpr std::array kMethods = {"imexv-thesis", "imexv", "newmark", "imexv-adaptive",
                                        "ep4"};

// The loads of the 36 runs times these, and who makes them then.
inline constexpr std::array<double, 2> kStrongLoads = {3.0, 10.0};
inline constexpr std::array kStrongMethods = {"imexv", "imexv-adaptive", "ep4"};

// The 36 runs of one method, or of those models that are there.
std::vector<RunName> the_runs(const std::vector<SampleModel>& models, const std::string& integrator,
                              double another = 1.0);

// On several threads; tells on stderr how many of `what` are done. Throws a Failure as watch_orbit
// and the store.
Orbits watch_all(const Workshop& shop, const std::vector<RunName>& runs, const std::string& what);

// On this thread alone; the methods of one model, load and damping by turns. A run is timed for the
// steps that its orbit made.
Timings time_all(const Workshop& shop, const Orbits& orbits);

}  // namespace tremolo::reproduce
