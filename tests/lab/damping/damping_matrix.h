// Every method under damping from none to far above critical, on a model and its own load, against
// Radau IIA (stiff_orbit.h).
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "tests/lab/report/table.h"
#include "tests/lab/samples/sample_models.h"

namespace tremolo::damping {

// Rayleigh's alpha (1/s) and beta (s). The first is no damping.
struct Rayleigh {
  double alpha = 0.0;
  double beta = 0.0;
};
inline constexpr std::array<Rayleigh, 12> kRayleigh{{{0, 0},
                                                     {0.3, 0},
                                                     {20, 0},
                                                     {200, 0},
                                                     {2000, 0},
                                                     {20000, 0},
                                                     {0, 1e-4},
                                                     {0, 1.5e-3},
                                                     {0.3, 1.5e-3},
                                                     {0, 2e-2},
                                                     {20, 2e-2},
                                                     {0, 1}}};

// A damped error may exceed the undamped one by this much, and by this share of it: where a method
// is off by a third of the motion (imexv-coupled on the tower), damping shifts its phase a little.
inline constexpr double kExcess = 0.002;
inline constexpr double kExcessShare = 0.02;

// Models that the matrix is made of.
inline constexpr std::array<std::string_view, 3> kModels{"beam", "horse", "tower"};

// error: relative L2 in the mass norm over 2 s of the model's own load as a square, at 3 ms,
// sampled every 6 ms; infinite where the run broke off.
struct Entry {
  std::string model;
  std::string method;
  Rayleigh damping;
  double error = 0.0;
  double undamped = 0.0;  // the method's error without damping

  // A method that is unstable without damping is not judged, nor is imexv-thesis, which is of first
  // order in its damping by definition.
  bool judged() const;
  bool holds() const { return !judged() || error <= undamped * (1.0 + kExcessShare) + kExcess; }
};

// All methods, in the order of integrator_names(), for each of kRayleigh. Throws a Failure as
// stiff_orbit and run_sampled.
std::vector<Entry> damping_matrix(const reproduce::SampleModel& sample);

// One row a model and a damping, one column a method.
Table to_table(const std::vector<Entry>& entries);

}  // namespace tremolo::damping
