// Balls around bodies, and which of them meet: a sweep along the axis along which they are spread
// the most, so that many bodies are not compared each with each.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

class NearBalls {
 public:
  void clear();
  // body: its number. centre, radius: m.
  void add(std::size_t body, const Eigen::Vector3d& centre, double radius);
  // After the last ball.
  void sort();

  // The other bodies whose balls overlap that of `body`, ascending; none for a body without a ball.
  // Valid until the next call.
  std::span<const std::size_t> of(std::size_t body);

 private:
  struct Ball {
    std::size_t body;
    Eigen::Vector3d centre;
    double radius;
  };

  std::vector<Ball> balls_;
  std::vector<std::size_t> at_;  // where a body's ball is in balls_, and one more; 0: it has none
  std::vector<std::size_t> found_;  // of the last call
  Eigen::Index axis_ = 0;
  double largest_ = 0.0;  // radius, m
};

}  // namespace tremolo
