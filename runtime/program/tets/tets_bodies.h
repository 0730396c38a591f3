// The bodies of a scene of tetrahedra, made ready to be stepped.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/scene_reader/tets_reader.h"
#include "runtime/tets/contact/tet_surface.h"
#include "runtime/tets/motion/tet_group.h"

namespace tremolo {

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
Result<TetsBodies> make_tets_bodies(const TetScene& scene);

}  // namespace tremolo
