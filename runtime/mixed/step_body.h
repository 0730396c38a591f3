// A body of any kind in a step of an island (mixed_island.h). The body owns its unknowns, its
// equation and the solve of its own matrix. Forces of contact act at its contact points, or on it
// as an obstacle (pair_forces.h), and are constant over the step.
//
// The equation is residual(z) = 0. All rows of a residual and of images of the matrix are scaled to
// one unit per body, that of enough().
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"

namespace tremolo {

// The motion of a contact point in a step, m, world.
struct SiteMotion {
  Eigen::Vector3d start, end;
  Eigen::Vector3d middle;  // about which the torque of a force is taken
};

// A ball around a body during a step.
struct StepBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // at the start, m, world
  double radius = 0.0;                               // at the start, m
  double travel = 0.0;  // without contact no point goes farther in the step, m
};

class StepBody {
 public:
  using In = const Eigen::Ref<const Eigen::VectorXd>&;
  using Out = Eigen::Ref<Eigen::VectorXd>;

  virtual ~StepBody() = default;

  // The body at the start of the step.
  virtual StepBall ball() const = 0;
  virtual std::size_t points() const = 0;  // number of contact points
  // False: the point is not for obstacles that deform.
  virtual bool feels(std::size_t point) const = 0;
  virtual Eigen::Vector3d start_of(std::size_t point) const = 0;
  virtual ContactLaw area_law() const = 0;  // for a unit of area: the stiffness is kappa, N/m^4
  // The same in contact with a body of the law `theirs`, also for a unit of area.
  virtual ContactLaw area_law_with(const ContactLaw& theirs) const {
    (void)theirs;
    return area_law();
  }
  virtual double area_of(std::size_t point) const = 0;  // m^2
  // The law of a point with that friction and restitution.
  virtual ContactLaw law_of(std::size_t point, double friction, double restitution) const = 0;
  virtual double rounding() const = 0;  // of distances, ContactLaw::rounding, m
  // The memory of the point's contact with an obstacle; null: there is none.
  virtual const ContactMemory* memory(std::size_t obstacle, std::size_t point) const = 0;
  // ContactMemories::reach_of_sides().
  virtual double reach_of_sides(std::size_t obstacle) const = 0;

  // The unknowns z and their number.
  virtual Eigen::Index unknowns() const = 0;
  // Starts an attempt at the step from the motion without contact.
  virtual void begin() = 0;
  virtual void keep() = 0;                           // stores z
  virtual void go(double length, In direction) = 0;  // z = the stored one - length direction
  // Computes the body's own forces at z and clears those of others. Then add the forces of others
  // and call close(), which returns the size of the residual.
  virtual void evaluate(const ContactRenewal& renewal) = 0;
  virtual SiteMotion motion(std::size_t point) const = 0;
  virtual void add_force(std::size_t point, const Eigen::Vector3d& force) = 0;  // N, world
  virtual double close() = 0;
  virtual double enough() const = 0;            // the size below which a residual is small
  virtual double momentum_of_size() const = 0;  // momentum for a size of one, kg m/s
  virtual void residual(Out rows) const = 0;
  // Product of the residual, as forces, with a direction of the unknowns, J.
  virtual double work_along(In direction) const = 0;

  // Computes the derivative of the residual; couplings then add theirs, and factor() prepares
  // precondition(). heavier: factor of added inertia. follows: friction limits follow the force.
  virtual void make_tangent(double heavier, bool follows) = 0;
  // by_end: fall of the force on the point with its end, N/m. force: the present one, N. The point
  // is known to change_at() and add_image() until the next make_tangent().
  virtual void add_slope(std::size_t point, const Eigen::Matrix3d& by_end,
                         const Eigen::Vector3d& force) = 0;
  // fresh: false: an earlier decomposition may be used. Returns false: there is none, the matrix is
  // singular.
  virtual bool factor(bool fresh) = 0;
  virtual void multiply(In x, Out rows) const = 0;  // rows = A x, without other bodies
  virtual void precondition(In rows, Out x) = 0;    // x near A^-1 rows
  // Change of the point's end by x, m.
  virtual Eigen::Vector3d change_at(std::size_t point, In x) const = 0;
  // rows += the change of the residual where the force on the point falls by `fall`, N.
  virtual void add_image(std::size_t point, const Eigen::Vector3d& fall, Out rows) const = 0;

  // Call it where the step is solved. Adds the body's own points that came within the margin of its
  // colliders unnoticed. True if there are any: the step must be solved with them.
  virtual bool add_missed() = 0;
  // Called once the step is solved. account: of contact with other bodies and of colliders that a
  // coupling handles. start: its energy at the start of the step, J. Then remember() each contact,
  // in any order, and call end(). jumped: a body of the island has.
  virtual void finish(const ContactAccount& account, double start, bool jumped) = 0;
  virtual void remember(const ContactMemory& memory) = 0;
  virtual void note(const ContactedPoint& point) = 0;  // a point of the body that had a force
  virtual int number_of(std::size_t point) const = 0;  // of its vertex, for note()
  virtual void end() = 0;
  // True if points of the body have moved at once since the end of the step before, so that contact
  // has another energy at the start of this one. Valid until finish().
  virtual bool jumped() const { return false; }
  // Called instead if the step has failed: the state is as before the step.
  virtual void give_up() = 0;
};

}  // namespace tremolo
