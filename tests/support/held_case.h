// A fixed cloud in motion and with damping, for the tests of driven frames and of bones, and the
// observed order of a method against Newton's laws.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>

#include "tests/support/dynamics.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo::testing {

inline constexpr const char* kDrivenMethods[] = {"avf", "ep2", "ep4", "newmark", "imexv"};

struct HeldCase {
  static constexpr double kTime = 0.48;  // s

  StrainModel strain = random_strain_model(spread_omega(4, 14.0, 60.0), 0.2, 3);
  PointCloud cloud = random_cloud(4, false, 3);
  Model::Pointer model = *Model::from_data(basis_of(cloud, strain, false));
  State start{random_vector(4, 0.02, 8), random_vector(4, 0.3, 9)};

  // Damping force of alpha and beta of held_options(): beta acts on the rates of strains.
  Eigen::VectorXd damping(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const {
    return 0.3 * v + 1e-3 * strain_damping_force(strain, q, v);
  }
};

// Steps through kTime; the solver's tolerance does not show.
inline IntegratorOptions held_options(int steps) {
  return {.step = HeldCase::kTime / steps,
          .alpha = 0.3,
          .beta = 1e-3,
          .tolerance = 1e-11,
          .max_iterations = 60};
}

// end(steps): q after kTime, in so many steps. exact: the same by Newton's laws.
template <class End>
void expect_second_order(const char* method, const Eigen::VectorXd& exact, const End& end) {
  std::array<double, 3> errors{};
  for (std::size_t k = 0; k < errors.size(); ++k)
    errors[k] = (end(120 << k) - exact).norm() / exact.norm();
  std::printf("%-8s errors %.2e %.2e %.2e\n", method, errors[0], errors[1], errors[2]);
  EXPECT_LE(errors[2], 1e-3) << method;
  EXPECT_GE(std::log2(errors[0] / errors[2]) / 2.0, 1.75) << method;
}

}  // namespace tremolo::testing
