// Places between points, to which a weld ties the points of another body.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace tremolo {

// A place as the sum of up to four points, each times its weight. The weights have the sum 1, so
// that the place moves with the points in any translation, and with their plane in any rotation.
struct WeldPlace {
  struct Point {
    std::size_t number = 0;
    double weight = 1.0;
  };
  std::array<Point, 4> points{};
  std::size_t count = 0;
  // From the place to the position that was asked for, m: what the points around it do not span.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  std::span<const Point> used() const { return std::span(points).first(count); }
};

// The place next to a position, between those of the points that are near it: the one point that is
// there; otherwise the foot of the position on the line, plane or space of the four nearest. Where
// a weight were above 1.5 it is the nearest point. points: not empty, m.
WeldPlace weld_place(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& position);

}  // namespace tremolo
