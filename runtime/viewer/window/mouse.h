// Mouse control of the camera and of pulled bodies.
#pragma once

#include "runtime/viewer/live/runner.h"

namespace tremolo {

// The left button on a body pulls it, in the plane through the grabbed point that faces the camera.
// The left button elsewhere and the right button rotate the camera about its target, the middle
// button and shift move it, the wheel zooms.
class Mouse {
 public:
  Mouse(Runner& runner, Camera& camera) : runner_(runner), camera_(camera) {}

  // aspect: of the window, width over height.
  void button(int button, bool down, bool shift, double aspect);
  void move(double x, double y, double aspect);
  void wheel(double turns);
  // Call it once per picture: it finds whether the last press has hit a body.
  void update(double aspect);
  // The hand's stiffness relative to the suitable one.
  double firmness = 1.0;
  bool pulls() const { return drag_ == Drag::kPull; }

 private:
  enum class Drag { kNone, kOrbit, kPan, kAsks, kPull };
  void pull_to(double aspect, Runner::Clock::time_point event);

  Runner& runner_;
  Camera& camera_;
  Drag drag_ = Drag::kNone;
  double x_ = 0.5, y_ = 0.5;
  Eigen::Vector3d taken_ = Eigen::Vector3d::Zero();  // where the ray met the body, m
  Runner::Clock::time_point last_event_;
};

}  // namespace tremolo
