// The output of `tremolo inspect SCENE` for any kind of scene: positions at t = 0, contacts there,
// and steps that resolve the bodies' vibration.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/contact/contact_law.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// A body at t = 0.
struct PlacedBody {
  std::string name;
  std::string kind;                      // "fixed", "driven", "free", "tets", "cloth"
  std::string model;                     // file
  Pose pose;                             // of its frame
  std::vector<Eigen::Vector3d> surface;  // vertices of its boundary, m, in the world
  std::optional<double> first_mode;      // Hz, above 0
};

struct NamedCollider {
  std::string name;
  Collider shape;
  Pose pose;  // at t = 0
};

// kind: of the scene, for the first line. step, duration: s. together: the bodies are in one world,
// so that their contact means something.
struct ScenePlaces {
  std::string path;
  std::string kind;
  double step = 0.0;
  double duration = 0.0;
  bool together = true;
  std::vector<PlacedBody> bodies;
  std::vector<NamedCollider> colliders;
  Warnings warnings;
};

// Bodies against colliders by the vertices of their boundaries: the least distance, m, where that
// is below a hundredth of the body's size; negative: inside. Bodies against bodies by their
// bounding boxes: the gap, m, where that is not positive.
nlohmann::ordered_json places_json(const ScenePlaces& places);

// As JSON or as lines on stdout; warnings on stderr.
void print_places(const ScenePlaces& places, bool json);

// Adds a sentence for each keyframed part of the motion that is relative to the thing's `position`,
// and away from it at t = 0. whose: "ball 'a'". base: the thing's pose without its motion.
void warn_away(const std::string& whose, const Motion& motion, const Pose& base,
               Warnings& warnings);

// Bodies and colliders whose keyframes are relative to their `position`, and away from it at t = 0:
// a sentence for each.
Warnings keyframe_warnings(const std::vector<SceneBody>& bodies,
                           const std::vector<SceneCollider>& colliders);

}  // namespace tremolo
