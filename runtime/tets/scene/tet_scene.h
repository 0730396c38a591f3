// Bodies of tetrahedra as a scene has them: where they are and what they touch, as plain values,
// and the same made ready to be stepped.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/frames/pose.h"
#include "runtime/scene/scene.h"
#include "runtime/tets/contact/tet_surface.h"
#include "runtime/tets/motion/tet_group.h"

namespace tremolo {

// A body. model: the file of `tremolo-precompute tets`; made_by: the command that makes it, for
// errors. velocity, spin: of all of it, m/s and rad/s about its centre of mass. friction: with what
// it touches. creep: the speed below which friction is a creep, m/s (tet_contact.h).
struct TetSceneBody {
  std::string name;
  std::string model;
  std::string made_by;
  Pose pose;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  double friction = 0.3;
  double creep = kTetCreep;
  TetBodyOptions options;
};

// path: of the file that the scene came from, for errors; empty: none. All bodies have the same
// step. Colliders stand still.
struct TetBodiesScene {
  std::string path;
  TetGroupOptions group;
  std::vector<TetSceneBody> bodies;
  std::vector<SceneCollider> colliders;
};

// What bodies of one file share.
struct TetsKind {
  std::string path;
  TetModelPointer model;
  std::shared_ptr<const TetSurface> surface;
  TetHullPointer hull;
  bool held = false;
};

struct TetsBodies {
  std::vector<TetsKind> kinds;
  std::vector<std::size_t> kind_of;  // one a body
  std::unique_ptr<TetGroup> group;

  const TetsKind& kind(std::size_t body) const { return kinds[kind_of[body]]; }
  std::size_t elements() const;
  // Models and surfaces once, and all bodies.
  std::size_t bytes() const;
};

// Reads the files and puts the bodies where the scene has them. Errors, with the body's name in
// front: those of read_tets, TetModel::create and TetBody::create; kSystem for a file that is
// missing, with the command that makes it.
Result<TetsBodies> make_tets_bodies(const TetBodiesScene& scene);

}  // namespace tremolo
