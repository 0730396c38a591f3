#include "runtime/tets/motion/tet_bound.h"

namespace tremolo {
namespace {

// A body that moves by less than this fraction of its size in a step is at rest up to rounding.
constexpr double kRoundingWay = 1e-9;

}  // namespace

bool TetBound::look(TetGroup& group) {
  double gravity = 0.0, rounding = 0.0;
  energy_ = 0.0;
  for (std::size_t i = 0; i < group.size(); ++i) {
    TetBody& body = group.body(i);
    energy_ += body.kinetic_energy() + body.elastic_energy() + group.contact(i).look().energy;
    gravity += body.gravity_energy();
    const double speed = kRoundingWay * body.model().rest_box().diagonal() / body.options().step;
    rounding += 0.5 * body.model().mass() * speed * speed;
  }
  if (!started_) bound_.start(energy_);
  bound_.put_in(started_ ? gravity_ - gravity : 0.0, rounding);
  started_ = true;
  gravity_ = gravity;
  if (!bound_.sound(energy_)) return false;
  bound_.take_off_what_is_lost(energy_, 0.0);
  return true;
}

}  // namespace tremolo
