// The given motion of a support: poses at moments, between them a cubic spline through each
// coordinate and through the four parts of the quaternion, which is brought to length one. It is
// twice continuously differentiable, so that velocities and accelerations are continuous and the
// truth does not depend on where the moments lie; of smooth motions it misses the fourth power of
// their distance. Its slopes at the two ends are those of the cubic through the four moments there
// (fewer: the parabola, the line).
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremolo {

// A rigid motion at one moment: x = position + turn X. speed: of the position, m/s. spin: rad/s,
// along the world's axes.
struct RigidMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d speed = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();

  Eigen::Vector3d place(const Eigen::Vector3d& rest) const { return position + turn * rest; }
  // Velocity of what rides along at the place x of the world.
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const {
    return speed + spin.cross(x - position);
  }
};

class PosePath {
 public:
  // x y z (m), qw qx qy qz.
  using Row = std::array<double, 7>;

  // times: s, ascending, at least two; rows: as many. Throws Failure (kContent) otherwise, for a
  // quaternion that is not of length one to 1e-3, and for a turn of more than 90 degrees from one
  // row to the next, which a spline cannot follow.
  PosePath(std::vector<double> times, std::vector<Row> rows);

  double first() const { return times_.front(); }  // s
  double last() const { return times_.back(); }    // s
  // Before the first and after the last moment the cubics there go on.
  RigidMotion at(double time) const;

 private:
  std::vector<double> times_;
  std::vector<Row> rows_, slopes_;
};

// Reads a CSV file, a line a moment: t, x, y, z, qw, qx, qy, qz in s and m. A first line that
// begins with a letter is a head, # begins a comment. Throws Failure: kSystem if it cannot be read,
// kContent with the line if it is not such a file.
PosePath read_pose_path(const std::string& path);

}  // namespace tremolo
