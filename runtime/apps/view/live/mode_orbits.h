// The periodic motions of one mode at any amplitude, played in place of a body's state.
#pragma once

#include <atomic>
#include <functional>
#include <future>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/response/response.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

inline constexpr double kOrbitSeconds = 1.5;   // that a period lasts in the window
inline constexpr double kLargestOrbit = 0.15;  // the largest amplitude, over the body's size

// The backbone of a mode (runtime/response/backbone.h).
struct ModeOrbits {
  Eigen::Index mode = 0;  // from 0
  double size = 0.0;      // m
  double linear_hz = 0.0;
  MotionCurve curve;

  double largest() const;  // amplitude, over the size
  // The motion at an amplitude over the size; at most the largest.
  CurvePoint at(double share) const;
};

// Up to kLargestOrbit, or to where the backbone ends. stopped: asked at every point. Errors:
// kContent for a mode that the model does not have; those of backbone_curve.
Result<ModeOrbits> mode_orbits(const Model& model, Eigen::Index mode,
                               std::function<bool()> stopped = {});

// The only body of a world, whose support does not move, for an orbit in place of its state. Error
// kUsage otherwise.
Status check_orbit_world(const SceneWorld& world);

// Finds orbits on a thread of its own.
class OrbitFinder {
 public:
  ~OrbitFinder();
  // Begins; an earlier search ends. The model must outlive the search.
  void find(const Model& model, Eigen::Index mode);
  bool searches() const { return found_.valid(); }
  // The result of a search that has ended, once.
  std::optional<Result<ModeOrbits>> take_found();

 private:
  std::atomic<bool> stopped_ = false;
  std::future<Result<ModeOrbits>> found_;
};

// "MODE:AMPLITUDE" of --orbit: the mode, from 0, and the amplitude over the size, as in 1:8% or
// 2:0.05. Errors: kUsage for another form, kContent for a mode below 1 or an amplitude that is not
// in (0, kLargestOrbit].
struct OrbitRequest {
  Eigen::Index mode = 0;
  double share = 0.0;
};
Result<OrbitRequest> parse_orbit_request(const std::string& text);

}  // namespace tremolo
