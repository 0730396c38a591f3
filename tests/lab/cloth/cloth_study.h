// Every integrator of masses in space on one sheet: its longest stable step, its change of the
// energy, its error, its cost.
//
// The sheet, 16 x 16 particles over 0.75 m, is fixed at two corners and released from the level.
// Errors are relative to Runge and Kutta's method at a step that is a small part of the fastest
// oscillation.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_scene.h"

namespace tremolo::cloth_study {

// A sheet of so many particles along each edge. stiffness: of the structural springs, N/m; shear
// and bend are a third and a hundredth of it. damping: N s/m, of all springs. held: fixed by two
// corners.
struct SheetSpec {
  std::size_t edge = 16;
  double width = 0.75;  // m
  double stiffness = 100.0;
  double damping = 0.0;
  bool held = true;
};
SceneCloth study_sheet(const SheetSpec& spec);
// gravity: m/s^2. Throws a Failure.
ClothModel study_model(const SheetSpec& spec, const Eigen::Vector3d& gravity);

// Frames a second at which orbits are compared; steps are whole parts of a frame.
inline constexpr double kFrameRate = 30.0;

// parts: steps a frame.
struct CaseSpec {
  std::string method;
  SheetSpec sheet;
  int parts = 1;
  int frames = 15;

  double step() const { return 1.0 / (kFrameRate * parts); }
};

// positions: of each frame, 3n numbers. reached: s; why: what ended it before its time. energy:
// kinetic + elastic + gravity at the end less that at the start; damped, numerical: as NodalReport,
// J. seconds: of processor time for each simulated second.
struct StudyOrbit {
  std::vector<Eigen::VectorXd> positions;
  double reached = 0.0;
  std::string why;
  double energy = 0.0;
  double damped = 0.0;
  double numerical = 0.0;
  double seconds = 0.0;
  double iterations = 0.0;  // a step
  std::int64_t cut_steps = 0;
};

// Whatever the method makes of the step: nothing is refused.
StudyOrbit run_case(const CaseSpec& spec);

// The largest over the frames of the root mean square of particles' distances, m; infinity where
// `orbit` did not reach the end.
double distance(const StudyOrbit& orbit, const StudyOrbit& truth);

// The largest step, s, at which an undamped sheet at rest without gravity, disturbed by 1e-9 of its
// spacing, is still disturbed by less than a million times that after 4000 steps; by bisection to
// 0.1 %. predicted: stability_number / omega_max by Lanczos.
struct ObservedLimit {
  double predicted = 0.0;
  double observed = 0.0;
};
ObservedLimit find_limit(const std::string& method, const SheetSpec& spec);

}  // namespace tremolo::cloth_study
