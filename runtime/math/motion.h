// Motion of a body's frame: its pose at every time, in closed form.
//
// A motion consists of parts, each a rigid map T(t) of the world onto itself; a frame whose pose
// without motion is `base` is at T_n(t) ... T_1(t) base. Motions are smooth: where a part begins or
// ends, its speed follows S(x) = x^3 (10 - 15 x + 6 x^2) over the ramp, so that accelerations are
// continuous.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/pose.h"

namespace tremolo {

inline constexpr double kSinceEver = -std::numeric_limits<double>::infinity();
inline constexpr double kForEver = std::numeric_limits<double>::infinity();
// Times closer than this, in steps, are equal.
inline constexpr double kSameTime = 1e-9;

// Tolerance for the length of a given quaternion; within it the quaternion is normalised.
inline constexpr double kQuaternionSlack = 1e-3;

// The reason why a pose is not valid; empty if it is.
std::string pose_problem(const Pose& pose);

// The time span of a part, s: it starts at `start`, reaches its full rate after `ramp`, and from
// `end` on its rate falls to zero within `ramp`. Without a start it has always been active.
struct Course {
  double start = kSinceEver;
  double end = kForEver;
  double ramp = 0.0;

  // In [0, 1].
  double rate(double t) const;
  // The integral of the rate since `start`, or since 0 if there is none, s.
  double path(double t) const;
};

// amplitude sin(2 pi frequency (t - start)), m and Hz, within the course, which needs a start and a
// ramp.
struct ShakeMotion {
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();
  double frequency = 1.0;
  Course course;
};

// A rotation about the axis through `about`, along the world's axes, at `rate`, rad/s.
struct SpinMotion {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  // m
  double rate = 0.0;
  Course course;
};

// An oscillating rotation about the axis through `about`, along the world's axes: amplitude sin(2
// pi frequency (t - start) + phase), rad and Hz, within the course, which needs a start and a ramp.
struct SwingMotion {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  // m
  double amplitude = 0.0;
  double frequency = 1.0;
  double phase = 0.0;
  Course course;
};

// m/s, along the world's axes.
struct GlideMotion {
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Course course;
};

// Moves from rest at `start` with this acceleration, m/s^2, until `end`, and then comes to rest
// within the ramp.
struct FallMotion {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Course course;
};

struct Keyframe {
  double time = 0.0;  // s
  Pose pose;
};

// kSmooth: cubic splines with continuous accelerations that begin and end at rest; they may
// overshoot a key. kLinear: linear interpolation; at the keys the speed changes at once.
enum class Interpolation { kSmooth, kLinear };

// Treatment of a time that is listed twice, with two poses. kRefuse: an error that gives the
// acceleration. kSmooth: S blends both courses over `smooth_time`. kTeleport: the frame changes its
// position at once, without any force on the body.
enum class JumpRule { kRefuse, kSmooth, kTeleport };

// Poses at ascending times; a time may be listed twice. Before the first and after the last one the
// frame is at rest.
struct KeyframeMotion {
  std::vector<Keyframe> keys;
  Interpolation interpolation = Interpolation::kSmooth;
  JumpRule jumps = JumpRule::kRefuse;
  double smooth_time = 0.1;  // s
  // True: the poses are the frame's in the world, whatever its base and the parts before this one.
  // False: they are maps of the world; the identity leaves the frame at its base.
  bool absolute = false;
};

// Accelerations, m/s^2, at ascending times, interpolated linearly and integrated twice from rest.
// After the last one the speed is constant.
struct RecordMotion {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> accelerations;
};

using MotionPart = std::variant<ShakeMotion, SpinMotion, SwingMotion, GlideMotion, FallMotion,
                                KeyframeMotion, RecordMotion>;

// A sequence of parts; empty: at rest.
struct Motion {
  std::vector<MotionPart> parts;
};

// The reason why a part is not valid; empty if it is.
std::string part_problem(const MotionPart& part);

// A motion prepared for the evaluation of poses.
class MotionPath {
 public:
  // Errors: kContent, with the number of the part, if part_problem() finds one.
  static Result<MotionPath> create(const Motion& motion, const Pose& base = {});

  // The quaternion is of unit length up to rounding. Allocates nothing.
  Pose pose(double t) const { return pose_in(piece(t), t); }

  // Jumps of the kinds kRefuse and kTeleport divide the motion into pieces, counted from 0; the
  // time of a jump belongs to the piece after it. pose_in: extends the piece beyond its ends.
  std::size_t piece(double t) const;
  Pose pose_in(std::size_t piece, double t) const;
  // The end of each piece but the last, s, ascending.
  const std::vector<double>& jumps() const { return jumps_; }
  // The first jump of the kind kRefuse, else kForEver.
  double refused_jump() const { return refused_; }
  bool still() const { return parts_.empty(); }

 private:
  // Positions and quaternions between two jumps, 7 numbers a key, and their slopes.
  struct Segment {
    std::vector<double> times;
    std::vector<Eigen::Matrix<double, 7, 1>> values, slopes;
  };
  struct Keys {
    std::vector<Segment> segments;
    JumpRule jumps = JumpRule::kRefuse;
    double smooth_time = 0.0;
    bool absolute = false;
  };
  struct Record {
    std::vector<double> times;
    std::vector<Eigen::Vector3d> accelerations, velocities, places;
  };
  using Part =
      std::variant<ShakeMotion, SpinMotion, SwingMotion, GlideMotion, FallMotion, Keys, Record>;

  static Keys make_keys(const KeyframeMotion& motion);
  static void find_slopes(Segment& segment, Interpolation interpolation);
  static Record make_record(const RecordMotion& motion);
  // goes_on: extrapolate linearly before the first key and after the last one.
  static Pose at(const Segment& segment, double t, std::pair<bool, bool> goes_on = {});
  Pose part_pose(const Part& part, std::size_t piece, double t) const;
  Pose keys_pose(const Keys& keys, std::size_t piece, double t) const;

  Pose base_;
  std::vector<Part> parts_;
  std::vector<double> jumps_;
  double refused_ = kForEver;
};

}  // namespace tremolo
