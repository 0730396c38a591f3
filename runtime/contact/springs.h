// Springs and dampers of hands, pins and joints, the same for every kind of body.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremolo {

struct HandSpring {
  double stiffness = 0.0;  // N/m
  double damping = 0.0;    // N s/m
};

// The stiffest spring that a step of h seconds solves, and its damper, for a point of that mass
// (kg): k = (30/h)^2 m. The damper makes it critical. h omega = 30 is far enough above 2, where the
// step stops a motion at once, that the spring is stiff, and low enough that it does not ring long.
inline HandSpring stiffest_spring(double mass, double h) {
  constexpr double kTurn = 30.0;
  return {kTurn * kTurn * mass / (h * h), 2.0 * kTurn * mass / h};
}

// Replaces a spring stiffer than `most` by `most`, with its damper or a larger given one. In the
// equations of a step of h seconds a damper c has the stiffness 2 c/h, which has the same limit.
inline void limit_spring(const HandSpring& most, double h, double& stiffness, double& damping) {
  if (stiffness > most.stiffness) {
    stiffness = most.stiffness;
    damping = std::max(damping, most.damping);
  }
  damping = std::min(damping, 0.5 * h * most.stiffness);
}

// A soft spring that suits a user's hand, with half of critical damping, which prevents ringing.
inline HandSpring damped_spring(double stiffness, double mass) {
  return {stiffness, std::sqrt(stiffness * mass)};
}

// Of a supported body: it follows four fifths of the hand's path under a slow pull. compliance: of
// the point, m/N. mass: that moves with the point, kg.
inline HandSpring pulling_spring(double compliance, double mass) {
  constexpr double kShareOfPath = 0.8;
  return damped_spring(kShareOfPath / (1.0 - kShareOfPath) / compliance, mass);
}

// Of a free body of that mass, kg: it swings about the hand with 2 Hz.
inline HandSpring swinging_spring(double mass) {
  constexpr double kFrequency = 2.0;
  return damped_spring(mass * std::pow(2.0 * std::numbers::pi * kFrequency, 2), mass);
}

}  // namespace tremolo
