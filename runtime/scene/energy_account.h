// Where a body's energy came from and where it went.
#pragma once

namespace tremolo {

// All in J. kinetic, potential: now; of a free body kinetic holds its motion as a whole, of a
// driven one it is that of the motion relative to its frame. The rest is what each cause has given
// since the start; what one took is negative. load: forces on vertices. support: the accelerations
// of the frame. damping: never positive.
struct EnergyAccount {
  double kinetic = 0.0;
  double potential = 0.0;
  double at_start = 0.0;  // kinetic + potential then
  double load = 0.0;
  double support = 0.0;
  double gravity = 0.0;
  double contact = 0.0;
  double friction = 0.0;
  double damping = 0.0;

  double total() const { return kinetic + potential; }
  double given() const { return load + support + gravity + contact + friction + damping; }
  // What nobody accounts for.
  double remainder() const { return total() - at_start - given(); }
};

}  // namespace tremolo
