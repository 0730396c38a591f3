#include "runtime/bodies/lanes/lane_group.h"

#include <algorithm>
#include <cmath>

#include "runtime/bodies/lanes/lane_step.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"

namespace tremolo {

namespace {

// Dirty flags of a block: the force is not that of q; some lane's EnergyBound has not started.
constexpr std::uint8_t kForceDirty = 1, kBoundNew = 2, kBothDirty = 3;

LaneVector* vectors(LaneRow* rows) {
  return reinterpret_cast<LaneVector*>(rows);
}

Result<std::size_t> low_rows(const Model& model, std::string_view integrator,
                             const IntegratorOptions& options, Eigen::Index modes) {
  if (integrator == "verlet" || preserves_energy_in_lanes(integrator))
    return static_cast<std::size_t>(modes);
  const Result<Split> split = choose_split(model.lambda().head(modes), options.step, options.split);
  if (!split) return split.error();
  return static_cast<std::size_t>(split->low);
}

}  // namespace

bool steps_in_lanes(std::string_view integrator) {
  return integrator == "verlet" || integrator == "imexv-linear" ||
         preserves_energy_in_lanes(integrator);
}

Result<LaneGroup> LaneGroup::create(const Model::Pointer& model_pointer,
                                    std::string_view integrator, const IntegratorOptions& options,
                                    std::size_t modes, LanePrecision precision) {
  const Model& model = *model_pointer;
  const auto r = static_cast<Eigen::Index>(modes);
  const Result<std::size_t> low = low_rows(model, integrator, options, r);
  if (!low) return low.error();
  LaneGroup group;
  group.modes_ = modes;
  group.low_ = *low;
  group.step_ = options.step;
  group.damped_ = options.alpha > 0.0 || options.beta > 0.0;
  const Eigen::VectorXd lambda = model.lambda().head(r);
  const Split split{static_cast<Eigen::Index>(*low), r - static_cast<Eigen::Index>(*low)};
  const double h = options.step;
  const Eigen::VectorXd rates = damping_rates(lambda, options.alpha, options.beta);
  Eigen::VectorXd low_rates = rates;
  low_rates.tail(split.high).setZero();
  const DampedKick kick(low_rates, h);
  const Eigen::VectorXd g = midpoint_damping(rates, lambda, h);
  group.lambda_.assign(lambda.begin(), lambda.end());
  group.decay_.assign(kick.decay().begin(), kick.decay().end());
  group.reach_.assign(kick.reach().begin(), kick.reach().end());
  for (Eigen::Index i = 0; i < r; ++i)
    group.rows_.push_back(make_linear_row(rates[i], g[i], lambda[i], h));
  if (precision == LanePrecision::kDouble) {
    group.lanes_ = kBodiesPerBlock<double>;
    group.coefficients_ = make_lane_coefficients<double>(modes, model.cubic(), model.quartic());
  } else {
    group.lanes_ = kBodiesPerBlock<float>;
    group.coefficients_ = make_lane_coefficients<float>(modes, model.cubic(), model.quartic());
  }
  if (preserves_energy_in_lanes(integrator))
    std::visit(
        [&](const auto& known) {
          group.preserving_ = LanePreserving::create(integrator, model_pointer, options, known);
        },
        group.coefficients_);
  return group;
}

void LaneGroup::reserve(std::size_t bodies) {
  const std::size_t needed = (bodies + lanes_ - 1) / lanes_;
  if (needed <= dirty_.size()) return;
  // Half as much again, so that bodies added one by one are not copied each time.
  const std::size_t blocks = std::max(needed, dirty_.size() + dirty_.size() / 2);
  for (std::vector<LaneRow>* rows : {&q_, &p_, &force_, &load_, &sound_q_, &sound_p_})
    rows->resize(blocks * block_rows());
  bounds_.resize(blocks * lanes_);
  quiet_time_.resize(blocks * lanes_ / 8);
  dirty_.resize(blocks, 0);
  loaded_.resize(blocks, 0);
  if (preserving_) preserving_->reserve(blocks);
}

void LaneGroup::make_scratch(LaneScratch& scratch) {
  for (std::vector<LaneRow>* rows : {&scratch.q, &scratch.p, &scratch.x, &scratch.gradient})
    if (rows->size() < block_rows()) rows->resize(block_rows());
  if (preserving_) preserving_->make_scratch(scratch.preserving, scratch.thread);
}

std::size_t LaneGroup::insert(const double* saved, const EnergyBound& bound) {
  reserve(size_ + 1);
  const std::size_t slot = size_++;
  const std::size_t first = offset(slot);
  for (std::vector<LaneRow>* rows : {&q_, &p_, &sound_q_, &sound_p_})
    for (std::size_t i = 0; i < modes_; ++i) flat(rows->data())[first + i * lanes_] = *saved++;
  bounds_[slot] = bound;
  flat(quiet_time_.data())[slot] = 0.0;
  dirty_[slot / lanes_] |= bound.started() ? kForceDirty : kBothDirty;
  if (preserving_) preserving_->forget(slot);
  return slot;
}

void LaneGroup::save(std::size_t slot, double* saved, EnergyBound& bound) const {
  const std::size_t first = offset(slot);
  for (const std::vector<LaneRow>* rows : {&q_, &p_, &sound_q_, &sound_p_})
    for (std::size_t i = 0; i < modes_; ++i) *saved++ = flat(rows->data())[first + i * lanes_];
  bound = bounds_[slot];
}

void LaneGroup::remove(std::size_t slot) {
  const std::size_t last = --size_;
  for (std::vector<LaneRow>* rows : {&q_, &p_, &force_, &load_, &sound_q_, &sound_p_}) {
    double* to = flat(rows->data()) + offset(slot);
    double* from = flat(rows->data()) + offset(last);
    for (std::size_t i = 0; i < modes_; ++i) {
      to[i * lanes_] = from[i * lanes_];
      from[i * lanes_] = 0.0;
    }
  }
  double* quiet = flat(quiet_time_.data());
  quiet[slot] = quiet[last];
  quiet[last] = 0.0;
  bounds_[slot] = bounds_[last];
  dirty_[slot / lanes_] |= dirty_[last / lanes_];
  loaded_[slot / lanes_] |= loaded_[last / lanes_];
  if (preserving_) preserving_->move(last, slot);
}

void LaneGroup::read(std::size_t slot, double* q, double* p) const {
  for (std::size_t i = 0; i < modes_; ++i) {
    q[i] = flat(q_.data())[offset(slot) + i * lanes_];
    p[i] = flat(p_.data())[offset(slot) + i * lanes_];
  }
}

void LaneGroup::write(std::size_t slot, const double* q, const double* p) {
  for (std::size_t i = 0; i < modes_; ++i) {
    const std::size_t at = offset(slot) + i * lanes_;
    flat(q_.data())[at] = flat(sound_q_.data())[at] = q[i];
    flat(p_.data())[at] = flat(sound_p_.data())[at] = p[i];
  }
  bounds_[slot].restart();
  flat(quiet_time_.data())[slot] = 0.0;
  dirty_[slot / lanes_] |= kBothDirty;
  if (preserving_) preserving_->forget(slot);
}

void LaneGroup::add_force(std::size_t slot, const double* force) {
  double* load = flat(load_.data()) + offset(slot);
  for (std::size_t i = 0; i < modes_; ++i) load[i * lanes_] += force[i];
  flat(quiet_time_.data())[slot] = 0.0;
  loaded_[slot / lanes_] = 1;
}

template <class Real>
void LaneGroup::evaluate(const LaneCoefficients<Real>& coefficients, const BlockArrays& view,
                         bool want_energy, LaneScratch& scratch) {
  Real* x = reinterpret_cast<Real*>(scratch.x.data());
  Real* gradient = reinterpret_cast<Real*>(scratch.gradient.data());
  alignas(64) Real energy[kBodiesPerBlock<Real>];
  to_lanes(view.q, view.modes * view.width, 1.0 / coefficients.coordinate_scale, x);
  evaluate_lanes(coefficients, x, gradient, want_energy ? energy : nullptr);
  set_force(view, coefficients.energy_scale / coefficients.coordinate_scale, gradient);
  if (!want_energy) return;
  double* out = flat(scratch.energy);
  for (std::size_t lane = 0; lane < lanes_; ++lane)
    out[lane] = coefficients.energy_scale * static_cast<double>(energy[lane]);
}

LaneGroup::Outcome LaneGroup::step_block(std::size_t block, const QuietRule& rule,
                                         LaneScratch& scratch) {
  const std::size_t first = block * block_rows();
  const BlockArrays view{.modes = modes_,
                         .low = low_,
                         .width = lanes_ / 8,
                         .h = step_,
                         .lambda = lambda_.data(),
                         .decay = damped_ ? decay_.data() : nullptr,
                         .reach = reach_.data(),
                         .rows = rows_.data(),
                         .q = vectors(&q_[first]),
                         .p = vectors(&p_[first]),
                         .R_s = vectors(&force_[first]),
                         .f = loaded_[block] != 0 ? vectors(&load_[first]) : nullptr};
  const auto evaluate_view = [&](bool want_energy) {
    std::visit([&](const auto& known) { evaluate(known, view, want_energy, scratch); },
               coefficients_);
  };
  if (dirty_[block] != 0) evaluate_view((dirty_[block] & kBoundNew) != 0);
  if ((dirty_[block] & kBoundNew) != 0) {
    add_quadratic_energy(view, vectors(scratch.energy), vectors(scratch.harmonic));
    start_bounds(block, scratch);
  }
  dirty_[block] = 0;
  std::copy_n(&q_[first], block_rows(), scratch.q.data());
  std::copy_n(&p_[first], block_rows(), scratch.p.data());
  Outcome outcome;
  if (preserving_) {
    const LanePreserving::Failed failed =
        preserving_->step({block, bodies_in(block), flat(&q_[first]), flat(&p_[first]),
                           loaded_[block] != 0 ? flat(&load_[first]) : nullptr},
                          scratch.preserving, scratch.thread);
    if (rule.since_last > 0) evaluate_view(true);
    outcome.gave_up = failed.gave_up;
    outcome.failed = lanes_not_finite(view) | failed.all;
  } else {
    kick_and_drift(view);
    evaluate_view(rule.since_last > 0);
    kick_again(view);
    outcome.failed = lanes_not_finite(view);
  }
  if (loaded_[block] != 0) {
    sum_work(view, vectors(scratch.q.data()), vectors(scratch.work), vectors(scratch.kick));
    put_in(block, outcome, scratch);
    std::fill_n(&load_[first], block_rows(), LaneRow{});
    loaded_[block] = 0;
  }
  if (outcome.failed != 0) find_exploded(block, outcome, scratch);
  if (rule.since_last > 0) {
    add_quadratic_energy(view, vectors(scratch.energy), vectors(scratch.harmonic));
    look(block, outcome, scratch);
    outcome.quiet = quiet_lanes(block, rule, scratch);
  }
  if (outcome.failed != 0) {
    copy_lanes(block, outcome.failed, sound_q_, q_);
    copy_lanes(block, outcome.failed, sound_p_, p_);
    dirty_[block] |= kForceDirty;
    for (std::size_t lane = 0; preserving_ && lane < lanes_; ++lane)
      if ((outcome.failed >> lane & 1u) != 0) preserving_->forget(block * lanes_ + lane);
  }
  return outcome;
}

}  // namespace tremolo
