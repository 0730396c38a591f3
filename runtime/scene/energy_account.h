// Where a body's energy came from and where it went.
#pragma once

namespace tremolo {

// All in J. kinetic, potential: now; of a free body kinetic holds its motion as a whole, of a
// driven one it is that of the motion relative to its frame. contact: what is stored between the
// body and colliders now. The rest is what each cause has given since the start; what one took is
// negative. load: forces on vertices. support: the accelerations of the frame. contact_given:
// colliders that move and, of a driven body, its frame that moves along them. restitution,
// friction, damping: never positive. hand, joint: the hands and joints that hold it. contact_error:
// contact energy that a step found where the step before had left none; it should be zero, and is a
// part of what remains.
struct EnergyAccount {
  double kinetic = 0.0;
  double potential = 0.0;
  double contact = 0.0;
  double at_start = 0.0;  // kinetic + potential + contact then
  double load = 0.0;
  double support = 0.0;
  double gravity = 0.0;
  double contact_given = 0.0;
  double restitution = 0.0;
  double friction = 0.0;
  double hand = 0.0;
  double joint = 0.0;
  double damping = 0.0;
  double contact_error = 0.0;

  double total() const { return kinetic + potential + contact; }
  double given() const {
    return load + support + gravity + contact_given + restitution + friction + hand + joint +
           damping;
  }
  // What nobody accounts for.
  double remainder() const { return total() - at_start - given(); }
};

}  // namespace tremolo
