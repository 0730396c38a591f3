// The effects of contact on a body in a step: its energy balance, the impulses on colliders, and
// the points with a force.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "runtime/contact/contact_values.h"

namespace tremolo {

struct ContactRecord {
  ContactAccount account;  // energy balance
  // For each collider the sum of the lengths of the impulses on it, N s; 0 without contact.
  std::vector<double> impulses;
  std::vector<Eigen::Vector3d> collider_impulses;  // for each collider the sum, N s, world
  // The points with a contact force, first those on colliders. A point of another body on this
  // one's shape is listed by that body.
  std::vector<ContactedPoint> contacted;
  // Number of steps since the start that kept friction limits as a last resort (renewal() in
  // solve/contact_step.h).
  std::int64_t held_steps = 0;
  // Most energy that the rounding of positions at hands and joints may have given in the step, J.
  double rounding = 0.0;

  // Makes room for the contacts of that many points with that many colliders.
  void reserve(std::size_t points, std::size_t colliders);
  // Removes the last step. The energy that contact stored becomes its surplus.
  void reset();
  // Removes the last step; its energy balance is replaced by `begun`.
  void begin(const ContactAccount& begun);
  // Adds a part of a step to the sums of the parts before it.
  void add_part(const ContactRecord& part);

 private:
  void clear_contacts();
};

}  // namespace tremolo
