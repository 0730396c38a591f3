// Animations for other programs: moving surfaces as plain values.
//
//     x(t) = T(t) (X + U q(t))          T: the body's pose; on bones the blend of theirs
//
// or, of a motion without modes, X + u(t) with a displacement u for each vertex and frame.
//
// X, U and the triangles belong to a shape, which any number of bodies share; q and T to a body.
// Lengths are in m, times in s; z is up unless the user's meshes say otherwise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"
#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "runtime/bodies/reduced/bones/bone_weights.h"
#include "runtime/math/pose.h"

namespace tremolo {

// A shape of s vertices.
struct AnimatedShape {
  std::string name;
  RenderSurface surface;  // at rest; of its normals only whether there are some
  BasisRows modes;        // 3s x r, kg^-1/2; r may be 0 for a shape that does not deform
  // The number of columns, the last ones, that are the response of a body to forces at points
  // (LocalResponse), m/N; their weights are in N.
  Eigen::Index response_columns = 0;
  // s numbers; vertices with the same number share a normal. Empty: each vertex has its own.
  std::vector<std::uint32_t> smooth_groups;
  bool plane = false;  // a square stands for a plane without end: widen_planes()
};

// A body that moves.
struct AnimatedBody {
  std::string name;
  std::size_t shape = 0;  // index into Animation::shapes
  std::vector<double> q;  // r numbers per frame, kg^1/2 m
  // One per frame; on bones one per frame and bone, the bones of a frame together, as for
  // runtime/bodies/reduced/bones/skin.h.
  std::vector<Pose> poses;
  BoneWeights weights;                  // s x bones; empty: not on bones
  std::vector<std::string> bone_names;  // one per bone, or empty
  std::vector<double> displacements;  // 3s numbers per frame, m, of a shape without modes; or empty
  bool collider = false;              // scenery, without coordinates
  // Of each frame, 0: the body is not there, and its values are those of the nearest frame in which
  // it is; empty: it is there in all.
  std::vector<std::uint8_t> shown;

  bool is_shown(std::size_t frame) const { return shown.empty() || shown[frame] != 0; }
  std::size_t bones() const {
    return weights.cols() > 0 ? static_cast<std::size_t>(weights.cols()) : 1;
  }
};

// An animation.
struct Animation {
  double rate = 60.0;         // requested frames per second, for formats without times
  std::vector<double> times;  // of the frames, s, ascending
  std::vector<AnimatedShape> shapes;
  std::vector<AnimatedBody> bodies;

  std::size_t frames() const { return times.size(); }
  const AnimatedShape& shape_of(const AnimatedBody& body) const { return shapes[body.shape]; }
};

// Checks an animation; writers call it first. kUsage, with the body's name: sizes do not match, an
// index is out of range, a number is not finite, times do not ascend, names are empty or not
// unique, or there is no frame or no body.
Status check_animation(const Animation& animation);
// kUsage for a format that has every body in every frame: `path` names it in the error.
Status check_all_shown(const std::string& path, const AnimatedBody& body);

// Widens the squares of planes, whose half sides are 1 m, so that they reach below all bodies in
// all frames, with a margin.
void widen_planes(Animation& animation);

// The largest extent of the shape at rest, m.
double largest_extent(const AnimatedShape& shape);

Eigen::Map<const Eigen::VectorXd> coordinates_at(const Animation& animation,
                                                 const AnimatedBody& body, std::size_t frame);
std::span<const Pose> poses_at(const AnimatedBody& body, std::size_t frame);

// Positions of the body's vertices, x y z x y z ..., 3s numbers: X + U q in the body's own frame,
// and x in the world.
void local_positions(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                     std::span<double> out);
void world_positions(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                     std::span<double> out);
// Displacements of the vertices along the world's axes, m: T's linear part times U q.
void world_displacements(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                         std::span<double> out);

// Keeps the first `count` coordinates of every shape and removes the others from q and the modes.
// Returns the error: the largest |x_all - x_kept| over all bodies, frames and vertices, relative to
// the size of the body's shape. kUsage if count is 0.
Result<double> keep_coordinates(Animation& animation, std::size_t count);

}  // namespace tremolo
