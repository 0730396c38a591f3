// Bodies of tetrahedra of a scene: positions and contacts, as plain values and as objects ready for
// steps.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/tets/contact/tet_surface.h"
#include "runtime/bodies/tets/motion/tet_group.h"
#include "runtime/contact/contact_values.h"
#include "runtime/math/pose.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// A body of the scene.
struct TetSceneBody {
  std::string name;
  std::string model;    // file of `tremolo-precompute tets`
  std::string made_by;  // the command that makes the file, for errors
  Pose pose;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // of the whole body, m/s
  // Of the whole body about its centre of mass, rad/s.
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  // It begins at rest in its equilibrium under gravity and its loads at t = 0.
  bool settled = false;
  double friction = 0.3;  // with its obstacles
  TetBodyOptions options;
  ContactOptions contact = {};  // in a world with bodies of other kinds; without points and shape
  std::vector<std::string> probes = {};  // in such a world: vertices whose motion is recorded
  std::vector<SceneLoad> loads = {};     // in such a world
};

// A scene. All bodies have the same step. Colliders are at rest.
struct TetBodiesScene {
  std::string path;  // of the file that the scene was read from, for errors; empty: none
  TetGroupOptions group;
  std::vector<TetSceneBody> bodies;
  std::vector<SceneCollider> colliders;
};

// Data shared by bodies of one file.
struct TetsKind {
  std::string path;
  TetModelPointer model;
  std::shared_ptr<const TetSurface> surface;
  TetHullPointer hull;
  bool held = false;  // it has fixed vertices
};

struct TetsBodies {
  std::vector<TetsKind> kinds;
  std::vector<std::size_t> kind_of;  // one per body
  std::unique_ptr<TetGroup> group;

  const TetsKind& kind(std::size_t body) const { return kinds[kind_of[body]]; }
  std::size_t elements() const;
  // Models and surfaces once, plus all bodies.
  std::size_t bytes() const;
};

// Bodies at their positions.
struct PlacedTets {
  std::vector<TetsKind> kinds;
  std::vector<std::size_t> kind_of;  // one per body
  std::vector<TetBody> bodies;
};

// Reads the files and moves the bodies to their positions in the scene; those that are `settled`
// keep their shape at rest, because their loads may not be known yet. path: of the scene, for
// errors. Errors, with the body's name first: those of read_tets, TetModel::create and
// TetBody::create; kSystem for a missing file, with the command that makes it.
Result<PlacedTets> place_tets(std::span<const TetSceneBody> bodies, const std::string& path);

// The same as a group, with bodies in equilibrium if they are `settled`. Errors: those of
// place_tets() and TetBody::settle().
Result<TetsBodies> make_tets_bodies(const TetBodiesScene& scene);

}  // namespace tremolo
