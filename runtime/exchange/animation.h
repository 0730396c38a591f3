// What is written for other programs: surfaces that move, as plain values.
//
//     x(t) = T(t) (X + U q(t))          T: the body's pose; on bones the blend of theirs
//
// or, of what no modes describe, X + u(t) with a displacement u for each vertex and frame.
//
// X, U and the triangles belong to a shape, which any number of bodies share; q and T to a body.
// Lengths are m, times s; z is up unless the user's meshes say otherwise.
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
#include "runtime/frames/pose.h"
#include "runtime/skeleton/bone_weights.h"

namespace tremolo {

// surface: the rest shape, s vertices; its normals are not read. modes: 3s x r, kg^-1/2; r may be 0
// of what does not deform. response_columns: so many of the last are the response of a body to
// forces at places (LocalResponse), m/N, and their weights N. smooth_groups: s numbers; vertices of
// one number share a normal. None: each has its own.
struct AnimatedShape {
  std::string name;
  RenderSurface surface;
  BasisRows modes;
  Eigen::Index response_columns = 0;
  std::vector<std::uint32_t> smooth_groups;
};

// shape: into Animation::shapes. q: r numbers a frame, frame behind frame, kg^1/2 m. poses: one a
// frame; on bones one a frame and bone, the bones of a frame behind each other, as
// runtime/skeleton/skin.h has them. weights: s x bones of a body on bones; else empty.
// displacements: 3s numbers a frame, frame behind frame, m, of a body whose shape has no modes and
// whose vertices go each their own way; else empty. collider: it is part of the scenery and has no
// coordinates.
struct AnimatedBody {
  std::string name;
  std::size_t shape = 0;
  std::vector<double> q;
  std::vector<Pose> poses;
  BoneWeights weights;
  std::vector<std::string> bone_names;  // one a bone, or none
  std::vector<double> displacements;
  bool collider = false;

  std::size_t bones() const {
    return weights.cols() > 0 ? static_cast<std::size_t>(weights.cols()) : 1;
  }
};

// times: of the frames, s, ascending. rate: frames a second that were asked for, for formats that
// know no times.
struct Animation {
  double rate = 60.0;
  std::vector<double> times;
  std::vector<AnimatedShape> shapes;
  std::vector<AnimatedBody> bodies;

  std::size_t frames() const { return times.size(); }
  const AnimatedShape& shape_of(const AnimatedBody& body) const { return shapes[body.shape]; }
};

// kUsage, naming the body, where sizes do not fit each other, an index names nothing, a number is
// not finite, times do not ascend, names are empty or stand twice, or there is no frame or no body.
// What writes an animation asks this first.
Status check_animation(const Animation& animation);

// The largest extent of the shape at rest, m.
double largest_extent(const AnimatedShape& shape);

Eigen::Map<const Eigen::VectorXd> coordinates_at(const Animation& animation,
                                                 const AnimatedBody& body, std::size_t frame);
std::span<const Pose> poses_at(const AnimatedBody& body, std::size_t frame);

// x y z x y z ... of the body's vertices, 3s numbers: X + U q in the body's own frame, and x in the
// world.
void local_positions(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                     std::span<double> out);
void world_positions(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                     std::span<double> out);
// T's linear part times U q: what a vertex is displaced by, along the world's axes, m.
void world_displacements(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                         std::span<double> out);

// Keeps the first `count` coordinates of every shape; others are left out of q and the modes. What
// that changes: the largest |x_all - x_kept| of all bodies, frames and vertices, over the size of
// the body's shape. kUsage if count is 0.
Result<double> keep_coordinates(Animation& animation, std::size_t count);

}  // namespace tremolo
