// The check of linear momentum over the run of a world.
//
// For the bodies that nothing holds (free, rigid, guests without fixed vertices and drag) every
// change of momentum must have a cause: gravity, hands, joints, colliders, and bodies that are
// held. The forces between such bodies must cancel. The check sums, over bodies and steps,
//
//     R = change of momentum - h (mass g + forces of hands, joints, colliders)
//         + h (contact forces of other bodies on those that are held)
//
// from the momenta of the bodies and the impulses that contact reports, which are computed apart.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/mixed/mixed_guests.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

class WorldMomentum {
 public:
  // Call it at the start and after every step. guests: null: the world has none.
  void observe(const SceneWorld& world, const MixedGuests* guests);

  // The largest |R| of all steps, relative to the momentum that was there or was exchanged: the sum
  // of |p| at the start and of the lengths of all impulses since; 0 where nothing moved but by
  // rounding (kRoundedMove).
  double error() const { return exchanged_ > at_rest_ ? largest_ / exchanged_ : 0.0; }

 private:
  // The impulses on a body in a step, N s, world.
  struct Impulses {
    Eigen::Vector3d all = Eigen::Vector3d::Zero();           // of contact
    Eigen::Vector3d of_colliders = Eigen::Vector3d::Zero();  // the part by colliders
    Eigen::Vector3d hands = Eigen::Vector3d::Zero();
  };
  struct Known {
    bool free = false;                                   // nothing holds it
    bool asleep = false;                                 // in the step before
    double mass = 0.0;                                   // kg
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  // after the step before, kg m/s
  };

  static Impulses impulses_of(const ContactBody& body);
  static Known start_of(const MixedGuests& guests, std::size_t guest);
  void add(Known& known, const Eigen::Vector3d& momentum, bool asleep, const Impulses& impulses,
           const Eigen::Vector3d& gravity);
  void add_at_rest(const Known& known, double size);  // size: of the body, m
  void add_joints(const SceneWorld& world, const MixedGuests* guests);

  std::vector<Known> known_;                        // bodies of the world, then guests
  Eigen::Vector3d rest_ = Eigen::Vector3d::Zero();  // R, kg m/s
  double largest_ = 0.0, exchanged_ = 0.0;          // kg m/s
  double at_rest_ = 0.0;  // kg m/s, sum over the bodies that nothing holds: that of kRoundedMove
  double step_ = 0.0;     // s
};

}  // namespace tremolo
