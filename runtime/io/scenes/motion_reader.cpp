#include <cmath>
#include <numbers>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/io/scenes/part_readers.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// start, ramp, and stop, from when on it ends, or duration, when it has ended. A start that is not
// there is `usual`.
Course read_course(TomlKeys& keys, double usual, double usual_ramp) {
  Course course{usual, kForEver, usual_ramp};
  keys.read("start", course.start);
  keys.read("ramp", course.ramp);
  keys.read("stop", course.end);
  if (!keys.has("duration")) return course;
  double duration = 0.0;
  keys.read("duration", duration);
  if (keys.has("stop")) keys.fail("duration", "`stop` and `duration` say one thing: leave one out");
  if (!std::isfinite(course.start)) keys.fail("duration", "a `duration` needs a `start`");
  course.end = course.start + duration - course.ramp;
  return course;
}

ShakeMotion read_shake(TomlKeys& keys) {
  ShakeMotion shake;
  keys.read("amplitude", shake.amplitude);
  keys.read("frequency", shake.frequency);
  keys.need("amplitude", "a shake without an `amplitude`, m, does not move");
  keys.need("frequency", "a shake without a `frequency`, Hz, does not move");
  shake.course = read_course(keys, 0.0, shake.frequency > 0.0 ? 1.0 / shake.frequency : 1.0);
  return shake;
}

SpinMotion read_spin(TomlKeys& keys) {
  SpinMotion spin;
  keys.read("axis", spin.axis);
  keys.read("about", spin.about);
  keys.read("rate", spin.rate);
  keys.need("rate", "a spin without a `rate`, rad/s, does not move");
  spin.course = read_course(keys, kSinceEver, 0.5);
  return spin;
}

// Degrees become radians.
SwingMotion read_swing(TomlKeys& keys) {
  SwingMotion swing;
  constexpr double kDegree = std::numbers::pi / 180.0;
  double amplitude = 0.0, phase = 0.0;
  keys.read("axis", swing.axis);
  keys.read("about", swing.about);
  keys.read("amplitude", amplitude);
  keys.read("frequency", swing.frequency);
  keys.read("phase", phase);
  keys.need("amplitude", "a swing without an `amplitude`, degrees, does not move");
  keys.need("frequency", "a swing without a `frequency`, Hz, does not move");
  swing.amplitude = kDegree * amplitude;
  swing.phase = kDegree * phase;
  swing.course = read_course(keys, 0.0, swing.frequency > 0.0 ? 1.0 / swing.frequency : 1.0);
  return swing;
}

GlideMotion read_glide(TomlKeys& keys) {
  GlideMotion glide;
  keys.read("velocity", glide.velocity);
  keys.need("velocity", "a glide without a `velocity`, m/s, does not move");
  glide.course = read_course(keys, kSinceEver, 0.1);
  return glide;
}

FallMotion read_fall(TomlKeys& keys) {
  FallMotion fall;
  keys.read("acceleration", fall.acceleration);
  keys.need("acceleration", "a fall without an `acceleration`, m/s^2, does not move");
  fall.course = read_course(keys, 0.0, 0.01);
  return fall;
}

// t, x, y, z and maybe w, x, y, z.
Keyframe key_of(const std::vector<double>& row, double start, double scale) {
  Keyframe key;
  key.time = start + row[0];
  key.pose.position = scale * Vector3d(row[1], row[2], row[3]);
  if (row.size() == 8) key.pose.rotation = {row[4], row[5], row[6], row[7]};
  return key;
}

void read_key_rules(TomlKeys& keys, KeyframeMotion& motion) {
  constexpr Interpolation kKinds[] = {Interpolation::kSmooth, Interpolation::kLinear};
  constexpr JumpRule kRules[] = {JumpRule::kRefuse, JumpRule::kSmooth, JumpRule::kTeleport};
  motion.interpolation = kKinds[keys.read_word("interpolation", {"smooth", "linear"}, 0)];
  motion.jumps = kRules[keys.read_word("jumps", {"refuse", "smooth", "teleport"}, 0)];
  keys.read("smooth-time", motion.smooth_time);
  motion.absolute = keys.read_word("frame", {"position", "world"}, 0) == 1;
}

KeyframeMotion read_keyframes(TomlKeys& keys) {
  KeyframeMotion motion;
  read_key_rules(keys, motion);
  const toml::node* node = keys.find("keys");
  const toml::array* rows = node == nullptr ? nullptr : node->as_array();
  constexpr const char* kExpected =
      "`keys` must be a list of lists [t, x, y, z] or [t, x, y, z, qw, qx, qy, qz]";
  if (rows == nullptr) {
    keys.fail("keys", kExpected);
    return motion;
  }
  for (const toml::node& row : *rows) {
    const auto numbers = numbers_of(row);
    if (!numbers || (numbers->size() != 4 && numbers->size() != 8)) {
      keys.fail("keys", kExpected);
      return motion;
    }
    motion.keys.push_back(key_of(*numbers, 0.0, 1.0));
  }
  return motion;
}

Result<MotionPart> read_csv(TomlKeys& keys, std::vector<std::string>& files) {
  std::string file;
  double start = 0.0, scale = 1.0;
  keys.read_path("file", file);
  keys.read("start", start);
  keys.read("scale", scale);
  const bool records = keys.read_word("quantity", {"pose", "acceleration"}, 0) == 1;
  KeyframeMotion motion;
  if (!records) read_key_rules(keys, motion);
  if (file.empty()) keys.fail("file", "a motion of the kind csv needs a `file`");
  if (Status s = keys.finish(); !s) return s.error();
  files.push_back(file);
  const Result<std::string> text = read_whole_file(file);
  if (!text) return text.error();
  const auto rows =
      records ? parse_rows(*text, file, {4}, "a time and an acceleration (t, ax, ay, az)")
              : parse_rows(*text, file, {4, 8},
                           "a time and a pose (t, x, y, z or t, x, y, z, qw, qx, qy, qz)");
  if (!rows) return rows.error();
  RecordMotion record;
  for (const std::vector<double>& row : *rows) {
    if (!records) {
      motion.keys.push_back(key_of(row, start, scale));
      continue;
    }
    record.times.push_back(start + row[0]);
    record.accelerations.emplace_back(scale * Vector3d(row[1], row[2], row[3]));
  }
  MotionPart part = records ? MotionPart(std::move(record)) : MotionPart(std::move(motion));
  if (const std::string problem = part_problem(part); !problem.empty())
    return content_error(file + ": " + problem);
  return part;
}

}  // namespace

Pose read_pose(TomlKeys& keys) {
  Pose pose;
  keys.read("position", pose.position);
  if (keys.has("quaternion") && keys.has("turn"))
    keys.fail("turn", "`quaternion` and `turn` say one thing: leave one out");
  if (const std::vector<double> turn = keys.read_numbers("turn", 4, 4); turn.size() == 4) {
    const Vector3d axis(turn[0], turn[1], turn[2]);
    if (!(axis.norm() > 0.0)) keys.fail("turn", "'turn' is an axis x, y, z and degrees about it");
    pose.rotation = turn_by((turn[3] * std::numbers::pi / 180.0) * axis.normalized());
  }
  if (const std::vector<double> q = keys.read_numbers("quaternion", 4, 4); q.size() == 4) {
    pose.rotation = {q[0], q[1], q[2], q[3]};
    if (const std::string problem = pose_problem(pose); !problem.empty())
      keys.fail("quaternion", problem);
    pose.rotation.normalize();
  }
  return pose;
}

Result<MotionPart> read_motion_part(const toml::table& table, const std::string& path,
                                    const std::string& what, std::vector<std::string>& files) {
  TomlKeys keys(table, path, what);
  const std::vector<std::string_view> kinds = {"shake",     "spin", "glide", "fall",
                                               "keyframes", "csv",  "swing"};
  const std::size_t kind = keys.read_word("kind", kinds, kinds.size());
  if (!keys.has("kind"))
    keys.fail("kind", "it needs a `kind`: shake, swing, spin, glide, fall, keyframes or csv");
  if (kind == 5) return read_csv(keys, files);
  MotionPart part;
  if (kind == 0) part = read_shake(keys);
  if (kind == 1) part = read_spin(keys);
  if (kind == 2) part = read_glide(keys);
  if (kind == 3) part = read_fall(keys);
  if (kind == 4) part = read_keyframes(keys);
  if (kind == 6) part = read_swing(keys);
  if (keys.good())
    if (const std::string problem = part_problem(part); !problem.empty()) keys.fail("", problem);
  if (Status s = keys.finish(); !s) return s.error();
  return part;
}

Result<Motion> read_motion(TomlKeys& keys, const std::string& path, const std::string& what,
                           std::vector<std::string>& files, bool placed) {
  Motion motion;
  for (const toml::table* entry : keys.read_tables("motion")) {
    Result<MotionPart> part = read_motion_part(*entry, path, what + ", motion", files);
    if (!part) return part.error();
    const auto* keyframes = std::get_if<KeyframeMotion>(&*part);
    if (keyframes != nullptr && keyframes->absolute && !placed)
      keys.fail(
          "motion",
          "`frame = \"world\"` applies only to a body, a collider or a ball: without a pose the "
          "keyframes are relative to the position");
    motion.parts.push_back(std::move(*part));
  }
  return motion;
}

}  // namespace tremolo
