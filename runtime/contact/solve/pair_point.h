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
  Eigen::MatrixX3d rows;
  double distance = 0.0, energy = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero(), place_at_start = gradient;  // y
  ContactHeld held;  // along the world's axes
  ContactGap gap() const { return {distance, energy, now.distance}; }
  bool fresh = true;  // it has not acted
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
  Eigen::VectorXd by_q;
  BentScratch bent;
};

// The points of a (its body is `first`) that may touch b in the step are added to `points`, whose
// first `count` entries are used; the number of them then. Both must have gathered.
std::size_t add_pair_points(const ContactStep& first, const ContactStep& second, std::size_t a,
                            std::size_t b, std::vector<PairPoint>& points, std::size_t count);

// At the beginning of an attempt at the step: nothing is held.
void begin_pair(PairPoint& pair);

// What the pair feels where the two bodies are now. bend: how far the second's coordinates move any
// of its points in the step, m. h: the step, s. renew: as of contact_force().
void evaluate_pair(PairPoint& pair, const PairBodies& bodies, double bend, double h, double renew,
                   PairScratch& scratch);

// Adds how the forces of a pair that acts change with the unknowns to the Jacobians of both, and to
// first_by_second and second_by_first, by how much the residual of the one changes with the
// unknowns of the other. After evaluate_pair() with the same h.
void add_pair_slopes(const PairPoint& pair, const PairBodies& bodies, double h,
                     PairScratch& scratch, Eigen::MatrixXd& first_by_second,
                     Eigen::MatrixXd& second_by_first);

// Books the pair in the accounts of its bodies. second: of the shape.
void settle_pair(const PairPoint& pair, const ContactStep& second, double h, ContactAccount& a,
                 ContactAccount& b);

}  // namespace tremolo
