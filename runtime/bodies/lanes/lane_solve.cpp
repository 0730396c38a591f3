#include "runtime/bodies/lanes/lane_solve.h"

#include <algorithm>

#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"

namespace tremolo {
namespace {

// Squares of a column below the first subdiagonal that sum to less are left out: they would
// underflow, and reflections made of them would not be orthogonal.
constexpr double kNegligibleSquare = 1e-280;

constexpr double kFarthestFix = 0.1;  // as for give_back()

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/bodies/lanes/lane_solve.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {

using std::size_t;

LaneLayout::LaneLayout(size_t r) {
  const size_t entries = r * (r + 1) / 2;
  u = 0;
  reflection = r < 1 ? 0 : r * (r - 1) / 2;
  diagonal = reflection + r;
  off = diagonal + r;
  filter_rows = off + r;
  size_t next = 0;
  const auto take = [&next](size_t rows) {
    const size_t first = next;
    next += rows;
    return first;
  };
  for (size_t* first :
       {&q0, &p0, &f, &d, &G, &predicted, &d_hat, &dp_hat, &b_hat, &g_hat, &x, &y, &q1, &p1})
    *first = take(r);
  moves = take(kMostLaneMoves * r);
  z = take(entries);
  factor = take(entries);
  filter = take(filter_rows);
  work_z = take(entries + filter_rows);
  // Of at most five poles four rows for each coordinate; two more for the sums of three.
  fractions = take((5 * 4 + 3 * 2) * r);
  scratch_rows = next;
  next = 0;
  for (size_t* first : {&G_before, &missed, &d_hat_before}) *first = take(r);
  saved_filter = take(filter_rows);
  saved_z = take(entries);
  saved_rows = next;
}

namespace {

AlignedDoubles copy_of(const Eigen::VectorXd& v) {
  return {v.begin(), v.end()};
}

std::vector<LanePole> poles_of(const ComplexLanes& poles, const ComplexLanes& weights) {
  std::vector<LanePole> used;
  for (size_t k = 0; k < ComplexLanes::kCount; ++k)
    if (weights.re[k] != 0.0 || weights.im[k] != 0.0)
      used.push_back({poles.re[k], poles.im[k], weights.re[k], weights.im[k]});
  return used;
}

// The lower triangle by columns.
AlignedDoubles lower_of(const Eigen::MatrixXd& m) {
  AlignedDoubles entries;
  for (Eigen::Index j = 0; j < m.cols(); ++j)
    for (Eigen::Index i = j; i < m.rows(); ++i) entries.push_back(m(i, j));
  return entries;
}

}  // namespace

LaneSystem make_lane_system(std::string_view name, const Model& model,
                            const IntegratorOptions& options) {
  const InertiaWeight at_rest = name == "ep4"   ? rational_weight
                                : name == "ep2" ? cotangent_weight
                                                : unit_weight;
  const InertiaDamping damping =
      make_inertia_damping(model, options, at_rest, name == "ep4" ? at_rest : unit_weight);
  const Eigen::Index r = model.modes();
  LaneSystem system;
  system.modes = static_cast<size_t>(r);
  system.step = options.step;
  system.tolerance = options.tolerance;
  system.follows = name == "ep4";
  system.damped = damping.present;
  system.layout = LaneLayout(system.modes);
  system.lambda = copy_of(model.lambda());
  system.D = copy_of(damping.D);
  system.theta_D = copy_of(damping.theta.cwiseProduct(damping.D));
  system.S = copy_of((2.0 * damping.g.cwiseInverse()).eval());
  system.weight = copy_of(system.follows ? damping.shift : damping.n);
  system.factored = !system.follows;
  system.slope = copy_of(damping.slope);
  system.factors = lower_of(Eigen::MatrixXd::Ones(r, r));
  if (!system.follows) return system;
  const DampedJacobian jacobian = make_damped_jacobian(damping);
  system.factored = damping.present && jacobian.strong;
  system.slope = copy_of(jacobian.slope);
  system.factors = lower_of(jacobian.factors);
  const FilterFractions fractions = filter_fractions(kRobustShape);
  system.limit = fractions.limit;
  system.of_filter = poles_of(fractions.poles, fractions.of_filter);
  system.of_inverse = poles_of(fractions.poles, fractions.of_inverse);
  return system;
}

LaneMask lane_mask(std::uint32_t bits) {
  LaneMask mask{};
  for (size_t lane = 0; lane < kSolveLanes; ++lane)
    if ((bits >> lane & 1u) != 0) mask.value[lane] = ~std::uint64_t{0};
  return mask;
}

void begin_lanes(const LaneSystem& system, const LaneSpan& span) {
  TREMOLO_CALL(begin, system, span);
}
void recall_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes) {
  TREMOLO_CALL(recall, system, span, lanes);
}
void filter_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes) {
  TREMOLO_CALL(make_filter, system, span, lanes);
}
void factor_lanes(const LaneSystem& system, const LaneSpan& span) {
  TREMOLO_CALL(make_factors, system, span);
}
void enter_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes) {
  TREMOLO_CALL(enter, system, span, lanes);
}
void predict_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes) {
  TREMOLO_CALL(predict, system, span, lanes);
}
void miss_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes) {
  TREMOLO_CALL(miss, system, span, lanes);
}
void move_prediction_lanes(const LaneSystem& system, const LaneSpan& span) {
  TREMOLO_CALL(move_prediction, system, span);
}
void evaluate_residual_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes,
                             LaneNumbers& ratio) {
  TREMOLO_CALL(evaluate_residual, system, span, lanes, ratio);
}
void move_lanes(const LaneSystem& system, const LaneSpan& span, size_t count,
                const LaneMask& lanes) {
  TREMOLO_CALL(make_move, system, span, count, lanes);
}
void end_lanes(const LaneSystem& system, const LaneSpan& span, LaneEnd& end) {
  TREMOLO_CALL(finish, system, span, end);
}
void save_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes) {
  TREMOLO_CALL(save, system, span, lanes);
}

}  // namespace tremolo
