// The energy-preserving family: avf, ep2, ep4.
//
// V is quartic, so the mean of grad V on the segment from q0 to q1 is known exactly
// (Potential::averaged_gradient); call it G. With d = q1 - q0, v = d/h, Dp = p1 - p0, any symmetric
// positive N that is fixed within the step and any diagonal S > 0, the step
//
//     (a)  S^-1 Dp = N d/h - p0 [+ (h/12) Df]        S^-1 = I/2 + theta h D
//     (b)  N Dp/h + G + D v = f
//
// has, since in Dp . (a) + d . (b) the terms with N cancel and what is left on the left-hand side
// is Dp . (p0 + Dp/2) + d . G = T(p1) - T(p0) + V(q1) - V(q0),
//
//     H1 - H0 = f . d [+ (h/12) Df . Dp]  -  h v . D v - h Dp . theta D Dp
//
// for every h and every theta >= 0: without load and damping the energy stays, with damping it
// falls. f is the load's average over the step, Df its change from end to end; what stands in
// brackets is ep4's. theta is diagonal, 1/12 + O(h^2) where N = I - h^2 K/12. All that differs is
// N:
//
//     avf   N = I                                     (Quispel & McLaren 2008)
//     ep2   N = diag(x_i cot x_i),  x_i = min(h omega_i/2, 1.2): small vibrations have their exact
//           frequency up to h omega = 2.4
//     ep4   N = N(Z), Z = h^2 K/4 with K taken at the midpoint (runtime/integrators/
//           rational_filter.h): fourth order for the nonlinear problem, since N = I - h^2 K/12 +
//           O(h^4), also with a smooth load, by the brackets, and with damping
//
// All are time-reversible; avf and ep2 exactly. ep4 takes K not at the solution's midpoint but at
// that of an iterate near it: the first, and later ones until the difference is lost in the solve's
// tolerance. With K at the predicted
// midpoint q0 + (h/2) p0, which is of the same order but knows the direction of time, energy moves
// into the fast modes, as fast as e-fold in 70 s on the horse at h omega up to 9.7.
//
// Damping. D = alpha I + beta Lambda itself stands in (b), so that the damping force is right on
// coordinates that are slaved to others. theta and, for each coordinate, a change of N's value are
// chosen so that a free linear mode has its exact roots up to h omega = 2.4 at any D
// (runtime/integrators/solve/damping.h); both tend to what stands without damping fast enough that
// no order is lost. `dissipated` is exact: the negative terms of the balance above.
//
// Solving. Without Dp, times h^2/2, for d:
//
//     g(d) = (h/2) N Dp(d) + (h^2/2) (G - f) + (h/2) D d = 0,      Jacobian about N^2 + (h^2/4) K
//
// One contraction at the predicted step d = h p0 gives G there and K + O(h^2) for N and for the
// frozen Jacobian; each correction costs one contraction more and is sharpened by Broyden's
// updates. Where that stalls the exact Jacobian and a line search take over
// (runtime/integrators/solve/newton.h).
//
// What the solve leaves of g does work on d: H is off by exactly (2/h^2) g . d, which is known.
// p1 is scaled to take that back, so the balance holds to rounding whatever the tolerance; a
// step that ends with so little momentum that this would change the kinetic energy by a twentieth
// is solved to 1e-13.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "runtime/integrators/methods.h"
#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/newton.h"
#include "runtime/integrators/solve/rational_filter.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEp2Limit = 1.2;        // of h omega/2: x cot x stays above 0.46
constexpr double kSlow = 0.6;            // a residual that falls by less is slow
constexpr double kFilterShare = 1e-3;    // of a residual: by how much less N is off
constexpr double kSurplus = 1e-2;        // of the tolerance: after one correction from a guess
constexpr int kFilterFollows = 3;        // corrections at most, lest N and d chase each other
constexpr double kStrongDamping = 0.02;  // of the frozen Jacobian's diagonal: by how much it grows
constexpr double kFarthestFix = 0.1;     // of T(p1): no larger energy defect is taken back
constexpr double kStrict = 1e-13;        // the solve's tolerance where it cannot be

// ---- N at rest, x = h omega/2 ----

double cotangent_weight(double x) {
  x = std::min(x, kEp2Limit);
  return x < 1e-4 ? 1.0 - x * x / 3.0 : x / std::tan(x);
}

double rational_weight(double x) {
  return filter_value(kRobustShape, x * x);
}

// What damping makes of a step's two weights, for each coordinate; r each.
struct Damping {
  VectorXd rates;  // D, 1/s
  VectorXd theta;
  VectorXd inertia;  // n: N at rest, damped
  VectorXd shift;    // n less N at rest
  VectorXd divisor;  // 1 + 2 theta h D = 2/S
  VectorXd slope;    // n^2/(1 + 2 theta h D) + h D/2: of (a) and (b) in the frozen Jacobian
  bool present = false;
};

Damping make_damping(const Model& model, const IntegratorOptions& options, InertiaWeight at_rest) {
  const double h = options.step;
  const Index r = model.modes();
  Damping damping;
  damping.rates = damping_rates(model.lambda(), options.alpha, options.beta);
  damping.present = damping.rates.maxCoeff() > 0.0;
  for (VectorXd* v :
       {&damping.theta, &damping.inertia, &damping.shift, &damping.divisor, &damping.slope})
    v->setZero(r);
  for (Index i = 0; i < r; ++i) {
    const double c = h * damping.rates[i], w = h * std::sqrt(model.lambda()[i]);
    const DampedWeights weights = damped_weights(c, w, at_rest);
    damping.theta[i] = weights.theta;
    damping.inertia[i] = weights.n;
    damping.shift[i] = weights.n - at_rest(0.5 * w);
    damping.divisor[i] = 1.0 + 2.0 * weights.theta * c;
    damping.slope[i] = weights.n * weights.n / damping.divisor[i] + 0.5 * c;
  }
  return damping;
}

// ---- the kinds of N within a step ----

// N diagonal and fixed; the frozen Jacobian, damping included, by Cholesky.
class DiagonalFilter {
 public:
  static constexpr bool kFollowsTheState = false;

  explicit DiagonalFilter(const Damping& damping)
      : n_(damping.inertia), slope_(damping.slope), factor_(n_.size()) {}

  // z: (h^2/4) K; may be changed. False if the Jacobian is not positive definite.
  bool compute(MatrixXd& z) {
    z.diagonal() += slope_;
    return factor_.compute(z);
  }
  void to_basis(VectorXd&) const {}
  void from_basis(VectorXd&) const {}
  void apply(VectorXd& x) const { x = n_.cwiseProduct(x); }
  void solve(VectorXd& x) const { factor_.solve(x); }

 private:
  VectorXd n_;
  VectorXd slope_;
  SmallCholesky factor_;
};

// N a function of Z, without damping: all in the basis in which N^2 + Z is simple.
class MatrixFilter : public RationalFilter {
 public:
  static constexpr bool kFollowsTheState = true;

  explicit MatrixFilter(Index size) : RationalFilter(size, kRobustShape) {}
  bool compute(MatrixXd& z) {
    RationalFilter::compute(z);
    return true;
  }
};

// N a function of Z plus the shift of each damped coordinate, in the model's coordinates. For the
// frozen Jacobian N S N/2 + Z + h D/2 stands that without damping where damping changes it little;
// else its first order in Z less the value at rest, diag(z), where the derivative of N S N/2 is a
// factor for each entry (filter_slope).
class DampedMatrixFilter {
 public:
  static constexpr bool kFollowsTheState = true;

  // at_rest: z, r.
  DampedMatrixFilter(const Damping& damping, const VectorXd& at_rest)
      : shift_(damping.shift),
        shifted_(shift_),
        slope_(damping.slope),
        factors_(shift_.size(), shift_.size()),
        filter_(shift_.size(), kRobustShape),
        factor_(shift_.size()) {
    const VectorXd weight = damping.inertia.cwiseProduct(damping.divisor.cwiseInverse());
    for (Index j = 0; j < shift_.size(); ++j)
      for (Index i = 0; i < shift_.size(); ++i)
        factors_(i, j) =
            1.0 + filter_slope(kRobustShape, at_rest[i], at_rest[j]) * (weight[i] + weight[j]);
    const Eigen::ArrayXd undamped = (damping.inertia - damping.shift).array().square();
    const Eigen::ArrayXd change = (slope_.array() - undamped).abs() / (undamped + at_rest.array());
    strong_ = change.maxCoeff() > kStrongDamping;
    slope_.array() += (1.0 - factors_.diagonal().array()) * at_rest.array();
  }

  bool compute(MatrixXd& z) {
    filter_.compute(z);
    if (!strong_) return true;
    z.array() *= factors_.array();
    z.diagonal() += slope_;
    return factor_.compute(z);
  }
  void to_basis(VectorXd&) const {}
  void from_basis(VectorXd&) const {}
  void apply(VectorXd& x) {
    shifted_ = shift_.cwiseProduct(x);
    filter_.to_basis(x);
    filter_.apply(x);
    filter_.from_basis(x);
    x += shifted_;
  }
  void solve(VectorXd& x) {
    if (strong_) return factor_.solve(x);
    filter_.to_basis(x);
    filter_.solve(x);
    filter_.from_basis(x);
  }
  void multiply(VectorXd& x) const {
    filter_.to_basis(x);
    filter_.multiply(x);
    filter_.from_basis(x);
  }

 private:
  VectorXd shift_;
  VectorXd shifted_;
  bool strong_ = false;
  VectorXd slope_;    // of the Jacobian at rest, less factors_ z
  MatrixXd factors_;  // r x r, symmetric
  RationalFilter filter_;
  SmallCholesky factor_;
};

// ---- the step ----

template <class Filter>
class EnergyPreserving final : public Integrator {
 public:
  EnergyPreserving(std::string_view name, Model::Pointer model, const IntegratorOptions& options,
                   const Damping& damping, bool fourth, Filter filter)
      : name_(name),
        model_(std::move(model)),
        options_(options),
        tolerance_(options.tolerance),
        fourth_(fourth),
        damped_(damping.present),
        rates_(damping.rates),
        momentum_rates_(damping.theta.cwiseProduct(rates_)),
        weight_((0.5 + options.step * momentum_rates_.array()).inverse().matrix()),
        filter_(std::move(filter)),
        workspace_(model_->potential().make_workspace(kUseSegment)),
        matrix_(MatrixXd::Zero(rates_.size(), rates_.size())),
        filter_matrix_(matrix_),
        newton_(rates_.size()) {
    for (VectorXd* v : {&d_, &q1_, &gradient_, &last_gradient_, &last_place_, &expected_, &missed_,
                        &place_, &change_, &push_, &image_, &residual_})
      v->setZero(rates_.size());
    for (VectorXd& v : moves_) v.setZero(rates_.size());
    end_ = {d_, d_};
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = options_.step;
    q0_ = &state.q;
    p0_ = &state.p;
    load_ = &load;
    StepReport report = solve_frozen();
    if (!report.converged && extrapolated_ && std::isfinite(report.residual)) {
      const int before = report.iterations;
      has_filter_ = false;
      report = solve_frozen();
      report.iterations += before;
    }
    if (!report.converged && std::isfinite(report.residual)) {
      newton_.unknowns = h * *p0_;
      report = solve_exactly(report);
    }
    if (report.converged && !can_be_taken_back() && tolerance_ > kStrict) {
      tolerance_ = kStrict;
      newton_.unknowns = d_;
      report = solve_exactly(report);
      tolerance_ = options_.tolerance;
    }
    report.converged = report.converged && q1_.allFinite() && change_.allFinite();
    if (!report.converged) return report;
    const double defect = energy_defect();
    filter_.from_basis(change_);
    if (damped_)
      report.dissipated =
          rates_.dot(d_.cwiseAbs2()) / h + h * momentum_rates_.dot(change_.cwiseAbs2());
    if (fourth_ && load.active) report.extra_work = h / 12.0 * (load.end - load.start).dot(change_);
    state.q = q1_;
    state.p += change_;
    take_back(defect, state.p);
    if constexpr (Filter::kFollowsTheState) {
      has_filter_ = true;
      end_ = state;
      last_gradient_ = gradient_;
      last_place_ = place_;
    }
    return report;
  }

  void reset() override { has_filter_ = false; }
  std::string_view name() const override { return name_; }

 private:
  // Of H, by what the solve left: known, since the residual does work on d.
  double energy_defect() const {
    return 2.0 / (options_.step * options_.step) * residual_.dot(place_);
  }

  // False where the step ends with too little momentum; then the solve must leave less.
  bool can_be_taken_back() {
    image_ = *p0_;
    filter_.to_basis(image_);
    return std::abs(energy_defect()) <= 0.5 * kFarthestFix * (image_ + change_).squaredNorm();
  }

  // Scales p so that the kinetic energy falls by `defect`. Not by p *= sqrt(1 - x): near one the
  // roots round to one side, 5e-17 a step.
  static void take_back(double defect, VectorXd& p) {
    const double x = 2.0 * defect / p.squaredNorm();
    if (std::abs(x) < kFarthestFix) p -= (x / (1.0 + std::sqrt(1.0 - x))) * p;
  }

  // From d and gradient_: change_ = Dp, residual_ = g, both in the basis. Returns |g| over what is
  // allowed.
  double evaluate_residual() {
    const double h = options_.step;
    change_ = place_ / h;
    filter_.apply(change_);
    change_ += push_;
    if (damped_) {
      filter_.from_basis(change_);
      change_.array() *= weight_.array();
      filter_.to_basis(change_);
    } else {
      change_ *= 2.0;
    }
    residual_ = change_;
    filter_.apply(residual_);
    image_ = h * (gradient_ - load_->average);
    if (damped_) image_ += rates_.cwiseProduct(d_);
    filter_.to_basis(image_);
    residual_ = (0.5 * h) * (residual_ + image_);
    return relative_residual(residual_.norm(), tolerance_, h, p0_->norm(), gradient_.norm(),
                             load_->average.norm());
  }

  // gradient_ for the first correction, from the step before: with K at that step's midpoint m',
  // R(q) = G' + K (q - m'), so G = G' + K (d' + d)/2. The filter is that step's too.
  void extrapolate_gradient() {
    if constexpr (Filter::kFollowsTheState) {
      const double h = options_.step;
      enter_basis();
      image_ = last_place_ + place_;
      filter_.multiply(image_);
      filter_.from_basis(image_);
      expected_ = last_gradient_ + 2.0 / (h * h) * image_;
      gradient_ = expected_ + missed_;
    }
  }

  // What the extrapolation missed at the first correction: at the next step about the same.
  void expect(const VectorXd& move) {
    if constexpr (Filter::kFollowsTheState) {
      image_ = move;
      filter_.multiply(image_);
      filter_.from_basis(image_);
      expected_ += 2.0 / (options_.step * options_.step) * image_;
    }
  }

  void evaluate_gradient(MatrixXd* tangent) {
    q1_ = *q0_ + d_;
    model_->potential().averaged_gradient(*q0_, q1_, workspace_, gradient_, tangent);
  }

  // N and the frozen Jacobian from the tangent of the last contraction, and what of (a) depends on
  // them. False if they cannot be had.
  bool prepare_filter() {
    const double h = options_.step;
    has_filter_ = false;
    matrix_ *= 0.25 * h * h;
    const bool usable = matrix_.allFinite() && filter_.compute(matrix_);
    enter_basis();
    return usable;
  }

  void enter_basis() {
    const double h = options_.step;
    place_ = d_;
    filter_.to_basis(place_);
    push_ = -*p0_;
    if (fourth_ && load_->active) push_ += (h / 12.0) * (load_->end - load_->start);
    filter_.to_basis(push_);
  }

  // The predicted step, one correction (for an N that depends on the state by what is known from
  // the step before, if there is one), then N at the midpoint that this gave; more corrections with
  // the Jacobian frozen and Broyden's updates, in the filter's basis.
  StepReport solve_frozen() {
    StepReport report;
    d_ = options_.step * *p0_;
    bool usable = true;
    extrapolated_ = has_filter_ && end_.q == *q0_ && end_.p == *p0_;
    if (extrapolated_) {
      extrapolate_gradient();
    } else {
      missed_.setZero();
      has_filter_ = false;
      evaluate_gradient(&matrix_);
      usable = prepare_filter();
    }
    double ratio = evaluate_residual();
    int updates = 0;  // since the filter was made
    for (int slow = 0;; ++report.iterations) {
      report.residual = residual_.norm();
      // N at the predicted midpoint would know the direction of time; it follows the midpoint
      // until what it is off by falls below the solve's tolerance.
      const bool settled = !Filter::kFollowsTheState ||
                           (report.iterations > 0 &&
                            (kFilterShare * ratio < 1.0 || report.iterations == kFilterFollows));
      // One correction from a guess: a residual that is just small enough tells little of the
      // error.
      const bool guessed = extrapolated_ && report.iterations == 1;
      report.converged = ratio <= (!settled ? 0.0 : guessed ? kSurplus : 1.0);
      if (report.converged || !usable || !std::isfinite(ratio) || slow > 1 ||
          report.iterations == std::min(kUpdates, options_.max_iterations))
        break;
      VectorXd& move = moves_[static_cast<std::size_t>(updates)];
      next_move(updates, move);
      report.converged = settled && move.norm() <= kRounding * place_.norm();
      if (report.converged) break;
      place_ += move;
      d_ = place_;
      filter_.from_basis(d_);
      if (settled) {
        evaluate_gradient(nullptr);
        ++updates;
      } else {
        const bool first = report.iterations == 0 && extrapolated_;
        if (first) expect(move);
        evaluate_gradient(&matrix_);
        if (first) missed_ = gradient_ - expected_;
        usable = prepare_filter();
        updates = 0;
      }
      const double next = evaluate_residual();
      if (settled && !(next < kSlow * ratio)) ++slow;
      ratio = next;
    }
    return report;
  }

  // move = -J^-1 g by the frozen Jacobian and all updates so far.
  void next_move(int count, VectorXd& move) {
    move = -residual_;
    filter_.solve(move);
    apply_broyden(std::span<const VectorXd>(moves_).first(static_cast<std::size_t>(count)), move);
  }

  // From newton_.unknowns, with the exact Jacobian and the line search; N is what it was.
  StepReport solve_exactly(const StepReport& before) {
    const double h = options_.step;
    if (has_filter_) {  // of the step before still
      d_ = h * *p0_;
      evaluate_gradient(&matrix_);
      prepare_filter();
    }
    for (Index j = 0; j < filter_matrix_.cols(); ++j) {
      image_.setZero();
      image_[j] = 1.0;
      filter_.to_basis(image_);
      filter_.apply(image_);
      filter_.from_basis(image_);
      filter_matrix_.col(j) = image_;
    }
    StepReport report = solve_newton(newton_, options_.max_iterations, [&] {
      d_ = newton_.unknowns;
      place_ = d_;
      filter_.to_basis(place_);
      evaluate_gradient(nullptr);
      const double ratio = evaluate_residual();
      newton_.residual = residual_;
      filter_.from_basis(newton_.residual);
      model_->potential().averaged_jacobian(*q0_, q1_, workspace_, newton_.jacobian);
      newton_.jacobian *= 0.5 * h * h;
      matrix_ = weight_.asDiagonal() * filter_matrix_;
      newton_.jacobian.noalias() += 0.5 * filter_matrix_ * matrix_;
      newton_.jacobian.diagonal() += (0.5 * h) * rates_;
      return ratio;
    });
    report.iterations += before.iterations;
    return report;
  }

  std::string_view name_;
  Model::Pointer model_;
  IntegratorOptions options_;
  double tolerance_;  // of the present solve
  bool fourth_;
  bool damped_;
  bool has_filter_ = false;  // filter_ is that of the last step that was made
  bool extrapolated_ = false;
  State end_;                // of that step
  VectorXd rates_;           // D
  VectorXd momentum_rates_;  // theta D
  VectorXd weight_;          // S
  Filter filter_;
  PotentialWorkspace workspace_;
  MatrixXd matrix_;
  MatrixXd filter_matrix_;  // N in full, for solve_exactly
  NewtonWorkspace newton_;
  VectorXd d_;
  VectorXd q1_;
  VectorXd gradient_;       // G
  VectorXd last_gradient_;  // of the last step that was made
  VectorXd last_place_;     // its d, in the filter's basis
  VectorXd expected_;       // G as extrapolated
  VectorXd missed_;         // by that, at the step before
  // In the filter's basis:
  VectorXd place_;     // d
  VectorXd change_;    // Dp
  VectorXd push_;      // what (a) has beside N d/h
  VectorXd residual_;  // g
  VectorXd image_;
  std::array<VectorXd, kUpdates> moves_;
  const VectorXd* q0_ = nullptr;
  const VectorXd* p0_ = nullptr;
  const StepLoad* load_ = nullptr;
};

template <class Filter>
IntegratorPointer make_step(std::string_view name, Model::Pointer model,
                            const IntegratorOptions& options, const Damping& damping, bool fourth,
                            Filter filter) {
  return std::make_unique<EnergyPreserving<Filter>>(name, std::move(model), options, damping,
                                                    fourth, std::move(filter));
}

}  // namespace

IntegratorPointer make_avf(Model::Pointer model, const IntegratorOptions& options) {
  const Damping damping = make_damping(*model, options, unit_weight);
  return make_step("avf", std::move(model), options, damping, false, DiagonalFilter(damping));
}

IntegratorPointer make_ep2(Model::Pointer model, const IntegratorOptions& options) {
  const Damping damping = make_damping(*model, options, cotangent_weight);
  return make_step("ep2", std::move(model), options, damping, false, DiagonalFilter(damping));
}

IntegratorPointer make_ep4(Model::Pointer model, const IntegratorOptions& options) {
  const Damping damping = make_damping(*model, options, rational_weight);
  if (damping.present) {
    const VectorXd at_rest = (0.25 * options.step * options.step) * model->lambda();
    return make_step("ep4", std::move(model), options, damping, true,
                     DampedMatrixFilter(damping, at_rest));
  }
  const Index r = model->modes();
  return make_step("ep4", std::move(model), options, damping, true, MatrixFilter(r));
}

}  // namespace tremolo
