// Soft strands: tubes of varying radius along a smooth curve, the clay of the organic models.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "assets/recipes/shapes.h"

namespace tremolo {

// A tube about the Catmull-Rom curve through beads, flattened along y by `squash` (1 is round)
// about the plane y = squash_plane (m); squash is at most 1. distance() is negative inside and at
// most the true distance.
class Strand {
 public:
  Strand(std::initializer_list<shapes::Station> beads, double squash = 1.0,
         double squash_plane = 0.0)
      : squash_(squash), squash_plane_(squash_plane) {
    refine(std::vector<shapes::Station>(beads));
    enclose();
  }

  // Farther than `reach` (m) outside its enclosing box the distance to that box is returned, a
  // lower bound that is much cheaper; give the width of the blend that the strand takes part in.
  double distance(const Eigen::Vector3d& point, double reach) const {
    const double far = (low_ - point).cwiseMax(point - high_).cwiseMax(0.0).norm();
    if (far > reach) return far;
    Eigen::Vector3d p = point;
    p.y() = squash_plane_ + (p.y() - squash_plane_) / squash_;
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i + 1 < fine_.size(); ++i) {
      nearest = std::min(nearest, shapes::capsule(p, fine_[i].centre, fine_[i + 1].centre,
                                                  fine_[i].radius, fine_[i + 1].radius));
    }
    return nearest * squash_;
  }

 private:
  static constexpr int kPiecesPerSpan = 5;

  void refine(const std::vector<shapes::Station>& beads) {
    const auto clamped = [&](std::size_t i) { return beads[std::min(i, beads.size() - 1)]; };
    for (std::size_t i = 0; i + 1 < beads.size(); ++i) {
      const shapes::Station& a = beads[i == 0 ? 0 : i - 1];
      const shapes::Station& b = beads[i];
      const shapes::Station& c = beads[i + 1];
      const shapes::Station& d = clamped(i + 2);
      for (int k = 0; k < kPiecesPerSpan; ++k) {
        const double t = static_cast<double>(k) / kPiecesPerSpan;
        const double wa = 0.5 * t * (-1.0 + t * (2.0 - t));
        const double wb = 1.0 + 0.5 * t * t * (-5.0 + 3.0 * t);
        const double wc = 0.5 * t * (1.0 + t * (4.0 - 3.0 * t));
        const double wd = 0.5 * t * t * (t - 1.0);
        fine_.push_back({wa * a.centre + wb * b.centre + wc * c.centre + wd * d.centre,
                         wa * a.radius + wb * b.radius + wc * c.radius + wd * d.radius});
      }
    }
    fine_.push_back(beads.back());
  }

  void enclose() {
    low_ = high_ = fine_.front().centre;
    for (const shapes::Station& station : fine_) {
      const Eigen::Vector3d ball = Eigen::Vector3d::Constant(station.radius);
      low_ = low_.cwiseMin(station.centre - ball);
      high_ = high_.cwiseMax(station.centre + ball);
    }
  }

  std::vector<shapes::Station> fine_;
  double squash_;
  double squash_plane_;
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_ = Eigen::Vector3d::Zero();
};

}  // namespace tremolo
