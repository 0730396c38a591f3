#include "runtime/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace tremolo {
namespace {

Status check_gravity(const SceneGravity& gravity) {
  if (gravity.values.size() > 1 && gravity.times.size() != gravity.values.size())
    return content_error("gravity: each value needs a time");
  for (std::size_t k = 0; k < gravity.values.size(); ++k) {
    if (!gravity.values[k].allFinite()) return content_error("gravity is not finite");
    if (gravity.values.size() == 1) break;
    if (!std::isfinite(gravity.times[k])) return content_error("gravity: a time is not finite");
    if (k > 0 && !(gravity.times[k - 1] < gravity.times[k]))
      return content_error("gravity: the times must ascend");
  }
  return Success{};
}

Status check_motion(const SceneBody& body) {
  if (body.motion.parts.empty()) return Success{};
  if (body.kind != FrameKind::kDriven)
    return content_error("a motion moves a driven body only: say kind = \"driven\"");
  const Result<MotionPath> path = MotionPath::create(body.motion, body.pose);
  return path ? Status(Success{}) : Status(path.error());
}

Status check_loads(const SceneBody& body) {
  for (const SceneLoad& load : body.loads) {
    if (!load.force.allFinite() || !std::isfinite(load.scale))
      return content_error("a load's force or scale is not finite");
    if (load.signal.kind != SignalKind::kTable) continue;
    const std::string problem =
        load.table ? table_problem(*load.table) : std::string("it has no table");
    if (!problem.empty()) return content_error("a load's signal: " + problem);
  }
  return Success{};
}

Status check_body(const SceneBody& body) {
  if (body.model.empty()) return content_error("it names no model");
  if (const std::string problem = pose_problem(body.pose); !problem.empty())
    return content_error(problem);
  if (!body.velocity.allFinite() || !body.spin.allFinite())
    return content_error("its velocity or spin is not finite");
  const bool free = body.kind == FrameKind::kFree;
  if (!free && !(body.velocity.isZero(0.0) && body.spin.isZero(0.0)))
    return content_error("velocity and spin are those of a free body: say kind = \"free\"");
  if (free && body.settled)
    return content_error("a free body falls: it cannot begin standing still under gravity");
  if (!(body.acceleration_limit > 0.0))
    return content_error("its acceleration-limit must be positive (m/s^2)");
  if (Status s = check_loads(body); !s) return s;
  return check_motion(body);
}

}  // namespace

Eigen::Vector3d SceneGravity::at(double t) const {
  if (values.empty()) return Eigen::Vector3d::Zero();
  if (values.size() == 1 || t <= times.front()) return values.front();
  if (t >= times.back()) return values.back();
  const auto next = std::upper_bound(times.begin(), times.end(), t);
  const auto k = static_cast<std::size_t>(next - times.begin()) - 1;
  const double share = (t - times[k]) / (times[k + 1] - times[k]);
  return values[k] + share * (values[k + 1] - values[k]);
}

Status check_scene(const Scene& scene) {
  if (!(scene.step > 0.0) || !std::isfinite(scene.step))
    return content_error("step must be positive and finite (s)");
  if (!(scene.duration > 0.0) || !std::isfinite(scene.duration))
    return content_error("duration must be positive and finite (s)");
  if (scene.duration / scene.step > 1e12)
    return content_error("duration and step ask for more than 1e12 steps");
  if (scene.duration < 0.5 * scene.step)
    return content_error("duration is shorter than half a step: nothing would be done");
  if (scene.bodies.empty()) return content_error("the scene has no body");
  if (Status s = check_gravity(scene.gravity); !s) return s;
  std::set<std::string> names;
  for (const SceneBody& body : scene.bodies) {
    if (body.name.empty()) return content_error("a body has no name");
    if (!names.insert(body.name).second)
      return content_error("two bodies are named '" + body.name + "'");
    if (Status s = check_body(body); !s)
      return Error{s.error().kind, "body '" + body.name + "': " + s.error().message};
  }
  if (!scene.colliders.empty())
    return content_error("colliders: bodies do not touch anything yet; leave them out");
  if (!scene.hands.empty())
    return content_error("hands: nothing takes hold of a body yet; leave them out");
  return Success{};
}

}  // namespace tremolo
