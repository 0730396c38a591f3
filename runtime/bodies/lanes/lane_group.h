// Awake bodies of one model that step together, one body per lane: `verlet`, `imexv-linear`, `avf`,
// `ep2` and `ep4`. An EnergyBound checks each lane.
//
// The energy-preserving ones solve their equation (runtime/bodies/lanes/lane_preserving.h). The
// other two are conditionally stable (their files give the limit). Both are one formula
// (runtime/bodies/reduced/integrators/imexv/imexv_linear.cpp; verlet is the split with every row
// low) and have no equation to solve. State, linear force, load, damping and sums are always in
// double; the precision is that of grad (C + Q) and its tangent alone
// (runtime/bodies/lanes/lane_force.h, lane_segment.h). Therefore a small motion is exact to double,
// and rounding errors of the state do not accumulate.
//
// Layout: blocks of kBodiesPerBlock bodies; in a block [coordinate][lane], 64 or 128 bytes per row.
// Slots 0..size-1 are used without gaps; the lanes after them are zero.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/lanes/lane_force.h"
#include "runtime/bodies/lanes/lane_preserving.h"
#include "runtime/bodies/lanes/lane_step.h"
#include "runtime/crowd.h"
#include "runtime/energy_bound.h"
#include "runtime/integrator.h"
#include "runtime/model.h"

namespace tremolo {

// True for the methods that a LaneGroup has.
bool steps_in_lanes(std::string_view integrator);

struct alignas(64) LaneRow {
  double value[8];
};

// Buffers for one thread and block. LaneGroup::make_scratch sets their size.
struct LaneScratch {
  std::vector<LaneRow> q, p;         // before the step
  std::vector<LaneRow> x, gradient;  // of evaluate_lanes, in its precision
  LaneRow energy[2], harmonic[2];    // J
  LaneRow work[2], kick[2];          // J, of the step's load
  LanePreservingScratch preserving;
  std::size_t thread = 0;  // of the crowd
};

class LaneGroup {
 public:
  // modes: leading coordinates that move, 1 .. model.modes(); all of them for the energy-preserving
  // methods. integrator: one in lanes. options as for make_integrator, valid: step, alpha, beta,
  // split, and those of the solve. Errors (kUsage): same as for choose_split.
  static Result<LaneGroup> create(const Model::Pointer& model, std::string_view integrator,
                                  const IntegratorOptions& options, std::size_t modes,
                                  LanePrecision precision);

  std::size_t modes() const { return modes_; }
  std::size_t lanes() const { return lanes_; }  // bodies per block
  std::size_t size() const { return size_; }    // bodies
  std::size_t blocks() const { return (size_ + lanes_ - 1) / lanes_; }

  // Memory for this number of bodies; up to it insert() does not allocate.
  void reserve(std::size_t bodies);
  void make_scratch(LaneScratch& scratch);  // grows it to the size for step_block

  // A body in a lane is identified by its slot. saved: 4 x modes, its q and p and those of the last
  // valid check (runtime/energy_bound.h). remove() moves the last body into the freed slot.
  std::size_t insert(const double* saved, const EnergyBound& bound);
  void save(std::size_t slot, double* saved, EnergyBound& bound) const;
  void remove(std::size_t slot);
  // q, p: `modes` long. A state that is written counts as valid, at any energy.
  void read(std::size_t slot, double* q, double* p) const;
  void write(std::size_t slot, const double* q, const double* p);

  // Energy taken by damping in the last step, J; 0 for a method that does not preserve energy.
  double dissipated(std::size_t slot) const {
    return preserving_ ? preserving_->dissipated(slot) : 0.0;
  }

  // Adds a reduced force that acts on the next step only, `modes` long.
  void add_force(std::size_t slot, const double* force);

  // Results for the lanes of a block in a step, one bit each.
  struct Outcome {
    // A number is not finite, or a check found the energy far too high: the lane has returned to
    // its last valid check.
    std::uint32_t failed = 0;
    std::uint32_t exploded = 0;  // failed lanes whose energy was far too high
    std::uint32_t loaded = 0;    // the other failed lanes with a load
    std::uint32_t gave_up = 0;   // failed lanes whose solve did not converge
    std::uint32_t quiet = 0;     // T + V has been at or below `threshold` for `time`
  };
  // The condition for a quiet lane.
  struct QuietRule {
    double threshold = 0.0;  // J
    double time = 0.0;       // s
    int since_last = 0;      // steps since the last check of energies; 0: no check now
  };

  // Steps all bodies of a block. Different blocks may be stepped by different threads. No lane's
  // result depends on the other lanes. Nothing is allocated.
  Outcome step_block(std::size_t block, const QuietRule& rule, LaneScratch& scratch);

 private:
  LaneGroup() = default;
  static double* flat(LaneRow* rows) { return reinterpret_cast<double*>(rows); }
  static const double* flat(const LaneRow* rows) { return reinterpret_cast<const double*>(rows); }
  std::size_t block_rows() const { return modes_ * lanes_ / 8; }  // LaneRows of a block
  // The index of a slot's coordinate 0 among the doubles of q_; the others follow `lanes` apart.
  std::size_t offset(std::size_t slot) const {
    return slot / lanes_ * modes_ * lanes_ + slot % lanes_;
  }
  template <class Real>
  void evaluate(const LaneCoefficients<Real>& coefficients, const BlockArrays& block,
                bool want_energy, LaneScratch& scratch);
  void start_bounds(std::size_t block, const LaneScratch& scratch);
  void put_in(std::size_t block, Outcome& outcome, const LaneScratch& scratch);
  void find_exploded(std::size_t block, Outcome& outcome, const LaneScratch& scratch) const;
  void look(std::size_t block, Outcome& outcome, const LaneScratch& scratch);
  void copy_lanes(std::size_t block, std::uint32_t lanes, const std::vector<LaneRow>& from,
                  std::vector<LaneRow>& to) const;
  std::size_t bodies_in(std::size_t block) const {
    return std::min(lanes_, size_ - block * lanes_);
  }
  std::uint32_t quiet_lanes(std::size_t block, const QuietRule& rule, const LaneScratch& scratch);

  std::size_t modes_ = 0;
  std::size_t lanes_ = 0;
  std::size_t size_ = 0;
  std::size_t low_ = 0;  // rows before it are explicit
  double step_ = 0.0;
  bool damped_ = false;
  std::vector<double> lambda_;
  std::vector<double> decay_;    // DampedKick's on low rows, 1 on high rows
  std::vector<double> reach_;    // DampedKick's on low rows; h/2 on high rows
  std::vector<LinearRow> rows_;  // used on high rows
  std::variant<LaneCoefficients<double>, LaneCoefficients<float>> coefficients_;

  std::optional<LanePreserving> preserving_;

  // force_: R_s of BlockArrays.
  std::vector<LaneRow> q_, p_, force_, load_;
  std::vector<LaneRow> sound_q_, sound_p_;  // at the last valid check
  std::vector<EnergyBound> bounds_;         // one per slot
  std::vector<LaneRow> quiet_time_;         // s, one row of lanes per block
  std::vector<std::uint8_t> dirty_;         // one per block: kForceDirty, kBoundNew
  std::vector<std::uint8_t> loaded_;
};

}  // namespace tremolo
