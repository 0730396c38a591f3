// Means over the points of a contact in a step.
#pragma once

#include <Eigen/Core>

#include "runtime/contact/contact_values.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

struct ContactSum {
  double impulse = 0.0;                                // sum of |F| h, N s
  Eigen::Vector3d push = Eigen::Vector3d::Zero();      // sum of F h, N s
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // weighted by impulse, m N s
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    // the same

  // sign: -1 for a point of the body's partner.
  void add(const ContactedPoint& point, double sign) {
    const double size = point.impulse.norm();
    impulse += size;
    push += sign * point.impulse;
    position += size * point.position;
    normal += (sign * size) * point.normal;
  }
  // Adds the step to the contact.
  void put_into(ContactPlace& place) const {
    place.impulse += impulse;
    place.push += push;
    if (impulse > 0.0) place.position = position / impulse;
    const double length = normal.norm();
    place.normal = length > 1e-9 * impulse ? Eigen::Vector3d(normal / length)
                                           : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
};

}  // namespace tremolo
