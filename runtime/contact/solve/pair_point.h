// A point of a body near the shape of another one in a step of both (contact_island.h): what it
// feels, and what that does to the equations of the two.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/contact/solve/bent_shape.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {

// A point of the member a near the shape of the member b at the start of the step, and what it
// feels in it. distance: d0, m; energy: e0, J. Once it acts, at the start: rows: of U of b nearby,
// transposed, r x 3; gradient: of d.
struct PairPoint {
  std::size_t a = 0, b = 0, point = 0;
  ContactLaw law;
  ContactMemory memory;   // along the axes of b's frame; its obstacle is b's number in the group
  Eigen::Matrix3d frame;  // of the memory in the step, to the world's axes
  Eigen::MatrixX3d rows;
  double distance = 0.0, energy = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero(), place_at_start = gradient;  // y
  ContactHeld held;  // along the world's axes
  ContactGap gap() const { return {distance, energy, now.distance}; }
  bool fresh = true;    // it has not acted
  bool sloped = false;  // of the end's distance: its gradient by y, and by the second's q, r
  Eigen::Vector3d slope = gradient, slope_place = gradient;
  Eigen::VectorXd by_q;
  ContactForce now;
  ContactTouch touch_a, touch_b;
  ContactWay way;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // y at the end
};

// The steps of the two bodies of a pair.
struct PairBodies {
  ContactStep& first;   // of the point
  ContactStep& second;  // of the shape
};

// Scratch. change_a, change_b: how a pair's force falls with the unknowns of its bodies, 3 x n
// each; bend_change_*: likewise what bends the second.
struct PairScratch {
  Eigen::Matrix3Xd change_a, change_b, bend_change_a, bend_change_b;
  BentScratch bent;
};

// The points of a (its body is `first`) that may touch b in the step are added to `points`, whose
// first `count` entries are used; the number of them then. Both must have gathered.
std::size_t add_pair_points(const ContactStep& first, const ContactStep& second, std::size_t a,
                            std::size_t b, std::vector<PairPoint>& points, std::size_t count);

// At the beginning of an attempt at the step: nothing is held.
void begin_pair(PairPoint& pair);

// The force of the pair where the two bodies are now. bend: how far the second's coordinates move
// any of its points in the step, m. h: the step, s.
void evaluate_pair(PairPoint& pair, const PairBodies& bodies, double bend, double h,
                   const ContactRenewal& renewal, PairScratch& scratch);

// A pair in an island.
struct PairNames {
  std::size_t a = 0, b = 0;  // the members: of the points, and of the shape
  std::size_t obstacle = 0;  // the number of b's body in the group
};

// Where the step of both is solved: adds the points of a that came within the margin of b and are
// not among the first `count` points yet; returns the number of points then.
std::size_t add_missed_points(const PairBodies& bodies, const PairNames& names,
                              std::vector<PairPoint>& points, std::size_t count);

// What is remembered of the pair after its step. False: it ended beyond the margin.
bool memory_of(const PairPoint& pair, ContactMemory& memory);

// Adds how the forces of a pair that acts change with the unknowns to the Jacobians of both, and to
// first_by_second and second_by_first, by how much the residual of the one changes with the
// unknowns of the other. After evaluate_pair() with the same h. follows: as of contact_slopes().
void add_pair_slopes(PairPoint& pair, const PairBodies& bodies, double h, bool follows,
                     PairScratch& scratch, Eigen::MatrixXd& first_by_second,
                     Eigen::MatrixXd& second_by_first);

// Books the pair in the accounts of its bodies. second: of the shape.
void settle_pair(const PairPoint& pair, const ContactStep& second, double h, ContactAccount& a,
                 ContactAccount& b);

}  // namespace tremolo
