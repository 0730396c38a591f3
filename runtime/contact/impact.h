// Hard impacts of rigid bodies: how short a step must be for their rebound.
//
// Restitution takes nothing of the speed that a pair has at the deepest end of a step, so that
// steps must be short beside the contact (docs/theory.md, section "Contact"). With the stiffness S
// of all points that come into contact with the speed v, m v^2/2 = S x^3/3 at the depth x, and the
// contact takes some 3 x/v; where the law is linear, half a period. At the turning point the speed
// changes by the acceleration a in the length of a step, and that change is what restitution
// misses.
//
// A body that hits while another pushes it along the same line, as a domino of a falling row does,
// has no rebound of its own. In large islands such hits are resolved less finely; restitution is
// then 0.03 too large.
#pragma once

#include <span>

#include <Eigen/Core>

#include "runtime/contact/contact_law.h"

namespace tremolo {

// A rigid body at the start of a step, in the world.
struct ImpactBody {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();        // of mass, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      // m/s
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();          // rad/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // by gravity, m/s^2
  double mass = 0.0;                                       // kg
  // Sum of F F^T/|F| over the contact forces F of each pair at the start, N.
  Eigen::Matrix3d pressed = Eigen::Matrix3d::Zero();

  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const {
    return velocity + spin.cross(x - centre);
  }
};

// A point of the body a that may come into contact in the step with the body b or a collider.
struct ImpactPoint {
  static constexpr std::size_t kCollider = static_cast<std::size_t>(-1);
  std::size_t a = 0, b = kCollider;
  ContactLaw law;
  double distance = 0.0, energy = 0.0;                 // d0, m; psi(d0), J
  Eigen::Vector3d place = Eigen::Vector3d::Zero();     // m, world
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   // out of b or the collider, length 1
  Eigen::Vector3d collider = Eigen::Vector3d::Zero();  // velocity of the collider there, m/s
};

// Returns the longest step, s, with which the impacts of a step of h, s, are resolved; infinity
// where nothing hits hard. The contact forces are added to the accelerations of the bodies. points:
// those of the same two bodies are next to each other. inside: an impact is under way, so that an
// acceleration counts as much as a speed. Otherwise it may be that of a body that is pressed on.
double longest_for_impacts(std::span<ImpactBody> bodies, std::span<const ImpactPoint> points,
                           double h, bool inside);

}  // namespace tremolo
