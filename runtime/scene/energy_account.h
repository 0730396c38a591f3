// Energy balance of a body: what it has now and what each cause has given.
#pragma once

namespace tremolo {

// All in J. The fields from `load` on are energy given since the start; a negative value was taken.
struct EnergyAccount {
  // Now; of a free body with its motion as a whole, of a driven one relative to its frame.
  double kinetic = 0.0;
  double potential = 0.0;  // now
  double contact = 0.0;    // now, stored between the body and colliders
  double at_start = 0.0;   // kinetic + potential + contact at the start
  double load = 0.0;       // by forces on vertices
  double support = 0.0;    // by accelerations of the frame
  double gravity = 0.0;
  double contact_given =
      0.0;                   // by moving colliders, and by a driven body's frame moving along them
  double restitution = 0.0;  // never positive
  double friction = 0.0;     // never positive
  double hand = 0.0;         // by hands that hold the body
  double joint = 0.0;        // by joints that hold the body
  double damping = 0.0;      // never positive
  // Contact energy that a step found although the step before had left none. It should be zero, and
  // is part of remainder().
  double contact_error = 0.0;

  double total() const { return kinetic + potential + contact; }
  double given() const {
    return load + support + gravity + contact_given + restitution + friction + hand + joint +
           damping;
  }
  // The error of the balance: energy without a known cause.
  double remainder() const { return total() - at_start - given(); }
};

}  // namespace tremolo
