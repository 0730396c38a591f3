// The surface with which a body meets colliders and other bodies, and the law of its points. It
// does not change in a step.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/contact/solve/contact_points.h"

namespace tremolo {

struct ContactSurface {
  std::shared_ptr<const ContactPoints> points;
  std::optional<Collider> shape;  // with which other bodies collide
  ContactLaw law;                 // for a unit of area: stiffness is kappa, N/m^4
  // For each point c of friction.h divided by the square root of k, kg^1/2.
  std::vector<double> dampers;
  double mass = 0.0;      // of the body, kg
  bool can_move = false;  // no support fixes the body
  bool feels = true;      // false: only grabs act on it, not colliders

  const Collider* shape_or_null() const { return shape ? &*shape : nullptr; }
};

// Bounds of the positions of a body's points in a step. At its start all points are within radius +
// deformed of the centre.
struct ContactBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // in the world, m
  // All in m. Without contact no point goes farther than travel in the step.
  double radius = 0.0, deformed = 0.0, travel = 0.0;
};

// Bounds of a body's motion in a step.
struct StepWay {
  double bend = 0.0;  // of the displacement of its points by the coordinates, m
  double path = 0.0;  // of the displacement of its points, m; infinite on several bones
  double turn = 0.0;  // of the displacement by its rotation, for each metre from the centre
};

// mass: kg. free: no support fixes the body.
ContactSurface make_contact_surface(const Model::Pointer& model, const ContactOptions& contact,
                                    double mass, bool free);

// Bound of the rounding error of a distance, and of its change, near the body, m.
double distance_rounding(const ContactSurface& surface, const ContactBall& ball);
// The same for a body of that extent, m, at that distance from the world's origin, m.
double distance_rounding(double extent, double far);

// The law of a point of the surface against an obstacle with that friction and restitution, scaled
// by the point's area. rounding: distance_rounding(), m.
ContactLaw law_of(const ContactSurface& surface, std::size_t point, double friction,
                  double restitution, double rounding);
// The law of a point of the first body against the second. rounding: sum for the two, m.
ContactLaw law_between(const ContactSurface& first, std::size_t point, const ContactSurface& second,
                       double rounding);

}  // namespace tremolo
