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
  ContactGap gap;
  bool near = false;    // it may act
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
// each; bend_change_*: the same of what bends the second. link, bend_link, growth_*: of a
// ContactLink, 3 x 1 and n.
struct PairScratch {
  Eigen::Matrix3Xd change_a, change_b, bend_change_a, bend_change_b;
  Eigen::Matrix3Xd link = Eigen::Matrix3Xd::Zero(3, 1), bend_link = link;
  Eigen::VectorXd growth_a, growth_b;
  BentScratch bent;
};

// Two members, a < b, in the Jacobian. by_other, other_by: how the residual of a changes with the
// unknowns of b, and the reverse. push, growth: what the pair's rate does to a's residual, and how
// what restitution takes grows with its unknowns; other_*: the same of b.
struct PairBlocks {
  Eigen::MatrixXd by_other, other_by;
  Eigen::VectorXd push, growth, other_push, other_growth;

  void clear(Eigen::Index first, Eigen::Index second);
};

// The same by a point's own body, `first`, and the one it is near.
struct PairSides {
  Eigen::MatrixXd &first_by_second, &second_by_first;
  Eigen::VectorXd &first_push, &first_growth, &second_push, &second_growth;
};

// At the beginning of an attempt at the step: nothing is held.
void begin_pair(PairPoint& pair);

// Where the point is from the other body as both are now; adds it to the pair's rate. bend: how far
// the second's coordinates move any of its points in the step, m.
void approach_pair(PairPoint& pair, const PairBodies& bodies, double bend, PairRate& rate);

// The force of the pair there.
void press_pair(PairPoint& pair, const PairBodies& bodies, const ContactTime& time,
                const ContactRenewal& renewal, PairScratch& scratch);

// A pair in an island.
struct PairNames {
  std::size_t a = 0, b = 0;  // the members: of the points, and of the shape
  std::size_t obstacle = 0;  // the number of b's body in the group
};

// The points of a (its body is `first`) that may touch b in the step are added to `points`, whose
// first `count` entries are used; the number of them then. Both must have gathered.
std::size_t add_pair_points(const ContactStep& first, const ContactStep& second,
                            const PairNames& names, std::vector<PairPoint>& points,
                            std::size_t count);

// Where the step of both is solved: adds the points of a that came within the margin of b and are
// not among the first `count` points yet; returns the number of points then.
std::size_t add_missed_points(const PairBodies& bodies, const PairNames& names,
                              std::vector<PairPoint>& points, std::size_t count);

// What is remembered of the pair after its step. False: it ended beyond the margin.
bool memory_of(const PairPoint& pair, ContactMemory& memory);

// Adds how the forces of a pair that acts change with the unknowns to the Jacobians of both and to
// `sides`. After press_pair() with the same time. follows: as of contact_slopes().
void add_pair_slopes(PairPoint& pair, const PairBodies& bodies, const ContactTime& time,
                     bool follows, PairScratch& scratch, const PairSides& sides);

// Books the pair in the accounts of its bodies. second: of the shape.
void settle_pair(const PairPoint& pair, const ContactStep& second, double h, ContactAccount& a,
                 ContactAccount& b);

}  // namespace tremolo
