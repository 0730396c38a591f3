// Values that are finite but so large that energies and momenta, which have products of them,
// overflow.
#pragma once

#include <cmath>
#include <string>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "common/result.h"
#include "common/text.h"

namespace tremolo {

// True if the square of a value is no finite number.
inline bool overflows(double value) {
  return !std::isfinite(value * value);
}

// The end of a message about such a value.
inline constexpr const char* kOverflows = "so large that numbers overflow: make it smaller";

// "velocity is 1e+200 m/s, so large that numbers overflow: make it smaller"
inline std::string overflow_text(const std::string& name, double value, const char* unit) {
  return name + " is " + number_text(value) + (*unit == '\0' ? "" : " ") + unit + ", " + kOverflows;
}

// kContent if the value overflows. unit: may be empty.
inline Status check_size(const std::string& name, double value, const char* unit) {
  if (!overflows(value)) return Success{};
  return content_error(overflow_text(name, value, unit));
}

// kContent for values of a start, or of a load, whose squares overflow.
inline Status check_start_size(const Eigen::Vector3d& position, const Eigen::Vector3d& velocity,
                               const Eigen::Vector3d& spin) {
  if (Status s = check_size("its position", position.lpNorm<Eigen::Infinity>(), "m"); !s) return s;
  if (Status s = check_size("its velocity", velocity.lpNorm<Eigen::Infinity>(), "m/s"); !s)
    return s;
  return check_size("its spin", spin.lpNorm<Eigen::Infinity>(), "rad/s");
}
inline Status check_signal_size(const Signal& signal) {
  for (const double frequency : {signal.frequency, signal.last_frequency})
    if (Status s = check_size("a load's frequency", frequency, "Hz"); !s) return s;
  return Success{};
}

// kContent for a step whose square, or that of whose inverse, is no finite number. step: s.
inline Status check_step_size(double step) {
  if (!overflows(step) && !overflows(1.0 / step)) return Success{};
  return content_error("step is " + number_text(step) +
                       " s, so large or small that numbers overflow: take one that resolves the "
                       "motion");
}

// A body as a whole.
struct BodyScale {
  double mass = 0.0;       // kg
  double reach = 0.0;      // of its farthest point from the world's origin, m
  double speed = 0.0;      // of its fastest point, m/s
  double gravity = 0.0;    // m/s^2
  double stiffness = 0.0;  // of its contact or springs, N/m
  double step = 0.0;       // s
};

// kContent if energies, momenta or the way of a step of the body overflow.
inline Status check_scale(const BodyScale& body) {
  const auto problem = [](const std::string& what, const std::string& of) {
    return content_error("its " + what + " is not finite: its " + of + " are " +
                         "so large that numbers overflow: make them smaller");
  };
  const double inertia = body.mass * body.reach * body.reach;
  if (!std::isfinite(inertia)) return problem("inertia", "mass and its distance from the origin");
  if (!std::isfinite(body.mass * body.speed * body.speed))
    return problem("kinetic energy", "mass and its velocity");
  if (!std::isfinite(body.mass * body.speed * body.reach))
    return problem("angular momentum", "mass, its velocity and its distance from the origin");
  if (!std::isfinite(body.mass * body.gravity * body.reach))
    return problem("energy of gravity", "mass and the gravity");
  if (!std::isfinite(body.stiffness * body.reach * body.reach))
    return problem("elastic energy", "stiffness and its distance from the origin");
  const double way = body.step * body.speed;
  if (overflows(way)) return problem("way in a step", "velocity and the step");
  return Success{};
}

}  // namespace tremolo
