// A point of a body near the shape of another body in a step of both (contact_island.h): its force,
// and the effect of the force on the equations of the two.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/contact/solve/contact_points.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {

// The surroundings of a point on a shape on several bones. They move rigidly in the step, as
// BonePoints::motion_at() says.
struct BoneSite {
  StepMotion motion;
  // Turn gradients by positions of the mesh's coordinates into gradients by positions of the world:
  // at the point at the start, at its end when the normals were renewed, and at slope_place.
  Eigen::Matrix3d at_start, at_end, at_slope;
};

// A point of the member a near the shape of the member b.
struct PairPoint {
  std::size_t a = 0, b = 0, point = 0;
  ContactLaw law;
  ContactMemory memory;   // along the axes of b's frame; its obstacle is b's number in the group
  Eigen::Matrix3d frame;  // from the memory's axes in the step to the world's axes
  // Rows of U of b at the start near the point, transposed, r x 3, once it acts.
  Eigen::MatrixX3d rows;
  // distance: d0, m. energy: e0, J.
  double distance = 0.0, energy = 0.0;
  // gradient: of d at the start, once it acts. place_at_start: y, m.
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
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // y at the end, m, where it may act
  std::shared_ptr<BoneSite> site = {};              // once it acts, if b is on several bones
  EntrySide side, end_side;                         // that count at the start and at the end
  Eigen::Vector3d inward = gradient;                // entry_side.h, in the mesh's coordinates
  // The point at the start in the shape's coordinates at rest, with distance and normal there, of
  // the centre of a round point, once they are needed.
  std::optional<PassagePoint> from;
};

// The motion that the point's position follows with the second body, once it acts.
inline const StepMotion& motion_at(const PairPoint& pair, const ContactEquations& second) {
  return second.bones ? pair.site->motion : second.motion;
}

// Applies the opposite of the force of an acting pair to the second body.
void push_second(const PairPoint& pair, ContactEquations& second);

// The two bodies of a pair.
struct PairBodies {
  ContactEquations& first;   // of the point
  ContactEquations& second;  // of the shape
};

// Buffers. n: number of unknowns of the body.
struct PairScratch {
  // Fall of the force (change_*) and of the force that deforms the second body (bend_change_*) with
  // the unknowns of body a and b, 3 x n each.
  Eigen::Matrix3Xd change_a, change_b, bend_change_a, bend_change_b;
  // Of a round point, as in ContactSlopes; and the gradient of the distance, world.
  ContactSlope rub;
  Eigen::Matrix3d by_roll;
  Eigen::Vector3d gradient;
  // A ContactLink's vectors, 3 x 1.
  Eigen::Matrix3Xd link = Eigen::Matrix3Xd::Zero(3, 1), bend_link = link;
  // A ContactLink's growth with the unknowns, n each.
  Eigen::VectorXd growth_a, growth_b;
  BentScratch bent;
};

// Blocks of two members, a < b, in the Jacobian.
struct PairBlocks {
  // Derivative of a's residual with respect to b's unknowns, and the reverse.
  Eigen::MatrixXd by_other, other_by;
  // push: effect of the pair's rate on a's residual. growth: derivative of the part that
  // restitution takes with respect to a's unknowns. other_*: the same for b.
  Eigen::VectorXd push, growth, other_push, other_growth;

  void clear(Eigen::Index first, Eigen::Index second);
};

// The same, named by the point's own body, `first`, and the body of the shape, `second`.
struct PairSides {
  Eigen::MatrixXd &first_by_second, &second_by_first;
  Eigen::VectorXd &first_push, &first_growth, &second_push, &second_growth;
};

// Starts an attempt at the step: no values are kept.
void begin_pair(PairPoint& pair);

// Bounds of the motion of two bodies in the step.
struct PairWays {
  double bend = 0.0;  // of the displacement of the second body's points by its coordinates, m
  // The place of a point of the first body that begins at x, in the mesh's coordinates of the
  // second, changes by no more than way + turn times the distance of x from the second body, m.
  double way = 0.0, turn = 0.0;
};

PairWays ways_between(const StepWay& first, const StepWay& second);

// The pair's place at the end of the step, as both bodies are now.
Eigen::Vector3d place_at_end(const PairPoint& pair, const PairBodies& bodies);

// Computes the distance of the point from the other body as both are now, and adds it to the pair's
// rate. A point that cannot have come near by these bounds is not placed.
void approach_pair(PairPoint& pair, const PairBodies& bodies, const PairWays& ways, PairRate& rate);

// Computes the force of the pair there.
void press_pair(PairPoint& pair, const PairBodies& bodies, const ContactTime& time,
                const ContactRenewal& renewal, PairScratch& scratch);

// A point of a body of any kind: its end in the step, and the position about which the torque of a
// force is taken, m, world. turn: of a round point, the rotation of its body in the step, rad.
struct PairSite {
  Eigen::Vector3d end, middle;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
};

// The same two functions for a point of a body of any kind. The caller sets pair.touch_a: x1 before
// the first, x0 before the second.
void approach_shape(PairPoint& pair, const ContactEquations& second, double bend, PairRate& rate);
void press_shape(PairPoint& pair, const ContactEquations& second, const PairSite& site,
                 const ContactTime& time, const ContactRenewal& renewal, PairScratch& scratch);

// Slopes of a pair by the end of its point, which stands for the unknowns of the first body, and by
// the n unknowns of the second.
struct SiteSlopes {
  Eigen::Matrix3d by_end;     // fall of the force on the point with its end, N/m
  Eigen::Matrix3Xd by_shape;  // the same with the second body's unknowns, 3 x n
  Eigen::MatrixXd shape_by;   // of the second body's residual with the end, n x 3
  // Effect of the pair's rate on the force's fall, and growth of the part that restitution takes
  // with the end; shape_*: the same of the second body, n.
  Eigen::Vector3d link, growth;
  Eigen::VectorXd shape_link, shape_growth;

  void clear(Eigen::Index unknowns);
};

// Computes the slopes of an acting pair; those of the second body by its own unknowns are added to
// its Jacobian, except those by the pair's rate.
void add_site_slopes(PairPoint& pair, ContactEquations& second, const ContactTime& time,
                     bool follows, PairScratch& scratch, SiteSlopes& slopes);

// A pair in an island.
struct PairNames {
  std::size_t a = 0, b = 0;  // members: a has the points, b the shape
  std::size_t obstacle = 0;  // the number of b's body in the group
};

// Places a point, whose law is set, near the shape: at y in the shape's mesh coordinates and at
// that distance, m, at the start. inward: entry_side.h, in these coordinates. memory: of its
// contact; null: none. shape: the shape then.
void place_point(PairPoint& pair, const PairNames& names, std::size_t point,
                 const ContactMemory* memory, const Eigen::Vector3d& y, double distance,
                 const Eigen::Vector3d& inward, const BentShape& shape);

// Sets B and the energies of points from number `from` on, which are of one pair with all points of
// that pair among the first ones (contact_memories.h). Call it after place_point().
void set_levels(std::span<PairPoint> points, std::size_t from);

// Adds the points of a (its body is `first`) that may be in contact with b in the step to `points`,
// whose first `count` entries are used. Returns the new number of points. Both bodies must have
// gathered.
std::size_t add_pair_points(const ContactStep& first, const ContactStep& second,
                            const PairNames& names, std::vector<PairPoint>& points,
                            std::size_t count);

// Call this where the step of both is solved. It adds the points of a that came within the margin
// of b and are not among the first `count` points yet. Returns the new number of points.
std::size_t add_missed_points(const ContactStep& first, const ContactStep& second,
                              const PairNames& names, std::vector<PairPoint>& points,
                              std::size_t count);

// Makes the pair's memory after its step. False: it ended beyond the margin.
bool memory_of(const PairPoint& pair, ContactMemory& memory);

// Stores that memory and the contact of the point in its body, after a step of h, s. obstacle: the
// number of the second body in the group.
void remember_pair(const PairPoint& pair, ContactStep& first, std::size_t obstacle, double h);

// Adds the derivatives of the forces of an acting pair to the Jacobians of both bodies and to
// `sides`. Call it after press_pair() with the same time. follows: same as for contact_slopes().
void add_pair_slopes(PairPoint& pair, const PairBodies& bodies, const ContactTime& time,
                     bool follows, PairScratch& scratch, const PairSides& sides);

// The point of a pair of rigid bodies, for impact.h. second: the body of the shape; gathered.
ImpactPoint impact_point(const PairPoint& pair, const ContactStep& second);

// Adds the pair to the accounts of its bodies. place: its own at the end of the step. second: the
// body of the shape.
void settle_pair(const PairPoint& pair, const Eigen::Vector3d& place,
                 const ContactEquations& second, double h, ContactAccount& a, ContactAccount& b);

}  // namespace tremolo
