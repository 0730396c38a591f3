// How the frame of a body moves: a pose for every moment, in closed form.
//
// A motion is made of parts, each a rigid map T(t) of the world onto itself; the frame that stands
// at `base` without any motion is at T_n(t) ... T_1(t) base. Courses are smooth: where something
// sets in or ends, its speed follows S(x) = x^3 (10 - 15 x + 6 x^2) over the ramp, so that
// accelerations are continuous.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/frames/pose.h"

namespace tremolo {

inline constexpr double kSinceEver = -std::numeric_limits<double>::infinity();
inline constexpr double kForEver = std::numeric_limits<double>::infinity();
// Moments that are nearer, in steps, are one.
inline constexpr double kSameTime = 1e-9;

// How far the length of a quaternion that somebody wrote down may be from 1; it is made so.
inline constexpr double kQuaternionSlack = 1e-3;

// Why a pose is none; empty if it is one.
std::string pose_problem(const Pose& pose);

// When something goes on, s: from `start`, by the ramp up to its full rate; from `end` on, by the
// ramp down to nothing. Without a start it has gone on since ever.
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

// A turn about the axis through `about`, along the world's axes, at `rate`, rad/s.
struct SpinMotion {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d about = Eigen::Vector3d::Zero();  // m
  double rate = 0.0;
  Course course;
};

// A turn to and fro about the axis through `about`, along the world's axes: amplitude sin(2 pi
// frequency (t - start) + phase), rad and Hz, within the course, which needs a start and a ramp.
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

// From rest at `start` with this acceleration, m/s^2, to `end`, and by the ramp to rest again.
struct FallMotion {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Course course;
};

struct Keyframe {
  double time = 0.0;  // s
  Pose pose;
};

// kSmooth: cubic splines with continuous accelerations that begin and end at rest; they may swing
// beyond a key. kLinear: straight lines; at the keys the speed changes at once.
enum class Interpolation { kSmooth, kLinear };

// What becomes of a time that stands twice, with two poses. kRefuse: an error that tells the
// acceleration. kSmooth: both courses are blended by S over `smooth_time`. kTeleport: the frame is
// somewhere else at once, and the body on it feels nothing.
enum class JumpRule { kRefuse, kSmooth, kTeleport };

// Poses at times that ascend; a time may stand twice. Before the first and after the last one they
// stand still. absolute: they are where the frame is in the world, whatever its base and the parts
// before this one; else they are maps of the world, so that the identity leaves the frame at its
// base.
struct KeyframeMotion {
  std::vector<Keyframe> keys;
  Interpolation interpolation = Interpolation::kSmooth;
  JumpRule jumps = JumpRule::kRefuse;
  double smooth_time = 0.1;  // s
  bool absolute = false;
};

// Accelerations, m/s^2, at times that ascend, straight lines between, integrated twice from rest.
// It goes on with the speed that it ends with.
struct RecordMotion {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> accelerations;
};

using MotionPart = std::variant<ShakeMotion, SpinMotion, SwingMotion, GlideMotion, FallMotion,
                                KeyframeMotion, RecordMotion>;

// Nothing: still.
struct Motion {
  std::vector<MotionPart> parts;
};

// Why a part is none; empty if it is one.
std::string part_problem(const MotionPart& part);

// A motion made ready to be asked for poses.
class MotionPath {
 public:
  // Errors: kContent, with the number of the part, for what part_problem() finds.
  static Result<MotionPath> create(const Motion& motion, const Pose& base = {});

  // The quaternion is of length one but for rounding. Nothing is allocated.
  Pose pose(double t) const { return pose_in(piece(t), t); }

  // Jumps of the kinds kRefuse and kTeleport cut the motion into pieces, counted from 0; a moment
  // of a jump belongs to the piece behind it. pose_in: as if the piece had no end.
  std::size_t piece(double t) const;
  Pose pose_in(std::size_t piece, double t) const;
  // Behind piece k, s, ascending.
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
  // goes_on: straight lines go on before the first key and behind the last one, instead of an end.
  static Pose at(const Segment& segment, double t, std::pair<bool, bool> goes_on = {});
  Pose part_pose(const Part& part, std::size_t piece, double t) const;
  Pose keys_pose(const Keys& keys, std::size_t piece, double t) const;

  Pose base_;
  std::vector<Part> parts_;
  std::vector<double> jumps_;
  double refused_ = kForEver;
};

}  // namespace tremolo
