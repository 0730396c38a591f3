#include <cmath>
#include <optional>
#include <utility>

#include "runtime/io/scenes/part_readers.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {
namespace {

void need(TomlKeys& keys, const char* key) {
  if (!keys.has(key)) keys.fail(key, std::string("it has no `") + key + "`");
}

int line_of(const toml::table& table) {
  return static_cast<int>(table.source().begin.line);
}

// A key whose value is a length of the shape.
void read_length(TomlKeys& keys, const char* key, double& length) {
  need(keys, key);
  keys.read(key, length);
}

SphereShape read_sphere(TomlKeys& keys) {
  SphereShape sphere;
  read_length(keys, "radius", sphere.radius);
  return sphere;
}

// A capsule or a cylinder.
template <class Shape>
Shape read_round(TomlKeys& keys) {
  Shape shape;
  read_length(keys, "radius", shape.radius);
  read_length(keys, "half-length", shape.half_length);
  return shape;
}

BoxShape read_box(TomlKeys& keys) {
  BoxShape box;
  need(keys, "half-extents");
  keys.read("half-extents", box.half_extents);
  return box;
}

// The shape that the key `shape` names; of a mesh its file, and the command that makes it.
std::optional<Collider> read_shape(TomlKeys& keys, std::string& file, std::string& made_by,
                                   const char* made_by_key) {
  const std::vector<std::string_view> kinds = {"plane", "sphere",   "capsule",
                                               "box",   "cylinder", "mesh"};
  const std::size_t kind = keys.read_word("shape", kinds, kinds.size());
  std::optional<Collider> shape;
  if (kind == 0) shape = PlaneShape{};
  if (kind == 1) shape = read_sphere(keys);
  if (kind == 2) shape = read_round<CapsuleShape>(keys);
  if (kind == 3) shape = read_box(keys);
  if (kind == 4) shape = read_round<CylinderShape>(keys);
  if (kind == 5) {
    need(keys, "file");
    keys.read_path("file", file);
    keys.read(made_by_key, made_by);
  }
  if (shape && keys.good())
    if (Status s = check(*shape); !s) keys.fail("shape", s.error().message);
  return shape;
}

// Friction is at least 0, restitution from 0 to 1.
void read_rubbing(TomlKeys& keys, double& friction, double& restitution) {
  keys.read("friction", friction);
  if (!(friction >= 0.0)) keys.fail("friction", "'friction' must not be negative");
  keys.read("restitution", restitution);
  if (!(restitution >= 0.0 && restitution <= 1.0))
    keys.fail("restitution", "'restitution' must be from 0 to 1");
}

}  // namespace

void read_contact_stiffness(TomlKeys& keys, ContactOptions& contact) {
  keys.read("contact-stiffness", contact.stiffness);
  if (!(contact.stiffness > 0.0 && std::isfinite(contact.stiffness)))
    keys.fail("contact-stiffness", "contact-stiffness must be positive and finite");
  if (keys.has("contact-modulus")) {
    keys.read("contact-modulus", contact.modulus.emplace());
    if (!(*contact.modulus > 0.0 && std::isfinite(*contact.modulus)))
      keys.fail("contact-modulus", "contact needs a modulus above zero, in Pa");
    if (keys.has("contact-stiffness"))
      keys.fail("contact-modulus", "takes the place of `contact-stiffness`: leave one of them out");
  }
}

void read_contact_law(TomlKeys& keys, ContactOptions& contact) {
  keys.read("contact-margin", contact.margin);
  if (!(contact.margin > 0.0 && contact.margin < 1.0))
    keys.fail("contact-margin", "contact-margin must be above 0 and below 1 (a share of the size)");
  read_contact_stiffness(keys, contact);
  read_rubbing(keys, contact.friction, contact.restitution);
}

void read_body_contact(TomlKeys& keys, SceneBody& body) {
  keys.read("contact", body.feels_contact);
  keys.read("contact-points", body.contact.points);
  body.contact.shape = read_shape(keys, body.shape_file, body.shape_made_by, "shape-made-by");
  read_contact_law(keys, body.contact);
}

Result<SceneCollider> read_collider(const toml::table& table, std::size_t number,
                                    const std::string& path, std::vector<std::string>& files) {
  SceneCollider collider;
  const std::string what = told_name(table, "collider", number);
  TomlKeys keys(table, path, what);
  need(keys, "name");
  keys.read("name", collider.name);
  need(keys, "shape");
  if (const auto shape = read_shape(keys, collider.file, collider.made_by, "made-by"))
    collider.shape = *shape;
  collider.pose = read_pose(keys);
  read_rubbing(keys, collider.friction, collider.restitution);
  if (Status s = take(collider.motion, read_motion(keys, path, what, files, true)); !s)
    return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return collider;
}

Result<SceneHand> read_hand(const toml::table& table, std::size_t number, const std::string& path,
                            std::vector<std::string>& files) {
  SceneHand hand;
  hand.line = line_of(table);
  const std::string what = "hand " + std::to_string(number);
  TomlKeys keys(table, path, what);
  for (const char* key : {"body", "at"}) need(keys, key);
  keys.read("body", hand.body);
  keys.read_text_or_number("at", hand.at);
  keys.read("pin", hand.pin);
  if (!hand.pin) need(keys, "stiffness");
  keys.read("stiffness", hand.stiffness);
  if (!hand.pin && !(hand.stiffness > 0.0))
    keys.fail("stiffness", "'stiffness' must be positive (N/m)");
  keys.read("damping", hand.damping);
  if (!(hand.damping >= 0.0)) keys.fail("damping", "'damping' must not be negative (N s/m)");
  if (hand.pin && (keys.has("stiffness") || keys.has("damping")))
    keys.fail("pin",
              "a pin is as stiff as mass and step allow: leave `stiffness` and `damping` out");
  if (keys.has("position")) keys.read("position", hand.position.emplace());
  keys.read("from", hand.from);
  keys.read("until", hand.until);
  if (Status s = take(hand.motion, read_motion(keys, path, what, files)); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return hand;
}

Result<SceneJoint> read_joint(const toml::table& table, std::size_t number,
                              const std::string& path) {
  SceneJoint joint;
  joint.line = line_of(table);
  TomlKeys keys(table, path, "joint " + std::to_string(number));
  joint.weld = keys.read_word("kind", {"point", "weld"}, 0) == 1;
  for (const char* key : {"body", "at", "to"}) need(keys, key);
  keys.read("body", joint.body);
  keys.read_text_or_number("at", joint.at);
  keys.read("to", joint.to);
  keys.read_text_or_number("to-at", joint.to_at);
  if (keys.has("point")) keys.read("point", joint.point.emplace());
  if (keys.has("stiffness")) keys.read("stiffness", joint.options.stiffness.emplace());
  if (joint.options.stiffness && !(*joint.options.stiffness > 0.0))
    keys.fail("stiffness", "'stiffness' must be positive (N/m)");
  keys.read("damping", joint.options.damping);
  if (!(joint.options.damping >= 0.0))
    keys.fail("damping", "'damping' must not be negative (N s/m)");
  if (keys.has("damping") && !keys.has("stiffness"))
    keys.fail("damping", "without a `stiffness` both are as large as masses and step allow");
  keys.read("length", joint.options.length);
  if (!(joint.options.length >= 0.0)) keys.fail("length", "'length' must not be negative (m)");
  if (joint.weld && keys.has("length"))
    keys.fail("length", "a weld has no `length`: it keeps its vertices where they are");
  if (keys.has("gap")) keys.read("gap", joint.gap.emplace());
  if (joint.gap && !joint.weld) keys.fail("gap", "only a joint of `kind = \"weld\"` has a `gap`");
  if (joint.gap && !(*joint.gap >= 0.0)) keys.fail("gap", "'gap' must not be negative (m)");
  keys.read("touch", joint.options.touch);
  keys.read("until", joint.until);
  if (Status s = keys.finish(); !s) return s.error();
  return joint;
}

}  // namespace tremolo
