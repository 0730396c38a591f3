// Points of a body on bones in a step, for its contact (docs/theory.md, section "Contact").
//
// A point follows the blended map of its bones, x = F (X + u) + d. A position x of the world near
// the body belongs to the position Y of the mesh's coordinates, without the deformation u:
//
//     Y(x) = sum_i W_i(x) (X_i + R_i^T (x - x_i)),   x_i = F_i X_i + d_i
//
// R_i is the mean rotation of the point's bones, and W_i ~ 1/(|x - x_i|^2 + e^2)^4 with sum one.
// Where the points nearby have one bone, or bones that move together, Y is that pose's inverse to
// rounding. Between bones it is smooth, and Y(x_i) is near X_i.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/reduced/bones/skin.h"
#include "runtime/bodies/reduced/frames/driven_frame.h"
#include "runtime/math/kernels/scattered_field.h"
#include "runtime/math/pose.h"

namespace tremolo {

// The blended map [F d] of a point at the ends of a step.
struct StepMaps {
  BoneMap start, end;
};

class BonePoints {
 public:
  // rest: the points, m, the mesh's coordinates. weights: one row per point. softness2: e^2, m^2.
  BonePoints(std::vector<Eigen::Vector3d> rest, BoneWeights weights, double softness2);

  // Places the points at both ends of the next step of the frame, which has as many bones.
  void place(const DrivenFrame& frame);

  // The bones in the step.
  std::span<const StepPoses> poses() const { return poses_; }
  const StepMaps& maps(std::size_t point) const { return maps_[point]; }
  // The maps of any weights of the bones.
  template <class Weights>
  StepMaps maps_of(const Weights& weights) const {
    return {blended(weights, start_.bones), blended(weights, end_.bones)};
  }

  // The mean rotation in the step of bones with these weights, rad, world, with the length of
  // Cayley's formula.
  Eigen::Vector3d turn_of(std::span<const double> weights) const;

  // Y(x) at the start or the end of the step, m. x: m, world. slope: its derivative. Not for two
  // threads at once.
  Eigen::Vector3d into_rest(const Eigen::Vector3d& x, bool at_end) const;
  Eigen::Vector3d into_rest(const Eigen::Vector3d& x, bool at_end, Eigen::Matrix3d& slope) const;

  // False: x is far from all points, and those around it do not agree on its Y(x) = y. It is
  // then outside the body, whatever y is.
  bool agree(const Eigen::Vector3d& x, const Eigen::Vector3d& y, bool at_end) const;

  // The rigid motion in the step of what is at x at its start: along the mean rotation of the bones
  // there, and so that x ends where Y is the same.
  StepPoses motion_at(const Eigen::Vector3d& x) const;

 private:
  // The points at one end of the step. fields: n x 12, of each point X_i - R_i^T x_i and R_i^T.
  struct End {
    std::vector<BoneMap> bones;
    std::vector<Eigen::Vector3d> places;  // x_i
    ScatteredPoints field;
    TwelveValues fields;
  };

  void place(End& end, bool at_end);
  Eigen::Quaterniond rotation(const Eigen::Ref<const Eigen::RowVectorXd>& weights,
                              bool at_end) const;
  void find_nearness(const Eigen::Vector3d& x, const End& end) const;

  std::vector<Eigen::Vector3d> rest_;
  BoneWeights weights_;
  std::vector<StepPoses> poses_;
  std::vector<StepMaps> maps_;
  End start_, end_;
  mutable Eigen::VectorXd nearness_;   // W_i; scratch
  mutable Eigen::RowVectorXd shares_;  // of the bones at a position; scratch
};

}  // namespace tremolo
