// Reference orbits, each computed by two methods that have only the potential in common.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "tests/lab/bench/scene.h"

namespace tremolo::bench {

// The gap of the two orbits, over the root mean square of |q|, up to which they count as agreeing.
inline constexpr double kAgree = 1e-5;

// An error counts while it is so many times above the gap.
inline constexpr double kAbove = 10.0;

// q: r x samples as SampledRun, by the first method. horizon: samples until which the two agree.
// gap: of the two in the norm of trajectory_error over the horizon. worst_gap: largest over the
// whole run, relative as kAgree. high_band: mean of the second half, J. trouble: why there is no
// reference; empty if there is one.
struct Reference {
  Eigen::MatrixXd q;
  Eigen::Index horizon = 0;
  double gap = 0.0;
  double worst_gap = 0.0;
  double high_band = 0.0;
  double seconds = 0.0;  // horizon, s
  std::string trouble;
};

// One of the two methods that make references.
struct ReferenceMethod {
  std::string integrator;
  double step = 0.0;  // s
  double tolerance = 0.0;
};
std::vector<ReferenceMethod> reference_methods();  // two

// Computes one orbit, or fetches it from the store. Throws a Failure as Store::get.
SampledRun reference_orbit(const Scene& scene, const ReferenceMethod& method, const Store& store);

// `one` with the horizon until which `other` agrees.
Reference compare_references(const SampledRun& one, const SampledRun& other, double sample);

// sqrt(sum |q - reference|^2 / sum |reference|^2) over the first `samples` columns, dimensionless;
// infinite if q has fewer. The basis is mass-orthonormal: this is the error in the mass norm.
double trajectory_error(const Eigen::MatrixXd& q, const Eigen::MatrixXd& reference,
                        Eigen::Index samples);

// An orbit as text that gives back every bit: 16 hexadecimal digits a number, column by column.
std::string orbit_text(const Eigen::MatrixXd& q);

// rows: of the matrix. What is not such a text gives an empty matrix.
Eigen::MatrixXd orbit_from_text(std::string_view text, Eigen::Index rows);

}  // namespace tremolo::bench
