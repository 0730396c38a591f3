#include "runtime/apps/tremolo/output/scene_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include <fmt/format.h>

#include "common/mesh/tet_mesh.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNearContact = 0.01;  // of a body's size: closer things are listed

// The least distance of the body's vertices from the collider, m.
double distance_to(const PlacedBody& body, const NamedCollider& collider) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& x : body.surface) {
    const Eigen::Vector3d place = collider.pose.rotation.conjugate() * (x - collider.pose.position);
    least = std::min(least, signed_distance(collider.shape, place).distance);
  }
  return least;
}

// Between two boxes; negative: the least overlap along an axis.
double gap_between(const BoundingBox& a, const BoundingBox& b) {
  const Eigen::Vector3d apart = (a.low - b.high).cwiseMax(b.low - a.high);
  return apart.maxCoeff() > 0 ? apart.cwiseMax(0).norm() : apart.maxCoeff();
}

Json body_json(const PlacedBody& body, double step) {
  const BoundingBox box = bounding_box(body.surface);
  Json json{{"name", body.name},
            {"kind", body.kind},
            {"model", body.model},
            {"position", vector_json(body.pose.position)},
            {"quaternion", quaternion_json(body.pose.rotation)},
            {"low", vector_json(box.low)},
            {"high", vector_json(box.high)}};
  if (!body.first_mode) return json;
  json["first_mode_hz"] = *body.first_mode;
  json["steps_a_period"] = 1.0 / (*body.first_mode * step);
  json["resolving_step_s"] = resolving_step(*body.first_mode);
  return json;
}

Json contacts_json(const ScenePlaces& places) {
  Json contacts = Json::array();
  if (!places.together) return contacts;
  std::vector<BoundingBox> boxes;
  for (const PlacedBody& body : places.bodies) boxes.push_back(bounding_box(body.surface));
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (const NamedCollider& collider : places.colliders) {
      const double distance = distance_to(places.bodies[i], collider);
      if (distance < kNearContact * boxes[i].diagonal())
        contacts.push_back({{"body", places.bodies[i].name},
                            {"collider", collider.name},
                            {"distance_m", distance}});
    }
    for (std::size_t k = 0; k < i; ++k)
      if (const double gap = gap_between(boxes[i], boxes[k]); gap <= 0)
        contacts.push_back({{"body", places.bodies[k].name},
                            {"other", places.bodies[i].name},
                            {"boxes_overlap_m", -gap}});
  }
  return contacts;
}

std::string vector_text(const Json& x) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", x[0].get<double>(), x[1].get<double>(),
                     x[2].get<double>());
}

std::string contact_text(const Json& contact) {
  const std::string body = contact["body"];
  if (contact.contains("other"))
    return fmt::format("the boxes around {} and {} overlap by {:.4g} m", body,
                       contact["other"].get<std::string>(),
                       contact["boxes_overlap_m"].get<double>());
  const double distance = contact["distance_m"];
  return fmt::format("{} is {:.4g} m {} {}", body, std::abs(distance),
                     distance < 0 ? "inside" : "above", contact["collider"].get<std::string>());
}

}  // namespace

Json places_json(const ScenePlaces& places) {
  Json json{{"scene", places.path},        {"kind", places.kind},     {"step", places.step},
            {"duration", places.duration}, {"bodies", Json::array()}, {"colliders", Json::array()}};
  for (const PlacedBody& body : places.bodies)
    json["bodies"].push_back(body_json(body, places.step));
  for (const NamedCollider& collider : places.colliders)
    json["colliders"].push_back({{"name", collider.name},
                                 {"shape", shape_name(collider.shape)},
                                 {"position", vector_json(collider.pose.position)}});
  json["contacts"] = contacts_json(places);
  json["warnings"] = places.warnings;
  return json;
}

void print_places(const ScenePlaces& places, bool json) {
  const Json contents = places_json(places);
  print_warnings(places.warnings);
  if (json) {
    print_json(contents);
    return;
  }
  show("{}: {}, {} bodies and {} colliders, {:.6g} s in steps of {:.4g} s\nat t = 0:\n",
       places.path, places.kind, places.bodies.size(), places.colliders.size(), places.duration,
       places.step);
  for (const Json& body : contents["bodies"]) {
    show("  {}: {}, at {}, from {} to {} m\n", body["name"].get<std::string>(),
         body["kind"].get<std::string>(), vector_text(body["position"]), vector_text(body["low"]),
         vector_text(body["high"]));
    if (body.contains("first_mode_hz"))
      show("    first mode {:.4g} Hz: {:.3g} steps a period; {:.4g} s or less resolve it\n",
           body["first_mode_hz"].get<double>(), body["steps_a_period"].get<double>(),
           body["resolving_step_s"].get<double>());
  }
  for (const Json& collider : contents["colliders"])
    show("  {}: {}, at {}\n", collider["name"].get<std::string>(),
         collider["shape"].get<std::string>(), vector_text(collider["position"]));
  if (!places.together) return;
  show("in contact at t = 0:{}\n", contents["contacts"].empty() ? " nothing" : "");
  for (const Json& contact : contents["contacts"]) show("  {}\n", contact_text(contact));
}

void warn_away(const std::string& whose, const Motion& motion, const Pose& base,
               Warnings& warnings) {
  for (const MotionPart& part : motion.parts) {
    const auto* keyframes = std::get_if<KeyframeMotion>(&part);
    if (keyframes == nullptr || keyframes->absolute) continue;
    const Result<MotionPath> path = MotionPath::create({{part}}, base);
    if (!path) continue;
    const Pose begin = path->pose(0.0);
    const double away = (begin.position - base.position).norm();
    const double degrees = begin.rotation.angularDistance(base.rotation) * 180 / std::numbers::pi;
    if (away < 1e-9 && degrees < 1e-6) continue;
    warnings.push_back(fmt::format(
        "{}: its keyframes put it {:.4g} m and {:.4g} degrees away from its `position` at t = 0. "
        "They are relative to it; frame = \"world\" makes them poses in the world",
        whose, away, degrees));
  }
}

Warnings keyframe_warnings(const std::vector<SceneBody>& bodies,
                           const std::vector<SceneCollider>& colliders) {
  Warnings warnings;
  for (const SceneBody& body : bodies)
    warn_away("body '" + body.name + "'", body.motion, body.pose, warnings);
  for (const SceneCollider& collider : colliders)
    warn_away("collider '" + collider.name + "'", collider.motion, collider.pose, warnings);
  return warnings;
}

}  // namespace tremolo
