// Welds: selections of vertices of two bodies are tied to each other by many joints
// (runtime/contact/joint.h), one from each vertex of the one to a place of the other one.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"

namespace tremolo {

// Vertices of a reduced or rigid body, and the places between them.
class WeldVertices {
 public:
  // vertices: empty: all of the boundary. Errors (kUsage): those of check_joinable() and of
  // Model::vertex().
  static Result<WeldVertices> create(const ContactBody& body, std::span<const VertexId> vertices);

  std::span<const JointPlace> rows() const { return rows_; }
  std::span<const Eigen::Vector3d> positions() const { return positions_; }  // now, m, world
  // The point of the body that is at a position now, m, world, and moves with the vertices near it
  // (weld_place()). offset: receives its distance from them, m, which the point keeps along the
  // axes of the body's frame, or of the bones there.
  JointPlace at(const Eigen::Vector3d& position, double& offset) const;

 private:
  const ContactBody* body_ = nullptr;  // stays in memory
  std::vector<JointPlace> rows_;
  std::vector<Eigen::Vector3d> positions_;
};

// Sets the spring of one of `count` joints. options: of all of them; lightness: the rate, 1/kg, at
// which the points part if the forces of all joints are equal; h: the step, s. Without a stiffness
// all joints together are as stiff as one pin; more is limited to that.
void set_weld_spring(Joint& joint, const JointOptions& options, std::size_t count, double lightness,
                     double h);

// The joints of a weld of two reduced or rigid bodies. No force acts at first: each vertex `at` of
// the first body is tied to the point of the second one that is at its position now and moves with
// the vertices `to`. Vertices that cannot move, like the point, have none. gap: the longest offset
// of a point (WeldVertices::at()), m. Errors (kUsage): two steps; an offset that is longer; nothing
// moves; those of WeldVertices::create().
Result<std::vector<Joint>> make_weld(const ContactBody& first, std::span<const VertexId> at,
                                     const ContactBody& second, std::span<const VertexId> to,
                                     const JointOptions& options, double gap);

// An offset of `apart` m is longer than the gap of a weld.
Error too_far_to_weld(double apart, double gap);

}  // namespace tremolo
