#include "runtime/math/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "common/text.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Vector7d = Eigen::Matrix<double, 7, 1>;

// S and its integral from 0.
double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10.0 + x * (6.0 * x - 15.0));
}
double smooth_step_integral(double x) {
  if (x >= 1.0) return x - 0.5;
  x = std::max(x, 0.0);
  return x * x * x * x * (2.5 + x * (x - 3.0));
}

// The integral of S((t - from)/ramp), or of the step that it is without a ramp, s.
double ramp_path(double t, double from, double ramp) {
  if (!(t > from)) return 0.0;
  return ramp > 0.0 ? ramp * smooth_step_integral((t - from) / ramp) : t - from;
}
double ramp_rate(double t, double from, double ramp) {
  if (ramp > 0.0) return smooth_step((t - from) / ramp);
  return t >= from ? 1.0 : 0.0;
}

Pose shifted(const Vector3d& by) {
  return {by, Eigen::Quaterniond::Identity()};
}

Pose pose_of(const ShakeMotion& shake, double t) {
  const double phase = 2.0 * std::numbers::pi * shake.frequency * (t - shake.course.start);
  const double rate = shake.course.rate(t);
  return shifted(rate == 0.0 ? Vector3d(Vector3d::Zero())
                             : Vector3d((rate * std::sin(phase)) * shake.amplitude));
}

Pose pose_of(const SpinMotion& spin, double t) {
  const Eigen::Quaterniond turn =
      turn_by((spin.rate * spin.course.path(t)) * spin.axis.normalized());
  return {spin.about - turn * spin.about, turn};
}

Pose pose_of(const SwingMotion& swing, double t) {
  const double phase =
      2.0 * std::numbers::pi * swing.frequency * (t - swing.course.start) + swing.phase;
  const Eigen::Quaterniond turn =
      turn_by((swing.amplitude * swing.course.rate(t) * std::sin(phase)) * swing.axis.normalized());
  return {swing.about - turn * swing.about, turn};
}

Pose pose_of(const GlideMotion& glide, double t) {
  return shifted(glide.course.path(t) * glide.velocity);
}

Pose pose_of(const FallMotion& fall, double t) {
  const Course& course = fall.course;
  const double fallen = std::max(0.0, std::min(t, course.end) - course.start);
  double path = 0.5 * fallen * fallen;
  if (t > course.end) {
    const double speed = course.end - course.start;
    path += speed * (t - course.end - ramp_path(t, course.end, course.ramp));
  }
  return shifted(path * fall.acceleration);
}

// The numbers of a pose: position, then quaternion.
Vector7d numbers_of(const Pose& pose) {
  Vector7d numbers;
  numbers << pose.position, pose.rotation.coeffs();
  return numbers;
}
Pose pose_from(const Vector7d& numbers) {
  Eigen::Quaterniond rotation;
  rotation.coeffs() = numbers.tail<4>().normalized();
  return {numbers.head<3>(), rotation};
}

Pose blend(const Pose& a, const Pose& b, double share) {
  return {a.position + share * (b.position - a.position), a.rotation.slerp(share, b.rotation)};
}

std::string course_problem(const Course& course) {
  if (std::isnan(course.start) || std::isnan(course.end) || !std::isfinite(course.ramp) ||
      course.ramp < 0.0)
    return "its start, end and ramp are times in s, the ramp not negative";
  if (!(course.start + course.ramp <= course.end))
    return "it ends before its ramp has led it up to its rate";
  return {};
}

std::string times_problem(const std::vector<double>& times, int most) {
  for (std::size_t k = 0; k < times.size(); ++k) {
    const std::string moment = "moment " + std::to_string(k + 1);
    if (!std::isfinite(times[k])) return "the time of " + moment + " is not finite";
    if (k > 0 && times[k] < times[k - 1]) return moment + " is earlier than the one before it";
    const std::size_t behind = most;
    if (k >= behind && times[k] == times[k - behind])
      return moment + " stands at the time of " + (most == 1 ? "the one" : "two") + " before it";
  }
  return {};
}

std::string problem_of(const ShakeMotion& shake) {
  if (!shake.amplitude.allFinite()) return "its amplitude is not finite";
  if (!(shake.frequency > 0.0) || !std::isfinite(shake.frequency))
    return "its frequency must be positive and finite (Hz)";
  if (!std::isfinite(shake.course.start) || !(shake.course.ramp > 0.0))
    return "a shake needs a start and a ramp above zero";
  return course_problem(shake.course);
}

std::string problem_of(const SpinMotion& spin) {
  if (!spin.axis.allFinite() || !(spin.axis.norm() > 0.0)) return "its axis has no direction";
  if (!spin.about.allFinite() || !std::isfinite(spin.rate)) return "its rate is not finite";
  return course_problem(spin.course);
}

std::string problem_of(const SwingMotion& swing) {
  if (!swing.axis.allFinite() || !(swing.axis.norm() > 0.0)) return "its axis has no direction";
  if (!swing.about.allFinite() || !std::isfinite(swing.amplitude) || !std::isfinite(swing.phase))
    return "its amplitude, phase or the point that it swings about is not finite";
  if (!(swing.frequency > 0.0) || !std::isfinite(swing.frequency))
    return "its frequency must be positive and finite (Hz)";
  if (!std::isfinite(swing.course.start) || !(swing.course.ramp > 0.0))
    return "a swing needs a start and a ramp above zero";
  return course_problem(swing.course);
}

std::string problem_of(const GlideMotion& glide) {
  if (!glide.velocity.allFinite()) return "its velocity is not finite";
  return course_problem(glide.course);
}

std::string problem_of(const FallMotion& fall) {
  if (!fall.acceleration.allFinite()) return "its acceleration is not finite";
  if (!std::isfinite(fall.course.start)) return "a fall needs a start";
  if (!(fall.course.start <= fall.course.end)) return "it ends before it starts";
  return course_problem({fall.course.start, kForEver, fall.course.ramp});
}

std::string problem_of(const KeyframeMotion& motion) {
  if (motion.keys.empty()) return "it has no keys";
  if (!(motion.smooth_time > 0.0) || !std::isfinite(motion.smooth_time))
    return "its smooth-time must be positive and finite (s)";
  std::vector<double> times;
  for (std::size_t k = 0; k < motion.keys.size(); ++k) {
    const Keyframe& key = motion.keys[k];
    times.push_back(key.time);
    if (std::string problem = pose_problem(key.pose); !problem.empty())
      return "key " + std::to_string(k + 1) + ": " + problem;
  }
  return times_problem(times, 2);
}

std::string problem_of(const RecordMotion& motion) {
  if (motion.times.size() < 2 || motion.times.size() != motion.accelerations.size())
    return "it has no two moments";
  for (std::size_t k = 0; k < motion.times.size(); ++k)
    if (!motion.accelerations[k].allFinite())
      return "the acceleration of moment " + std::to_string(k + 1) + " is not finite";
  return times_problem(motion.times, 1);
}

}  // namespace

std::string pose_problem(const Pose& pose) {
  if (!pose.position.allFinite() || !pose.rotation.coeffs().allFinite())
    return "the pose is not finite";
  const double length = pose.rotation.norm();
  if (!(std::abs(length - 1.0) <= kQuaternionSlack))
    return "the quaternion is of length " + number_text(length) + ", must be 1";
  return {};
}

double Course::rate(double t) const {
  const double up = std::isfinite(start) ? ramp_rate(t, start, ramp) : 1.0;
  return std::isfinite(end) ? up * (1.0 - ramp_rate(t, end, ramp)) : up;
}

double Course::path(double t) const {
  const double up = std::isfinite(start) ? ramp_path(t, start, ramp) : t;
  return std::isfinite(end) ? up - ramp_path(t, end, ramp) : up;
}

std::string part_problem(const MotionPart& part) {
  return std::visit([](const auto& known) { return problem_of(known); }, part);
}

// A clamped cubic spline: slopes of zero at both ends, and second derivatives without a jump
// between, by elimination in the tridiagonal system
//   m_{k-1}/h_{k-1} + 2 m_k (1/h_{k-1} + 1/h_k) + m_{k+1}/h_k
//     = 3 (y_k - y_{k-1})/h_{k-1}^2 + 3 (y_{k+1} - y_k)/h_k^2.
// Straight lines have no slopes.
void MotionPath::find_slopes(Segment& segment, Interpolation interpolation) {
  const std::size_t n = segment.times.size();
  if (interpolation == Interpolation::kLinear) return;
  segment.slopes.assign(n, Vector7d::Zero());
  std::vector<double> reduced(n, 0.0);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double a = 1.0 / (segment.times[k] - segment.times[k - 1]);
    const double b = 1.0 / (segment.times[k + 1] - segment.times[k]);
    const Vector7d right = 3.0 * a * a * (segment.values[k] - segment.values[k - 1]) +
                           3.0 * b * b * (segment.values[k + 1] - segment.values[k]);
    const double pivot = 2.0 * (a + b) - a * reduced[k - 1];
    reduced[k] = b / pivot;
    segment.slopes[k] = (right - a * segment.slopes[k - 1]) / pivot;
  }
  for (std::size_t k = n - 1; k-- > 1;) segment.slopes[k] -= reduced[k] * segment.slopes[k + 1];
}

MotionPath::Keys MotionPath::make_keys(const KeyframeMotion& motion) {
  Keys keys{{}, motion.jumps, motion.smooth_time, motion.absolute};
  for (const Keyframe& key : motion.keys) {
    if (keys.segments.empty() || keys.segments.back().times.back() == key.time)
      keys.segments.emplace_back();
    Segment& segment = keys.segments.back();
    Vector7d numbers = numbers_of({key.pose.position, key.pose.rotation.normalized()});
    // A quaternion and its negative are one rotation: the nearer one is chosen.
    if (!segment.values.empty() && segment.values.back().tail<4>().dot(numbers.tail<4>()) < 0.0)
      numbers.tail<4>() *= -1.0;
    segment.times.push_back(key.time);
    segment.values.push_back(numbers);
  }
  for (Segment& segment : keys.segments) find_slopes(segment, motion.interpolation);
  return keys;
}

MotionPath::Record MotionPath::make_record(const RecordMotion& motion) {
  Record record{motion.times, motion.accelerations, {}, {}};
  Vector3d velocity = Vector3d::Zero(), place = Vector3d::Zero();
  for (std::size_t k = 0; k < motion.times.size(); ++k) {
    record.velocities.push_back(velocity);
    record.places.push_back(place);
    if (k + 1 == motion.times.size()) break;
    const double h = motion.times[k + 1] - motion.times[k];
    const Vector3d &a = motion.accelerations[k], &b = motion.accelerations[k + 1];
    place += h * velocity + (h * h / 6.0) * (2.0 * a + b);
    velocity += (0.5 * h) * (a + b);
  }
  return record;
}

Result<MotionPath> MotionPath::create(const Motion& motion, const Pose& base) {
  MotionPath path;
  path.base_ = base;
  for (std::size_t i = 0; i < motion.parts.size(); ++i) {
    const MotionPart& part = motion.parts[i];
    if (std::string problem = part_problem(part); !problem.empty())
      return content_error("part " + std::to_string(i + 1) + " of the motion: " + problem);
    std::visit(
        [&path](const auto& known) {
          using Kind = std::decay_t<decltype(known)>;
          if constexpr (std::is_same_v<Kind, KeyframeMotion>)
            path.parts_.emplace_back(make_keys(known));
          else if constexpr (std::is_same_v<Kind, RecordMotion>)
            path.parts_.emplace_back(make_record(known));
          else
            path.parts_.emplace_back(known);
        },
        part);
    const auto* keys = std::get_if<Keys>(&path.parts_.back());
    if (keys == nullptr || keys->jumps == JumpRule::kSmooth) continue;
    for (std::size_t k = 1; k < keys->segments.size(); ++k) {
      const double jump = keys->segments[k].times.front();
      path.jumps_.push_back(jump);
      if (keys->jumps == JumpRule::kRefuse) path.refused_ = std::min(path.refused_, jump);
    }
  }
  std::sort(path.jumps_.begin(), path.jumps_.end());
  path.jumps_.erase(std::unique(path.jumps_.begin(), path.jumps_.end()), path.jumps_.end());
  return path;
}

std::size_t MotionPath::piece(double t) const {
  return static_cast<std::size_t>(std::upper_bound(jumps_.begin(), jumps_.end(), t) -
                                  jumps_.begin());
}

Pose MotionPath::at(const Segment& segment, double t, std::pair<bool, bool> goes_on) {
  const std::vector<double>& times = segment.times;
  const bool lines = segment.slopes.empty() && times.size() > 1;
  if (t <= times.front() && !(lines && goes_on.first)) return pose_from(segment.values.front());
  if (t >= times.back() && !(lines && goes_on.second)) return pose_from(segment.values.back());
  const auto next = std::upper_bound(times.begin() + 1, times.end() - 1, t);
  const auto k = static_cast<std::size_t>(next - times.begin()) - 1;
  const double h = times[k + 1] - times[k], x = (t - times[k]) / h;
  if (segment.slopes.empty())
    return blend(pose_from(segment.values[k]), pose_from(segment.values[k + 1]), x);
  const double y = 1.0 - x;
  return pose_from(y * y * (1.0 + 2.0 * x) * segment.values[k] +
                   x * x * (3.0 - 2.0 * x) * segment.values[k + 1] +
                   h * x * y * (y * segment.slopes[k] - x * segment.slopes[k + 1]));
}

Pose MotionPath::keys_pose(const Keys& keys, std::size_t piece, double t) const {
  const std::vector<Segment>& segments = keys.segments;
  const bool cut = keys.jumps != JumpRule::kSmooth;
  // The time that selects the segment: for a motion with jumps the start of the piece.
  const double moment = !cut ? t : piece == 0 ? kSinceEver : jumps_[piece - 1];
  std::size_t k = 0;
  while (k + 1 < segments.size() && segments[k + 1].times.front() <= moment) ++k;
  if (cut) return at(segments[k], t, {k > 0, k + 1 < segments.size()});
  const double half = 0.5 * keys.smooth_time;
  if (k + 1 < segments.size() && t > segments[k + 1].times.front() - half)
    return blend(at(segments[k], t), at(segments[k + 1], t),
                 smooth_step(0.5 + (t - segments[k + 1].times.front()) / keys.smooth_time));
  if (k > 0 && t < segments[k].times.front() + half)
    return blend(at(segments[k - 1], t), at(segments[k], t),
                 smooth_step(0.5 + (t - segments[k].times.front()) / keys.smooth_time));
  return at(segments[k], t);
}

Pose MotionPath::part_pose(const Part& part, std::size_t piece, double t) const {
  if (const auto* keys = std::get_if<Keys>(&part)) return keys_pose(*keys, piece, t);
  if (const auto* record = std::get_if<Record>(&part)) {
    const std::vector<double>& times = record->times;
    if (t <= times.front()) return {};
    const auto next = std::upper_bound(times.begin(), times.end(), t);
    const auto k = static_cast<std::size_t>(next - times.begin()) - 1;
    const double s = t - times[k];
    Vector3d place = record->places[k] + s * record->velocities[k];
    if (next == times.end()) return shifted(place);
    const Vector3d &a = record->accelerations[k], &b = record->accelerations[k + 1];
    place += (s * s / 6.0) * (3.0 * a + (s / (times[k + 1] - times[k])) * (b - a));
    return shifted(place);
  }
  if (const auto* shake = std::get_if<ShakeMotion>(&part)) return pose_of(*shake, t);
  if (const auto* spin = std::get_if<SpinMotion>(&part)) return pose_of(*spin, t);
  if (const auto* swing = std::get_if<SwingMotion>(&part)) return pose_of(*swing, t);
  if (const auto* glide = std::get_if<GlideMotion>(&part)) return pose_of(*glide, t);
  return pose_of(std::get<FallMotion>(part), t);
}

Pose MotionPath::pose_in(std::size_t piece, double t) const {
  Pose pose = base_;
  for (const Part& part : parts_) {
    const Pose map = part_pose(part, piece, t);
    if (const auto* keys = std::get_if<Keys>(&part); keys != nullptr && keys->absolute) {
      pose = {map.position, map.rotation.normalized()};
      continue;
    }
    pose = {map * pose.position, (map.rotation * pose.rotation).normalized()};
  }
  return pose;
}

}  // namespace tremolo
