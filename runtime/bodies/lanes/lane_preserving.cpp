#include "runtime/bodies/lanes/lane_preserving.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/packed_index.h"
#include "common/processor.h"
#include "runtime/bodies/lanes/lane_step.h"

namespace tremolo {
namespace {

using std::size_t;

constexpr int kMostSegments = 2;       // evaluations with the tangent
constexpr size_t kMostMeans = 3;       // evaluations of the mean alone
constexpr double kFilterShare = 1e-3;  // these three: see energy_preserving.cpp
constexpr double kSurplus = 1e-2;
constexpr double kFarthestFix = 0.1;

typedef float HalfVector __attribute__((vector_size(32), may_alias));
typedef std::int64_t LaneBits __attribute__((vector_size(64), may_alias));

}  // namespace

template <class Real>
struct VectorOf;
template <>
struct VectorOf<double> {
  typedef LaneVector Type;
};
template <>
struct VectorOf<float> {
  typedef HalfVector Type;
};

// Rows of an evaluation, `stride` bodies each.
template <class Real>
struct SegmentRows {
  Real *middle, *half, *mean, *tangent, *scratch;
  size_t stride;
};

// Half of a block in an evaluation: its lanes begin at `lane` of the rows.
template <class Real>
struct SegmentHalf {
  const LaneSystem& system;
  const LaneSpan& span;
  const SegmentRows<Real>& rows;
  size_t lane;
  double coordinate_scale, energy_scale;

  [[gnu::always_inline]] inline LaneVector& own(size_t first, size_t i) const {
    return *reinterpret_cast<LaneVector*>(span.scratch + (first + i) * kSolveLanes);
  }
  [[gnu::always_inline]] inline typename VectorOf<Real>::Type& at(Real* row, size_t i) const {
    return *reinterpret_cast<typename VectorOf<Real>::Type*>(row + i * rows.stride + lane);
  }
};

namespace {

[[gnu::always_inline]] inline void assign(const LaneVector& v, LaneVector& out) {
  out = v;
}
[[gnu::always_inline]] inline void assign(const LaneVector& v, HalfVector& out) {
  out = __builtin_convertvector(v, HalfVector);
}
[[gnu::always_inline]] inline void assign(const HalfVector& v, LaneVector& out) {
  out = __builtin_convertvector(v, LaneVector);
}

// middle and half of the segment from q0 to q0 + d.
template <class Real>
[[gnu::always_inline]] inline void set_segment(const SegmentHalf<Real>& half) {
  const LaneLayout& layout = half.system.layout;
  const double scale = 1.0 / half.coordinate_scale;
  for (size_t i = 0; i < half.system.modes; ++i) {
    const LaneVector s = 0.5 * half.own(layout.d, i);
    assign(scale * (half.own(layout.q0, i) + s), half.at(half.rows.middle, i));
    assign(scale * s, half.at(half.rows.half, i));
  }
}

// G in the lanes of the mask, from the mean of grad (C + Q).
template <class Real>
[[gnu::always_inline]] inline void take_mean(const SegmentHalf<Real>& half, const LaneMask& lanes) {
  const LaneLayout& layout = half.system.layout;
  const LaneBits mask = *reinterpret_cast<const LaneBits*>(lanes.value);
  const double scale = half.energy_scale / half.coordinate_scale;
  for (size_t i = 0; i < half.system.modes; ++i) {
    LaneVector mean;
    assign(half.at(half.rows.mean, i), mean);
    const LaneVector middle = half.own(layout.q0, i) + 0.5 * half.own(layout.d, i);
    const LaneVector G = scale * mean + half.system.lambda[i] * middle;
    LaneVector& to = half.own(layout.G, i);
    to = mask ? G : to;
  }
}

// Z in the lanes of the mask, from the tangent.
template <class Real>
[[gnu::always_inline]] inline void take_tangent(const SegmentHalf<Real>& half,
                                                const LaneMask& lanes) {
  const LaneBits mask = *reinterpret_cast<const LaneBits*>(lanes.value);
  const size_t r = half.system.modes;
  const double quarter = 0.25 * half.system.step * half.system.step;
  const double scale =
      quarter * (half.energy_scale / half.coordinate_scale / half.coordinate_scale);
  size_t entry = 0;
  for (size_t i = 0; i < r; ++i)
    for (size_t j = i; j < r; ++j, ++entry) {
      LaneVector tangent;
      assign(half.at(half.rows.tangent, pair_index(i, j)), tangent);
      LaneVector z = scale * tangent;
      if (i == j) z += quarter * half.system.lambda[i];
      LaneVector& to = half.own(half.system.layout.z, entry);
      to = mask ? z : to;
    }
}

TREMOLO_CLONES void begin_segment(const SegmentHalf<double>& half) {
  set_segment(half);
}
TREMOLO_CLONES void begin_segment(const SegmentHalf<float>& half) {
  set_segment(half);
}
TREMOLO_CLONES void end_segment(const SegmentHalf<double>& half, const LaneMask& lanes,
                                bool with_tangent) {
  take_mean(half, lanes);
  if (with_tangent) take_tangent(half, lanes);
}
TREMOLO_CLONES void end_segment(const SegmentHalf<float>& half, const LaneMask& lanes,
                                bool with_tangent) {
  take_mean(half, lanes);
  if (with_tangent) take_tangent(half, lanes);
}

template <class Real>
SegmentRows<Real> rows_in(AlignedDoubles& segments, size_t r) {
  constexpr size_t kStride = kBodiesPerBlock<Real>;
  Real* first = reinterpret_cast<Real*>(segments.data());
  SegmentRows<Real> rows{};
  rows.stride = kStride;
  for (auto [row, count] : {std::pair{&rows.middle, r}, std::pair{&rows.half, r},
                            std::pair{&rows.mean, r}, std::pair{&rows.tangent, pair_count(r)}}) {
    *row = first;
    first += count * kStride;
  }
  rows.scratch = first;
  return rows;
}

// Rows of 64 bytes for an evaluation.
size_t segment_rows(size_t r) {
  return 3 * r + pair_count(r) + segment_scratch_rows(r);
}

std::uint32_t low_bits(size_t count) {
  return count >= 32 ? ~0u : (1u << count) - 1u;
}

}  // namespace

bool preserves_energy_in_lanes(std::string_view integrator) {
  return integrator == "avf" || integrator == "ep2" || integrator == "ep4";
}

// The solve of one block's step. `open`: bits of the lanes that have not converged.
struct LanePreserving::Solve {
  LanePreserving& group;
  const Block& block;
  LanePreservingScratch& scratch;
  const LaneSystem& system;
  const LaneLayout& layout;
  size_t width;
  std::uint32_t open;
  std::uint32_t known;
  LaneNumbers ratio[2] = {};

  LaneSpan span(size_t half) const {
    return {scratch.rows.data() + half * layout.scratch_rows * kSolveLanes,
            group.saved(block.index, half)};
  }
  LaneMask mask(size_t half, std::uint32_t bits) const {
    return lane_mask(bits >> (half * kSolveLanes) & 0xffu);
  }
  template <class Part>
  void each(std::uint32_t bits, Part&& part) {
    for (size_t half = 0; half < width; ++half)
      if ((bits >> (half * kSolveLanes) & 0xffu) != 0) part(span(half), mask(half, bits), half);
  }
  double ratio_of(size_t lane) const { return ratio[lane / kSolveLanes].value[lane % kSolveLanes]; }

  void copy_in();
  void evaluate(std::uint32_t lanes, bool with_tangent);
  template <class Real>
  void evaluate_as(const SegmentCoefficients<Real>& segment, std::uint32_t lanes,
                   bool with_tangent);
  void make_filter(std::uint32_t lanes);
  void begin();
  void correct_from_segments();
  void correct_from_means();
  void accept(std::uint32_t lanes);
  void residual(std::uint32_t lanes) {
    each(lanes, [&](const LaneSpan& s, const LaneMask& m, size_t half) {
      evaluate_residual_lanes(system, s, m, ratio[half]);
    });
  }
  void move(std::uint32_t lanes, size_t count) {
    each(lanes,
         [&](const LaneSpan& s, const LaneMask& m, size_t) { move_lanes(system, s, count, m); });
  }
};

// q0, p0 and f of the block's lanes.
void LanePreserving::Solve::copy_in() {
  const size_t lanes = group.lanes_;
  for (size_t half = 0; half < width; ++half) {
    double* rows = span(half).scratch;
    for (size_t i = 0; i < system.modes; ++i) {
      const size_t from = i * lanes + half * kSolveLanes;
      std::copy_n(block.q + from, kSolveLanes, rows + (layout.q0 + i) * kSolveLanes);
      std::copy_n(block.p + from, kSolveLanes, rows + (layout.p0 + i) * kSolveLanes);
      double* f = rows + (layout.f + i) * kSolveLanes;
      if (block.f != nullptr)
        std::copy_n(block.f + from, kSolveLanes, f);
      else
        std::fill_n(f, kSolveLanes, 0.0);
    }
  }
}

template <class Real>
void LanePreserving::Solve::evaluate_as(const SegmentCoefficients<Real>& segment,
                                        std::uint32_t lanes, bool with_tangent) {
  const SegmentRows<Real> rows = rows_in<Real>(scratch.segments, system.modes);
  const auto half_at = [&](const LaneSpan& s, size_t half) {
    return SegmentHalf<Real>{
        system, s, rows, half * kSolveLanes, segment.coordinate_scale, segment.energy_scale};
  };
  for (size_t half = 0; half < width; ++half) {
    const LaneSpan s = span(half);
    begin_segment(half_at(s, half));
  }
  if (with_tangent)
    evaluate_segment(segment, rows.middle, rows.half, rows.scratch, rows.mean, rows.tangent);
  else
    evaluate_mean(segment, rows.middle, rows.half, rows.scratch, rows.mean);
  each(lanes, [&](const LaneSpan& s, const LaneMask& m, size_t half) {
    end_segment(half_at(s, half), m, with_tangent);
  });
}

void LanePreserving::Solve::evaluate(std::uint32_t lanes, bool with_tangent) {
  std::visit([&](const auto& segment) { evaluate_as(segment, lanes, with_tangent); },
             group.segment_);
}

void LanePreserving::Solve::make_filter(std::uint32_t lanes) {
  each(lanes, [&](const LaneSpan& s, const LaneMask& m, size_t) {
    filter_lanes(system, s, m);
    factor_lanes(system, s);
    enter_lanes(system, s, m);
  });
}

// The first residual: predicted from the step before where that is known.
void LanePreserving::Solve::begin() {
  copy_in();
  for (size_t half = 0; half < width; ++half) begin_lanes(system, span(half));
  const std::uint32_t fresh = open & ~known;
  if (fresh != 0) evaluate(fresh, true);
  for (size_t half = 0; half < width; ++half) recall_lanes(system, span(half), mask(half, known));
  each(fresh, [&](const LaneSpan& s, const LaneMask& m, size_t) { filter_lanes(system, s, m); });
  each(open, [&](const LaneSpan& s, const LaneMask& m, size_t half) {
    factor_lanes(system, s);
    enter_lanes(system, s, m);
    if ((known >> (half * kSolveLanes) & 0xffu) != 0) predict_lanes(system, s, mask(half, known));
  });
  residual(open);
}

// Corrections with a new N and Jacobian each, until N is that of the solution to its share of the
// tolerance. The lanes that are still not there leave `open`.
void LanePreserving::Solve::correct_from_segments() {
  std::uint32_t unsettled = open;
  for (int k = 0; k < kMostSegments && unsettled != 0; ++k) {
    move(unsettled, 0);
    const std::uint32_t predicted = k == 0 ? known & unsettled : 0u;
    each(predicted,
         [&](const LaneSpan& s, const LaneMask&, size_t) { move_prediction_lanes(system, s); });
    evaluate(unsettled, true);
    each(predicted,
         [&](const LaneSpan& s, const LaneMask& m, size_t) { miss_lanes(system, s, m); });
    make_filter(unsettled);
    residual(unsettled);
    std::uint32_t good = 0, still = 0;
    for (size_t lane = 0; lane < group.lanes_; ++lane) {
      const std::uint32_t bit = 1u << lane;
      if ((unsettled & bit) == 0) continue;
      const bool settled = !system.follows || kFilterShare * ratio_of(lane) < 1.0;
      const double enough = (predicted & bit) != 0 ? kSurplus : 1.0;
      if (!settled)
        still |= bit;
      else if (ratio_of(lane) <= enough)
        good |= bit;
    }
    accept(good);
    unsettled = still;
  }
  open &= ~unsettled;
}

void LanePreserving::Solve::correct_from_means() {
  for (size_t count = 0; count < kMostMeans && open != 0; ++count) {
    move(open, count);
    evaluate(open, false);
    residual(open);
    std::uint32_t good = 0;
    for (size_t lane = 0; lane < group.lanes_; ++lane)
      if ((open >> lane & 1u) != 0 && ratio_of(lane) <= 1.0) good |= 1u << lane;
    accept(good);
  }
}

// Finishes the step of these lanes, except those whose energy cannot be given back: they need a
// stricter solve.
void LanePreserving::Solve::accept(std::uint32_t lanes) {
  each(lanes, [&](const LaneSpan& s, const LaneMask&, size_t half) {
    LaneEnd end;
    end_lanes(system, s, end);
    std::uint32_t done = 0;
    for (size_t k = 0; k < kSolveLanes; ++k) {
      const size_t lane = half * kSolveLanes + k;
      if ((lanes >> lane & 1u) == 0) continue;
      if (!(std::abs(end.given_back.value[k]) <= kFarthestFix * end.kinetic.value[k])) continue;
      done |= 1u << lane;
      group.dissipated_[block.index * group.lanes_ + lane] = end.dissipated.value[k];
      for (size_t i = 0; i < system.modes; ++i) {
        block.q[i * group.lanes_ + lane] = s.scratch[(layout.q1 + i) * kSolveLanes + k];
        block.p[i * group.lanes_ + lane] = s.scratch[(layout.p1 + i) * kSolveLanes + k];
      }
    }
    save_lanes(system, s, mask(half, done));
    group.known_[block.index] |= done;
    open &= ~done;
  });
}

template <class Real>
LanePreserving LanePreserving::create(std::string_view integrator, Model::Pointer model,
                                      const IntegratorOptions& options,
                                      const LaneCoefficients<Real>& coefficients) {
  LanePreserving group;
  group.system_ = make_lane_system(integrator, *model, options);
  group.segment_ = make_segment_coefficients(coefficients, model->cubic(), model->quartic());
  group.lanes_ = kBodiesPerBlock<Real>;
  group.integrator_ = integrator;
  group.options_ = options;
  group.model_ = std::move(model);
  return group;
}

template LanePreserving LanePreserving::create(std::string_view, Model::Pointer,
                                               const IntegratorOptions&,
                                               const LaneCoefficients<double>&);
template LanePreserving LanePreserving::create(std::string_view, Model::Pointer,
                                               const IntegratorOptions&,
                                               const LaneCoefficients<float>&);

void LanePreserving::reserve(size_t blocks) {
  saved_.resize(blocks * width() * system_.layout.saved_rows * kSolveLanes, 0.0);
  known_.resize(blocks, 0u);
  dissipated_.resize(blocks * lanes_, 0.0);
}

void LanePreserving::make_scratch(LanePreservingScratch& scratch, size_t thread) {
  const size_t rows = width() * system_.layout.scratch_rows * kSolveLanes;
  if (scratch.rows.size() < rows) scratch.rows.resize(rows, 0.0);
  const size_t segments = segment_rows(system_.modes) * kSolveLanes;
  if (scratch.segments.size() < segments) scratch.segments.resize(segments, 0.0);
  if (lone_.size() <= thread) lone_.resize(thread + 1);
  Lone& lone = lone_[thread];
  const Eigen::Index r = model_->modes();
  lone.integrator = std::move(*make_integrator(integrator_, model_, options_));
  lone.state = {Eigen::VectorXd::Zero(r), Eigen::VectorXd::Zero(r)};
  lone.load = make_step_load(r);
}

void LanePreserving::forget(size_t slot) {
  known_[slot / lanes_] &= ~(1u << slot % lanes_);
}

void LanePreserving::move(size_t from, size_t to) {
  const auto first = [&](size_t slot) {
    const size_t lane = slot % lanes_;
    return saved(slot / lanes_, lane / kSolveLanes) + lane % kSolveLanes;
  };
  const double* source = first(from);
  double* target = first(to);
  for (size_t i = 0; i < system_.layout.saved_rows; ++i)
    target[i * kSolveLanes] = source[i * kSolveLanes];
  const bool known = (known_[from / lanes_] >> from % lanes_ & 1u) != 0;
  forget(from);
  forget(to);
  if (known) known_[to / lanes_] |= 1u << to % lanes_;
}

// A step by the solver of one body.
void LanePreserving::step_alone(const Block& block, size_t lane, Lone& lone, Failed& failed) {
  for (Eigen::Index i = 0; i < lone.state.q.size(); ++i) {
    const size_t at = static_cast<size_t>(i) * lanes_ + lane;
    lone.state.q[i] = block.q[at];
    lone.state.p[i] = block.p[at];
    const double f = block.f != nullptr ? block.f[at] : 0.0;
    lone.load.start[i] = lone.load.average[i] = lone.load.end[i] = f;
  }
  lone.load.active = lone.load.average.squaredNorm() > 0.0;
  lone.integrator->reset();
  const StepReport report = lone.integrator->step(lone.state, lone.load);
  if (!report.converged) {
    failed.all |= 1u << lane;
    if (report.iterations > 0 && std::isfinite(report.residual)) failed.gave_up |= 1u << lane;
    return;
  }
  dissipated_[block.index * lanes_ + lane] = report.dissipated;
  for (Eigen::Index i = 0; i < lone.state.q.size(); ++i) {
    const size_t at = static_cast<size_t>(i) * lanes_ + lane;
    block.q[at] = lone.state.q[i];
    block.p[at] = lone.state.p[i];
  }
}

LanePreserving::Failed LanePreserving::step(const Block& block, LanePreservingScratch& scratch,
                                            size_t thread) {
  const std::uint32_t all = low_bits(block.bodies);
  Solve solve{*this,          block,   scratch, system_,
              system_.layout, width(), all,     known_[block.index] & all};
  solve.begin();
  known_[block.index] = 0;
  solve.correct_from_segments();
  solve.correct_from_means();
  Failed failed;
  for (std::uint32_t alone = all & ~known_[block.index]; alone != 0; alone &= alone - 1) {
    const auto lane = static_cast<size_t>(std::countr_zero(alone));
    step_alone(block, lane, lone_[thread], failed);
  }
  return failed;
}

}  // namespace tremolo
