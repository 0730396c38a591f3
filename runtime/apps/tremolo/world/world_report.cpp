#include "runtime/apps/tremolo/world/world_report.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "common/units.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/shape_reach.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShown = 12;  // bodies whose lines a run prints

Json json_causes(const EnergyAccount& account) {
  return {{"load", number_or_null(account.load)},
          {"support", number_or_null(account.support)},
          {"gravity", number_or_null(account.gravity)},
          {"contact", number_or_null(account.contact_given)},
          {"friction", number_or_null(account.friction)},
          {"restitution", number_or_null(account.restitution)},
          {"damping", number_or_null(account.damping)},
          {"hand", number_or_null(account.hand)},
          {"joint", number_or_null(account.joint)}};
}

Json body_json(const SceneBody& body, const SceneBodyReport& report) {
  Json json;
  add_body(report, json);
  json["kind"] = kind_name(body);
  const std::pair<const char*, const BodyPlace&> places[] = {{"_initial", report.start},
                                                             {"_final", report.end}};
  for (const auto& [when, place] : places) {
    const std::string ending = when;
    json["position" + ending] = vector_json(place.pose.position);
    json["quaternion" + ending] = quaternion_json(place.pose.rotation);
    json["linear_momentum" + ending] = vector_json(place.momenta.linear);
    json["angular_momentum" + ending] = vector_json(place.momenta.angular);
  }
  json["energy_max"] = number_or_null(report.balance.energy_max);
  json["energy_by_cause"] = json_causes(report.account);
  json["energy_balance_error"] = number_or_null(report.balance_error());
  json["contacts"] = report.contacts;
  json["contact_energy"] = number_or_null(report.account.contact);
  json["contact_error"] = number_or_null(report.account.contact_error);
  json["penetration_max"] = number_or_null(report.penetration_max);
  json["penetration_surface_max"] = number_or_null(report.penetration_surface_max);
  json["slip_max"] = number_or_null(report.slip_max);
  json["rebound"] = report.rebound ? number_or_null(*report.rebound) : Json(nullptr);
  json["contact_begins_within"] = number_or_null(report.begins_within);
  json["friction_held_steps"] = report.friction_held_steps;
  Json impulses = Json::object();
  for (const auto& [collider, impulse] : report.collider_impulses)
    impulses[collider] = vector_json(impulse);
  json["collider_impulses"] = impulses;
  json["contact_speed_max"] = number_or_null(report.contact_speed_max);
  json["passed_through"] = report.passed_through;
  json["asleep"] = report.asleep;
  add_ending(report, json);
  return json;
}

// joint: null where its time is over. points: the number of its joints between points.
Json joint_json(const SceneJoint& wanted, const Joint* joint, std::size_t points) {
  const Joint now = joint == nullptr ? Joint{} : *joint;
  return {{"body", wanted.body},
          {"to", wanted.to.empty() ? kWorldName : wanted.to},
          {"kind", wanted.weld ? "weld" : "point"},
          {"points", points},
          {"holds", joint != nullptr},
          {"stiffness", joint == nullptr ? Json(nullptr) : Json(now.stiffness)},
          {"damping", joint == nullptr ? Json(nullptr) : Json(now.damping)},
          {"force", vector_json(now.force)},
          {"energy", number_or_null(now.energy)},
          {"damped", number_or_null(now.damped)}};
}

Json hand_json(const SceneHand& wanted, const HandCourse& hand, const Eigen::Vector3d& force) {
  Json json{{"body", wanted.body}, {"at", wanted.at}, {"holds", hand.holds()}};
  const auto& spring = hand.spring();
  json["stiffness"] = spring ? number_or_null(spring->stiffness) : Json(nullptr);
  json["damping"] = spring ? number_or_null(spring->damping) : Json(nullptr);
  json["force"] = vector_json(force);
  return json;
}

// Name of a joint in messages.
std::string joint_name(const SceneJoint& joint, std::size_t i) {
  return fmt::format("joint {} (body '{}', to '{}')", i + 1, joint.body,
                     joint.to.empty() ? kWorldName : joint.to);
}

// Springs that mass and step do not allow.
void add_spring_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  const auto warn = [&warnings](const std::string& whose, double asked, double used) {
    if (used < asked * (1.0 - 1e-12))  // a weld's are divided and summed
      warnings.push_back(fmt::format(
          "{}: its stiffness of {:.4g} N/m is more than mass and step allow, {:.4g} N/m is used: "
          "a shorter step allows more, as one over its square",
          whose, asked, used));
  };
  for (std::size_t i = 0; i < scene.hands.size(); ++i) {
    const SceneHand& wanted = scene.hands[i];
    if (const auto& spring = world.hand(i).spring(); spring && !wanted.pin)
      warn(fmt::format("hand {} (body '{}', at {})", i + 1, wanted.body, wanted.at),
           wanted.stiffness, spring->stiffness);
  }
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    const SceneJoint& wanted = scene.joints[i];
    if (world.joint(i) != nullptr && wanted.options.stiffness)
      warn(joint_name(wanted, i), *wanted.options.stiffness, world.joint(i)->stiffness);
  }
}

// Adds a warning per model about bodies whose first mode the step does not resolve.
void add_step_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  std::vector<const Model*> seen;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    if (std::find(seen.begin(), seen.end(), &model) != seen.end()) continue;
    seen.push_back(&model);
    if (model.modes() == 0) continue;
    const std::string warning =
        step_warning(hertz(model.lambda()(0)), world.step_size(),
                     "body '" + scene.bodies[i].name + "': its ", "a step of ");
    if (!warning.empty()) warnings.push_back(warning);
  }
}

// Shapes that extend beyond their bodies, one warning a model.
void add_shape_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  std::vector<const Model*> seen;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    const ContactStep* contact = world.body(i).contact();
    if (contact == nullptr || !contact->surface().shape) continue;
    if (std::find(seen.begin(), seen.end(), &model) != seen.end()) continue;
    seen.push_back(&model);
    const ShapeReach reach = shape_beyond(model, *contact->surface().shape);
    if (reach.distance <= kShapeBeyond * reach.size) continue;
    warnings.push_back(fmt::format(
        "body '{}': its shape: {}: other bodies bump into what its own points do not feel; use a "
        "smaller shape",
        scene.bodies[i].name, reach_text(*contact->surface().shape, reach)));
  }
}

// Two rigid bodies without a shape in a scene in which nothing has contact.
std::optional<std::pair<std::size_t, std::size_t>> rigid_without_shape(const Scene& scene,
                                                                       const SceneWorld& world) {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const ContactStep* contact = world.body(i).contact();
    if (!scene.bodies[i].rigid || !scene.bodies[i].feels_contact) continue;
    if (contact != nullptr && (contact->surface().feels || contact->surface().shape)) continue;
    if (first) return std::pair(*first, i);
    first = i;
  }
  return std::nullopt;
}

// Bodies that meet and have no shape. One warning names the first two.
void add_passing_warning(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  if (const auto pair = rigid_without_shape(scene, world)) {
    warnings.push_back(
        fmt::format("rigid bodies '{}' and '{}' have no `shape`: they pass through each other",
                    scene.bodies[pair->first].name, scene.bodies[pair->second].name));
    return;
  }
  const auto passing = world.passing();
  if (!passing) return;
  warnings.push_back(fmt::format(
      "bodies '{}' and '{}' came near each other and may pass through each other: neither has a "
      "`shape`; give one of them a shape, or `shape = \"mesh\"` with a file of tremolo-precompute "
      "collider",
      scene.bodies[passing->first].name, scene.bodies[passing->second].name));
}

// Bodies that went deep into what they touch. One warning names the deepest and counts the others;
// a heavy body on a light one is the usual cause, because each has the stiffness of its own weight.
void add_depth_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  constexpr double kDeep = 0.1;  // of a body's size
  std::size_t deepest = 0, deep = 0;
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!(world.penetration_max(i) > kDeep)) continue;
    ++deep;
    if (world.penetration_max(i) > world.penetration_max(deepest)) deepest = i;
  }
  if (deep == 0) return;
  double lightest = std::numeric_limits<double>::infinity(), heaviest = 0.0;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const ContactStep* contact = world.body(i).contact();
    if (contact == nullptr) continue;
    lightest = std::min(lightest, contact->surface().mass);
    heaviest = std::max(heaviest, contact->surface().mass);
  }
  warnings.push_back(fmt::format(
      "body '{}': its contact points were {:.3g} % of its size deep in what it met{}: say a larger "
      "contact-modulus or contact-stiffness for it and for what it meets; the heaviest body of the "
      "scene has {:.3g} times the mass of the lightest",
      scene.bodies[deepest].name, 100.0 * world.penetration_max(deepest),
      deep > 1 ? fmt::format(" ({} more bodies as well)", deep - 1) : std::string(),
      heaviest / lightest));
}

}  // namespace

void JointStretch::observe(const SceneWorld& world) {
  const std::size_t count = world.scene().joints.size();
  most_.resize(count, 0.0);
  for (std::size_t i = 0; i < count; ++i)
    if (const Joint* joint = world.joint(i); joint != nullptr && joint->stiffness > 0.0)
      most_[i] = std::max(most_[i], std::sqrt(2.0 * joint->energy / joint->stiffness));
}

void JointStretch::add_warnings(const SceneWorld& world, Warnings& warnings) const {
  constexpr double kHolds = 0.05;  // of the smaller body's size
  for (std::size_t i = 0; i < most_.size(); ++i) {
    const SceneJoint& joint = world.scene().joints[i];
    double size = HUGE_VAL;
    for (const std::string* end : {&joint.body, &joint.to})
      if (const auto body = world.find(*end))
        size = std::min(size, surface_size(world.body(*body).model()));
    if (joint.options.stiffness || !(most_[i] > kHolds * size)) continue;
    warnings.push_back(fmt::format(
        "{}: it was extended by {:.3g} m, {:.2g} of the size of a body that it joins: it carries "
        "more than its spring holds; a shorter step makes it stiffer, as one over its square, and "
        "so do masses that differ less",
        joint_name(joint, i), most_[i], most_[i] / size));
  }
}

Warnings world_warnings(const Scene& scene, const SceneWorld& world) {
  Warnings warnings = keyframe_warnings(scene.bodies, scene.colliders);
  add_step_warnings(scene, world, warnings);
  add_shape_warnings(scene, world, warnings);
  add_spring_warnings(scene, world, warnings);
  add_passing_warning(scene, world, warnings);
  add_depth_warnings(scene, world, warnings);
  return warnings;
}

void add_sheet_warnings(const std::vector<Json>& guests, Warnings& warnings) {
  for (const Json& guest : guests) {
    if (!guest.contains("thickness")) continue;
    const double deep = guest["penetration_max"].get<double>();
    const double thickness = guest["thickness"].get<double>();
    if (!(deep > thickness)) continue;
    warnings.push_back(fmt::format(
        "cloth '{}': its particles were {:.3g} mm deep in what it met, more than its thickness of "
        "{:.3g} mm, and may pass through: say a larger contact-stiffness for it and for what it "
        "meets, 1600 for instance",
        guest["body"].get<std::string>(), 1e3 * deep, 1e3 * thickness));
  }
}

Json world_json(const SceneFile& file, const SceneWorld& world, const std::vector<BodyLog>& logs,
                const std::vector<Json>& guests, const WorldEnding& ending, double momentum_error,
                const Warnings& warnings) {
  Json json;
  json["schema"] = kReportSchema;
  json["scene"] = file.path;
  json["step"] = world.step_size();
  json["duration"] = file.scene.duration;
  json["steps"] = world.steps();
  json["reached"] = world.time();
  const double each = 1e6 * ending.seconds / static_cast<double>(ending.steps);
  json["microseconds_per_step"] = number_or_null(each);
  json["real_time_factor"] = number_or_null(world.step_size() * 1e6 / each);
  double worst = 0.0;
  for (const BodyLog& log : logs) worst = std::max(worst, log.report().balance_error());
  json["energy_balance_error"] = number_or_null(worst);
  json["momentum_error"] = number_or_null(momentum_error);
  json["contact_speed_limit"] = number_or_null(world.contact_speed_limit());
  add_ending(ending, json);
  json["bodies"] = Json::array();
  for (std::size_t i = 0; i < logs.size(); ++i)
    json["bodies"].push_back(body_json(file.scene.bodies[i], logs[i].report()));
  for (const Json& guest : guests) json["bodies"].push_back(guest);
  json["joints"] = Json::array();
  for (std::size_t i = 0; i < file.scene.joints.size(); ++i)
    json["joints"].push_back(
        joint_json(file.scene.joints[i], world.joint(i), world.joint_points(i)));
  json["hands"] = Json::array();
  for (std::size_t i = 0; i < file.scene.hands.size(); ++i)
    json["hands"].push_back(hand_json(file.scene.hands[i], world.hand(i), world.hand_force(i)));
  json["warnings"] = warnings;
  return json;
}

void print_bodies(const SceneFile& file, const SceneWorld& world,
                  const std::vector<BodyLog>& logs) {
  const std::size_t shown = std::min(logs.size(), kShown);
  for (std::size_t i = 0; i < shown; ++i) {
    const SceneBodyReport& report = logs[i].report();
    const EnergyAccount& account = report.account;
    tell("  {} ({}, {}): energy {:.6g} -> {:.6g} J; ", file.scene.bodies[i].name,
         kind_name(file.scene.bodies[i]), file.scene.bodies[i].integrator, account.at_start,
         account.total());
    tell("load {:.4g}, support {:.4g}, gravity {:.4g}, damping {:.4g} J; balance to {:.1e}\n",
         account.load, account.support, account.gravity, account.damping, report.balance_error());
    if (world.body(i).contact() != nullptr)
      tell(
          "    contact {:.4g}, restitution {:.4g}, friction {:.4g}, hand {:.4g}, joint {:.4g} J; "
          "{} "
          "contacts, its points {:.3g} % of its size deep at most, its surface {:.3g} %{}\n",
          account.contact_given, account.restitution, account.friction, account.hand, account.joint,
          report.contacts, 100 * report.penetration_max,
          100 * report.penetration_surface_max / report.size,
          report.rebound ? fmt::format(", rebound {:.3g}", *report.rebound) : std::string());
    if (report.size > 0)
      tell("    deformed by {:.4g} m at most, {:.3g} % of its size\n", report.farthest.distance,
           100 * report.farthest.distance / report.size);
    if (!report.files.empty())
      tell("    wrote into {}: {}\n", logs[i].folder(), list_files(report.files));
  }
  std::int64_t passed = 0;
  for (const BodyLog& log : logs) passed += log.report().passed_through;
  if (passed > 0)
    tell(
        "  {} times a contact point went through what it met within a step: say a shorter --step\n",
        passed);
  if (shown < logs.size()) tell("  and {} more bodies; --json lists all\n", logs.size() - shown);
}

const char* kind_name(const SceneBody& body) {
  if (body.rigid) return "rigid";
  if (body.kind == FrameKind::kFree) return "free";
  return body.kind == FrameKind::kDriven ? "driven" : "fixed";
}

std::string solid_name(const SceneBody& body) {
  if (!body.rigid) return body.model;
  return body.rigid->shape ? shape_name(*body.rigid->shape) : body.rigid->mesh;
}

}  // namespace tremolo
