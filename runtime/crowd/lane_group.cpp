#include "runtime/crowd/lane_group.h"

#include <algorithm>
#include <cmath>

#include "common/clones.h"
#include "runtime/integrators/solve/damping.h"

namespace tremolo {

typedef double Vector __attribute__((vector_size(64), may_alias));
typedef float HalfVector __attribute__((vector_size(32), may_alias));

// A block's arrays: r rows of `width` vectors, one of 8 lanes or two.
struct LaneBlock {
  std::size_t modes;
  std::size_t low;
  std::size_t width;
  double step;
  const double* lambda;
  const double* decay;  // with reach: null without damping
  const double* reach;
  const double* stiff;
  const double* drift;
  const double* change;
  Vector* q;
  Vector* p;
  Vector* force;
  const Vector* load;  // null: none
};

namespace {

// Of a block: the force is not that of q; a lane's EnergyBound has not started.
constexpr std::uint8_t kStale = 1, kFresh = 2, kBoth = 3;

Vector* vectors(LaneRow* rows) {
  return reinterpret_cast<Vector*>(rows);
}

// p <- p + (h/2) (f - R_s), on a damped low row the kick of runtime/integrators/solve/damping.h.
[[gnu::always_inline]] inline void kick(const LaneBlock& b, std::size_t i, std::size_t at) {
  const Vector force = b.load != nullptr ? b.load[at] - b.force[at] : -b.force[at];
  if (b.decay != nullptr)
    b.p[at] = b.decay[i] * b.p[at] + b.reach[i] * force;
  else
    b.p[at] += (0.5 * b.step) * force;
}

TREMOLO_CLONES void kick_and_drift(const LaneBlock& b) {
  const double h = b.step;
  for (std::size_t i = 0; i < b.modes; ++i)
    for (std::size_t at = i * b.width; at < (i + 1) * b.width; ++at) {
      kick(b, i, at);
      if (i < b.low) {
        b.q[at] += h * b.p[at];
      } else {
        const Vector d = (h * b.p[at] - b.stiff[i] * b.q[at]) * b.drift[i];
        b.q[at] += d;
        b.p[at] += b.change[i] * (d / h - b.p[at]);
      }
    }
}

TREMOLO_CLONES void kick_again(const LaneBlock& b) {
  for (std::size_t i = 0; i < b.modes; ++i)
    for (std::size_t at = i * b.width; at < (i + 1) * b.width; ++at) kick(b, i, at);
}

// x = scale q.
TREMOLO_CLONES void to_lanes(const Vector* q, std::size_t count, double scale, double* x) {
  Vector* out = reinterpret_cast<Vector*>(x);
  for (std::size_t at = 0; at < count; ++at) out[at] = scale * q[at];
}
TREMOLO_CLONES void to_lanes(const Vector* q, std::size_t count, double scale, float* x) {
  HalfVector* out = reinterpret_cast<HalfVector*>(x);
  for (std::size_t at = 0; at < count; ++at)
    out[at] = __builtin_convertvector(scale * q[at], HalfVector);
}

// By reference: a vector is no argument where the caller may lack the registers for it.
[[gnu::always_inline]] inline void widen(const Vector& v, Vector& out) {
  out = v;
}
[[gnu::always_inline]] inline void widen(const HalfVector& v, Vector& out) {
  out = __builtin_convertvector(v, Vector);
}

// force = scale gradient, plus lambda q on the low rows.
template <class Part>
[[gnu::always_inline]] inline void gather_force(const LaneBlock& b, double scale,
                                                const Part* gradient) {
  for (std::size_t i = 0; i < b.modes; ++i) {
    const double lambda = i < b.low ? b.lambda[i] : 0.0;
    for (std::size_t at = i * b.width; at < (i + 1) * b.width; ++at) {
      Vector wide;
      widen(gradient[at], wide);
      b.force[at] = lambda * b.q[at] + scale * wide;
    }
  }
}
TREMOLO_CLONES void from_lanes(const LaneBlock& b, double scale, const double* gradient) {
  gather_force(b, scale, reinterpret_cast<const Vector*>(gradient));
}
TREMOLO_CLONES void from_lanes(const LaneBlock& b, double scale, const float* gradient) {
  gather_force(b, scale, reinterpret_cast<const HalfVector*>(gradient));
}

// energy, in: C + Q; out: T + V. harmonic: T and the quadratic part of V. All J, `width` vectors.
TREMOLO_CLONES void add_quadratic_energy(const LaneBlock& b, Vector* energy, Vector* harmonic) {
  for (std::size_t w = 0; w < b.width; ++w) {
    Vector sum = {};
    for (std::size_t i = 0; i < b.modes; ++i) {
      const std::size_t at = i * b.width + w;
      sum += 0.5 * (b.p[at] * b.p[at]) + (0.5 * b.lambda[i]) * (b.q[at] * b.q[at]);
    }
    energy[w] += sum;
    harmonic[w] = sum;
  }
}

// work: of the load from `before` to q. kick: 1/2 (h |f|)^2. J, `width` vectors.
TREMOLO_CLONES void sum_work(const LaneBlock& b, const Vector* before, Vector* work, Vector* kick) {
  for (std::size_t w = 0; w < b.width; ++w) {
    Vector done = {}, square = {};
    for (std::size_t at = w; at < b.modes * b.width; at += b.width) {
      done += b.load[at] * (b.q[at] - before[at]);
      square += b.load[at] * b.load[at];
    }
    work[w] = done;
    kick[w] = (0.5 * b.step * b.step) * square;
  }
}

// Bits of the lanes in which q, p or the force is not finite.
TREMOLO_CLONES std::uint32_t lanes_not_finite(const LaneBlock& b) {
  std::uint32_t bits = 0;
  for (std::size_t w = 0; w < b.width; ++w) {
    Vector zero = {};  // 0 x is 0 for a finite x alone
    for (std::size_t at = w; at < b.modes * b.width; at += b.width)
      zero += 0.0 * b.q[at] + 0.0 * b.p[at] + 0.0 * b.force[at];
    for (std::size_t lane = 0; lane < 8; ++lane)
      if (!(zero[lane] == 0.0)) bits |= 1u << (8 * w + lane);
  }
  return bits;
}

Result<std::size_t> low_rows(const Model& model, std::string_view integrator,
                             const IntegratorOptions& options, Eigen::Index modes) {
  if (integrator == "verlet") return static_cast<std::size_t>(modes);
  const Result<Split> split = choose_split(model.lambda().head(modes), options.step, options.split);
  if (!split) return split.error();
  return static_cast<std::size_t>(split->low);
}

}  // namespace

bool steps_in_lanes(std::string_view integrator) {
  return integrator == "verlet" || integrator == "imexv-linear";
}

Result<LaneGroup> LaneGroup::create(const Model& model, std::string_view integrator,
                                    const IntegratorOptions& options, std::size_t modes,
                                    LanePrecision precision) {
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
  const Eigen::ArrayXd divisor = midpoint_damping(rates, lambda, h).array();
  const Eigen::ArrayXd stiff = (0.5 * h * h) * divisor * lambda.array();
  const Eigen::ArrayXd drift = (1.0 + 0.5 * (stiff + h * divisor * rates.array())).inverse();
  const Eigen::ArrayXd change = 2.0 / divisor;
  group.lambda_.assign(lambda.begin(), lambda.end());
  group.decay_.assign(kick.decay().begin(), kick.decay().end());
  group.reach_.assign(kick.reach().begin(), kick.reach().end());
  group.stiff_.assign(stiff.begin(), stiff.end());
  group.drift_.assign(drift.begin(), drift.end());
  group.change_.assign(change.begin(), change.end());
  if (precision == LanePrecision::kDouble) {
    group.lanes_ = kBodiesPerBlock<double>;
    group.coefficients_ = make_lane_coefficients<double>(modes, model.cubic(), model.quartic());
  } else {
    group.lanes_ = kBodiesPerBlock<float>;
    group.coefficients_ = make_lane_coefficients<float>(modes, model.cubic(), model.quartic());
  }
  return group;
}

void LaneGroup::reserve(std::size_t bodies) {
  const std::size_t needed = (bodies + lanes_ - 1) / lanes_;
  if (needed <= stale_.size()) return;
  // Half as much again, so that bodies which come one by one are not copied each time.
  const std::size_t blocks = std::max(needed, stale_.size() + stale_.size() / 2);
  for (std::vector<LaneRow>* rows : {&q_, &p_, &force_, &load_, &sound_q_, &sound_p_})
    rows->resize(blocks * block_rows());
  bounds_.resize(blocks * lanes_);
  quiet_time_.resize(blocks * lanes_ / 8);
  stale_.resize(blocks, 0);
  loaded_.resize(blocks, 0);
}

void LaneGroup::make_scratch(LaneScratch& scratch) const {
  for (std::vector<LaneRow>* rows : {&scratch.q, &scratch.p, &scratch.x, &scratch.gradient})
    if (rows->size() < block_rows()) rows->resize(block_rows());
}

std::size_t LaneGroup::insert(const double* kept, const EnergyBound& bound) {
  reserve(size_ + 1);
  const std::size_t slot = size_++;
  const std::size_t first = place(slot);
  for (std::vector<LaneRow>* rows : {&q_, &p_, &sound_q_, &sound_p_})
    for (std::size_t i = 0; i < modes_; ++i) flat(rows->data())[first + i * lanes_] = *kept++;
  bounds_[slot] = bound;
  flat(quiet_time_.data())[slot] = 0.0;
  stale_[slot / lanes_] |= bound.started() ? kStale : kBoth;
  return slot;
}

void LaneGroup::save(std::size_t slot, double* kept, EnergyBound& bound) const {
  const std::size_t first = place(slot);
  for (const std::vector<LaneRow>* rows : {&q_, &p_, &sound_q_, &sound_p_})
    for (std::size_t i = 0; i < modes_; ++i) *kept++ = flat(rows->data())[first + i * lanes_];
  bound = bounds_[slot];
}

void LaneGroup::remove(std::size_t slot) {
  const std::size_t last = --size_;
  for (std::vector<LaneRow>* rows : {&q_, &p_, &force_, &load_, &sound_q_, &sound_p_}) {
    double* to = flat(rows->data()) + place(slot);
    double* from = flat(rows->data()) + place(last);
    for (std::size_t i = 0; i < modes_; ++i) {
      to[i * lanes_] = from[i * lanes_];
      from[i * lanes_] = 0.0;
    }
  }
  double* quiet = flat(quiet_time_.data());
  quiet[slot] = quiet[last];
  quiet[last] = 0.0;
  bounds_[slot] = bounds_[last];
  stale_[slot / lanes_] |= stale_[last / lanes_];
  loaded_[slot / lanes_] |= loaded_[last / lanes_];
}

void LaneGroup::read(std::size_t slot, double* q, double* p) const {
  for (std::size_t i = 0; i < modes_; ++i) {
    q[i] = flat(q_.data())[place(slot) + i * lanes_];
    p[i] = flat(p_.data())[place(slot) + i * lanes_];
  }
}

void LaneGroup::write(std::size_t slot, const double* q, const double* p) {
  for (std::size_t i = 0; i < modes_; ++i) {
    const std::size_t at = place(slot) + i * lanes_;
    flat(q_.data())[at] = flat(sound_q_.data())[at] = q[i];
    flat(p_.data())[at] = flat(sound_p_.data())[at] = p[i];
  }
  bounds_[slot].restart();
  flat(quiet_time_.data())[slot] = 0.0;
  stale_[slot / lanes_] |= kBoth;
}

void LaneGroup::add_force(std::size_t slot, const double* force) {
  double* load = flat(load_.data()) + place(slot);
  for (std::size_t i = 0; i < modes_; ++i) load[i * lanes_] += force[i];
  flat(quiet_time_.data())[slot] = 0.0;
  loaded_[slot / lanes_] = 1;
}

template <class Real>
void LaneGroup::evaluate(const LaneCoefficients<Real>& coefficients, const LaneBlock& view,
                         bool want_energy, LaneScratch& scratch) {
  Real* x = reinterpret_cast<Real*>(scratch.x.data());
  Real* gradient = reinterpret_cast<Real*>(scratch.gradient.data());
  alignas(64) Real energy[kBodiesPerBlock<Real>];
  to_lanes(view.q, view.modes * view.width, 1.0 / coefficients.coordinate_scale, x);
  evaluate_lanes(coefficients, x, gradient, want_energy ? energy : nullptr);
  from_lanes(view, coefficients.energy_scale / coefficients.coordinate_scale, gradient);
  if (!want_energy) return;
  double* out = flat(scratch.energy);
  for (std::size_t lane = 0; lane < lanes_; ++lane)
    out[lane] = coefficients.energy_scale * static_cast<double>(energy[lane]);
}

LaneGroup::Outcome LaneGroup::step_block(std::size_t block, const QuietRule& rule,
                                         LaneScratch& scratch) {
  const std::size_t first = block * block_rows();
  const LaneBlock view{.modes = modes_,
                       .low = low_,
                       .width = lanes_ / 8,
                       .step = step_,
                       .lambda = lambda_.data(),
                       .decay = damped_ ? decay_.data() : nullptr,
                       .reach = reach_.data(),
                       .stiff = stiff_.data(),
                       .drift = drift_.data(),
                       .change = change_.data(),
                       .q = vectors(&q_[first]),
                       .p = vectors(&p_[first]),
                       .force = vectors(&force_[first]),
                       .load = loaded_[block] != 0 ? vectors(&load_[first]) : nullptr};
  const auto evaluate_view = [&](bool want_energy) {
    std::visit([&](const auto& known) { evaluate(known, view, want_energy, scratch); },
               coefficients_);
  };
  if (stale_[block] != 0) evaluate_view((stale_[block] & kFresh) != 0);
  if ((stale_[block] & kFresh) != 0) {
    add_quadratic_energy(view, vectors(scratch.energy), vectors(scratch.harmonic));
    start_bounds(block, scratch);
  }
  stale_[block] = 0;
  std::copy_n(&q_[first], block_rows(), scratch.q.data());
  std::copy_n(&p_[first], block_rows(), scratch.p.data());
  kick_and_drift(view);
  evaluate_view(rule.since_last > 0);
  kick_again(view);
  Outcome outcome;
  outcome.failed = lanes_not_finite(view);
  if (loaded_[block] != 0) {
    sum_work(view, vectors(scratch.q.data()), vectors(scratch.work), vectors(scratch.kick));
    put_in(block, outcome, scratch);
    std::fill_n(&load_[first], block_rows(), LaneRow{});
    loaded_[block] = 0;
  }
  if (outcome.failed != 0) tell_exploded(block, outcome, scratch);
  if (rule.since_last > 0) {
    add_quadratic_energy(view, vectors(scratch.energy), vectors(scratch.harmonic));
    look(block, outcome, scratch);
    outcome.quiet = quiet_lanes(block, rule, scratch);
  }
  if (outcome.failed != 0) {
    copy_lanes(block, outcome.failed, sound_q_, q_);
    copy_lanes(block, outcome.failed, sound_p_, p_);
    stale_[block] |= kStale;
  }
  return outcome;
}

}  // namespace tremolo
