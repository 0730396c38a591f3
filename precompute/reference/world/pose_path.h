// The given motion of a support: poses at given times, interpolated by a cubic spline through each
// coordinate and through the four parts of the quaternion, which is then normalised. It is twice
// continuously differentiable, so that velocities and accelerations are continuous and the result
// does not depend on the choice of the times; for smooth motions its error is of fourth order in
// their distance. Its slopes at the two ends are those of the cubic through the four rows there
// (fewer: the parabola, the line).
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremolo {

// A rigid motion at one time: x = position + turn X. speed: of the position, m/s. spin: rad/s,
// along the world's axes.
struct RigidMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d speed = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();

  Eigen::Vector3d place(const Eigen::Vector3d& rest) const { return position + turn * rest; }
  // Velocity of a point at x, in the world, that moves rigidly with it.
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const {
    return speed + spin.cross(x - position);
  }
};

class PosePath {
 public:
  // x y z (m), qw qx qy qz.
  using Row = std::array<double, 7>;

  // times: s, ascending, at least two; rows: as many. Throws Failure (kContent) otherwise, for a
  // quaternion whose length is not one to 1e-3, and for a rotation of more than 90 degrees from one
  // row to the next, which a spline cannot follow.
  PosePath(std::vector<double> times, std::vector<Row> rows);

  double first() const { return times_.front(); }  // s
  double last() const { return times_.back(); }    // s
  // Before the first and after the last time the cubics there are extrapolated.
  RigidMotion at(double time) const;

 private:
  std::vector<double> times_;
  std::vector<Row> rows_, slopes_;
};

// Reads a CSV file, a line per time: t, x, y, z, qw, qx, qy, qz in s and m. A first line that
// begins with a letter is a header, # begins a comment. Throws Failure: kSystem if it cannot be
// read, kContent with the line for another kind of file.
PosePath read_pose_path(const std::string& path);

}  // namespace tremolo
