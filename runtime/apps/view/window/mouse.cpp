#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/apps/view/window/panel.h"

namespace tremolo {
namespace {

constexpr int kLeft = 0, kRight = 1, kMiddle = 2;  // as GLFW counts
constexpr double kTurn = std::numbers::pi;         // rad per width of the window
constexpr double kWheel = 0.88;                    // of the distance, per notch
constexpr double kSteepest = 0.495 * std::numbers::pi;

}  // namespace

void Mouse::button(int button, bool down, bool shift, double aspect) {
  if (!down) {
    if (drag_ == Drag::kPull || drag_ == Drag::kAsks) runner_.let_go();
    drag_ = Drag::kNone;
    return;
  }
  if (drag_ != Drag::kNone) return;
  if (button == kMiddle || shift)
    drag_ = Drag::kPan;
  else if (button == kRight)
    drag_ = Drag::kOrbit;
  else if (button == kLeft) {
    drag_ = Drag::kAsks;
    runner_.press(ray_through(camera_, aspect, x_, y_), firmness);
  }
}

void Mouse::update(double aspect) {
  if (drag_ != Drag::kAsks) return;
  const std::optional<bool> met = runner_.pressed();
  if (!met) return;
  drag_ = *met ? Drag::kPull : Drag::kOrbit;
  if (!*met) return;
  taken_ = runner_.grabbed_at();
  pull_to(aspect, last_event_);
}

void Mouse::move(double x, double y, double aspect) {
  const double dx = x - x_, dy = y - y_;
  x_ = x;
  y_ = y;
  last_event_ = Runner::Clock::now();
  if (drag_ == Drag::kOrbit) {
    camera_.azimuth -= kTurn * dx * aspect;
    camera_.elevation = std::clamp(camera_.elevation + kTurn * dy, -kSteepest, kSteepest);
  } else if (drag_ == Drag::kPan) {
    const CameraAxes axes = axes_of(camera_);
    const double height = 2.0 * camera_.distance * std::tan(0.5 * camera_.view_angle);
    camera_.target += height * (-dx * aspect * axes.right + dy * axes.up);
  } else if (drag_ == Drag::kPull) {
    pull_to(aspect, last_event_);
  }
}

void Mouse::pull_to(double aspect, Runner::Clock::time_point event) {
  const CameraRay ray = ray_through(camera_, aspect, x_, y_);
  const Eigen::Vector3d back = axes_of(camera_).back;
  const double along = back.dot(taken_ - ray.origin) / back.dot(ray.direction);
  runner_.pull(ray.origin + along * ray.direction - taken_, event);
}

void Mouse::wheel(double turns) {
  camera_.distance *= std::pow(kWheel, turns);
}

}  // namespace tremolo
