// How long a body in contact has been at rest (docs/theory.md, "Sleep").
//
// At rest it is slow, and it stays in its place: a body that glides or rolls away slowly is not at
// rest, however small its speed is against its size.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"

namespace tremolo {

// Where a body is: the ball around it, and the rotation of its frame, if it has one.
struct RestPlace {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m, world
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double radius = 0.0;  // m

  // How far a point of the body may be from where it was, m.
  double way_from(const RestPlace& before) const {
    return (centre - before.centre).norm() + radius * (rotation - before.rotation).norm();
  }
};

class RestTime {
 public:
  // A body has been slow for this time, s, and has gone no farther than at this fraction of its
  // slow speed. What swings comes back to where it was, what glides does not.
  static constexpr double kQuiet = 0.5;
  static constexpr double kDrift = 1.0 / 16.0;

  bool is_over() const { return over_; }
  void restart() {
    time_ = 0.0;
    over_ = false;
  }

  // Counts a step of h, s, after which the body is at `now` and slower than `slow`, m/s.
  void count(double h, const RestPlace& now, double slow) {
    if (time_ == 0.0) place_ = now;
    time_ += h;
    over_ = time_ >= kQuiet && now.way_from(place_) <= kDrift * slow * time_;
  }

  void carry(StateStream& stream) {
    stream(time_, over_, place_.centre, place_.rotation, place_.radius);
  }

 private:
  double time_ = 0.0;  // s
  bool over_ = false;
  RestPlace place_;  // at its start
};

}  // namespace tremolo
