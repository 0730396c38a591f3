// LaneGroup: the energies of a block, the energy put in, failed and quiet lanes.
#include <algorithm>
#include <cmath>

#include "runtime/bodies/lanes/lane_group.h"

namespace tremolo {

void LaneGroup::start_bounds(std::size_t block, const LaneScratch& scratch) {
  const std::size_t lanes = bodies_in(block);
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    EnergyBound& bound = bounds_[block * lanes_ + lane];
    if (!bound.started()) bound.start(flat(scratch.energy)[lane]);
  }
}

// Counts the work of the lanes that have not failed. A lane whose load alone is too large fails.
void LaneGroup::put_in(std::size_t block, Outcome& outcome, const LaneScratch& scratch) {
  const std::size_t lanes = bodies_in(block);
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const double kick = flat(scratch.kick)[lane];
    if (kick == 0.0) continue;
    const std::uint32_t bit = 1u << lane;
    if (!std::isfinite(kick)) outcome.failed |= bit;
    if ((outcome.failed & bit) != 0)
      outcome.loaded |= bit;
    else
      bounds_[block * lanes_ + lane].put_in(flat(scratch.work)[lane], kick);
  }
}

// A lane whose numbers overflowed had exploded if its kinetic energy before the step was already
// too large.
void LaneGroup::find_exploded(std::size_t block, Outcome& outcome,
                              const LaneScratch& scratch) const {
  const std::size_t lanes = bodies_in(block);
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    if ((outcome.failed >> lane & 1u) == 0) continue;
    double kinetic = 0.0;
    for (std::size_t i = 0; i < modes_; ++i) {
      const double p = flat(scratch.p.data())[i * lanes_ + lane];
      kinetic += 0.5 * p * p;
    }
    if (bounds_[block * lanes_ + lane].exceeded_by(kinetic)) outcome.exploded |= 1u << lane;
  }
  outcome.loaded &= ~outcome.exploded;
}

void LaneGroup::look(std::size_t block, Outcome& outcome, const LaneScratch& scratch) {
  const std::size_t lanes = bodies_in(block);
  std::uint32_t sound = 0;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    if ((outcome.failed >> lane & 1u) != 0) continue;
    const double energy = flat(scratch.energy)[lane];
    const double harmonic = flat(scratch.harmonic)[lane];
    const EnergyFound found = bounds_[block * lanes_ + lane].look(energy, harmonic);
    if (found == EnergyFound::kExploded) outcome.exploded |= 1u << lane;
    if (found == EnergyFound::kSound) sound |= 1u << lane;
  }
  outcome.failed |= outcome.exploded;
  copy_lanes(block, sound, q_, sound_q_);
  copy_lanes(block, sound, p_, sound_p_);
}

void LaneGroup::copy_lanes(std::size_t block, std::uint32_t lanes, const std::vector<LaneRow>& from,
                           std::vector<LaneRow>& to) const {
  const std::size_t first = block * block_rows();
  if (lanes == (1u << bodies_in(block)) - 1u) {  // the lanes after them are zero in both
    std::copy_n(&from[first], block_rows(), &to[first]);
    return;
  }
  const double* source = flat(&from[first]);
  double* target = flat(&to[first]);
  for (std::size_t at = 0; at < modes_ * lanes_; ++at)
    if ((lanes >> (at % lanes_) & 1u) != 0) target[at] = source[at];
}

std::uint32_t LaneGroup::quiet_lanes(std::size_t block, const QuietRule& rule,
                                     const LaneScratch& scratch) {
  std::uint32_t bits = 0;
  double* quiet = flat(quiet_time_.data()) + block * lanes_;
  const double* energy = flat(scratch.energy);
  const std::size_t lanes = bodies_in(block);
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const bool below = energy[lane] <= rule.threshold;
    quiet[lane] = below ? quiet[lane] + rule.since_last * step_ : 0.0;
    if (below && quiet[lane] >= rule.time) bits |= 1u << lane;
  }
  return bits;
}

}  // namespace tremolo
