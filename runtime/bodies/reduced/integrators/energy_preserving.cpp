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
// falls. f is the load's average over the step, Df its change from end to end; the terms in
// brackets are those of ep4. theta is diagonal, 1/12 + O(h^2) where N = I - h^2 K/12. All that
// differs is N:
//
//     avf   N = I                                     (Quispel & McLaren 2008)
//     ep2   N = diag(x_i cot x_i),  x_i = min(h omega_i/2, 1.2): small vibrations have their exact
//           frequency up to h omega = 2.4
//     ep4   N = N(Z), Z = h^2 K/4 with K taken at the midpoint (solve/inertia_filter.h): fourth
//           order for the nonlinear problem, since N = I - h^2 K/12 + O(h^4), also with a smooth
//           load, by the brackets, and with damping
//
// All are time-reversible; avf and ep2 exactly. ep4 takes K not at the solution's midpoint but at
// that of an iterate near it: the first, and later ones until the difference is lost in the solve's
// tolerance. With K at the predicted midpoint q0 + (h/2) p0, which is of the same order but knows
// the direction of time, energy moves into the fast modes, as fast as e-fold in 70 s on the horse
// at h omega up to 9.7.
//
// Damping. D = alpha I + beta Lambda itself is in (b), so that the damping force is right on
// coordinates that are slaved to others. theta and, for each coordinate, a change of N's value are
// chosen so that a free linear mode has its exact roots up to h omega = 2.4 at any D
// (runtime/bodies/reduced/integrators/solve/damping.h); both tend to their undamped values fast
// enough that no order is lost. `dissipated` is exact: the negative terms of the balance above.
//
// Solving. Without Dp, times h^2/2, for d:
//
//     g(d) = (h/2) N Dp(d) + (h^2/2) (G - f) + (h/2) D d = 0,      Jacobian about N^2 + (h^2/4) K
//
// in the basis W in which N is simplest (solve/inertia_filter.h): a hat is x_hat = W^T x. With
// b = -p0 [+ (h/12) Df], (a) is Dp = S (N d/h + b). G of the step before and its K give a first G.
// With that K in the frozen Jacobian and the N of the step before, one correction follows, and then
// the move by which that correction missed in the step before. V, its gradient and its tangent are
// evaluated at the end that this gives (solve/step_ends.h): hence the exact G, and K + O(h^2) for N
// and for a new frozen Jacobian. Each further correction costs an evaluation of the gradient, and
// is sharpened by Broyden's updates. Where that stalls the exact Jacobian and a line search take
// over (runtime/bodies/reduced/integrators/solve/newton.h).
//
// The corrections shrink the residual by a rate that hardly changes from step to step. Where the
// rate of a recent step, with a margin, says that a correction reaches the tolerance, nothing is
// evaluated at its end but V: G follows to first order.
//
// The residual g that the solve leaves does work along d, and so does what the G of a series
// misses of V(q1) - V(q0): the error of H, which is known exactly. p1 is scaled to correct it, so
// that the balance holds to rounding at any tolerance. A step that ends with so little momentum
// that this would change the kinetic energy by a twentieth is solved to 1e-13.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "runtime/bodies/reduced/frames/step_coupling.h"
#include "runtime/bodies/reduced/integrators/methods.h"
#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"
#include "runtime/bodies/reduced/integrators/solve/newton.h"
#include "runtime/bodies/reduced/integrators/solve/step_ends.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFilterShare = 1e-3;  // N is off by less than this share of a residual
constexpr double kSurplus = 1e-2;      // of the tolerance, after one correction from a prediction
constexpr int kFilterFollows = 3;      // corrections at most, lest N and d chase each other
constexpr double kFarthestFix = 0.1;  // of T(p1): no larger energy defect is given back (give_back)
constexpr double kStrict = 1e-13;     // the solve's tolerance where the defect cannot be given back
constexpr int kTrustedSteps = 8;      // steps for which a measured rate of correction is used
constexpr double kMostShare = 0.1;    // of d: a move that keeps the tangent at the end
constexpr double kMostLag = 0.25;     // of a residual's limit: StepEnds::lag
constexpr double kRateMargin = 8.0;   // times below the limit must be what the rate predicts

template <class Filter>
class EnergyPreserving final : public Integrator {
 public:
  EnergyPreserving(std::string_view name, Model::Pointer model, const IntegratorOptions& options,
                   const InertiaDamping& damping, Filter filter)
      : name_(name),
        model_(std::move(model)),
        options_(options),
        tolerance_(options.tolerance),
        h_(options.step),
        damped_(damping.present),
        D_(damping.D),
        theta_D_(damping.theta.cwiseProduct(D_)),
        S_((0.5 + h_ * theta_D_.array()).inverse().matrix()),
        strain_(*model_, options.beta, options.tolerance),
        N_(std::move(filter)),
        ends_(model_->potential()),
        K_(MatrixXd::Zero(D_.size(), D_.size())),
        Z_(K_),
        N_matrix_(Z_),
        newton_(D_.size()) {
    for (VectorXd* v : {&d_, &q1_, &G_, &d_hat_, &dp_hat_, &b_hat_, &g_hat_, &x_, &move_,
                        &d_before_, &G_before_, &missed_, &without_, &bent_, &middle_, &rest_})
      v->setZero(D_.size());
    for (VectorXd& v : moves_) v.setZero(D_.size());
    z1_ = {d_, d_};
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    q0_ = &state.q;
    p0_ = &state.p;
    load_ = &load;
    if (load.coupling != nullptr) load.coupling->begin(h_, state.q, state.p);
    if (strain_.present()) {
      middle_ = state.q + (0.5 * h_) * state.p;
      strain_.stand_at(middle_);
    }
    StepReport report = solve(state);
    report.converged = report.converged && q1_.allFinite() && dp_hat_.allFinite() &&
                       (load.coupling == nullptr || load.coupling->unsolved() == 0.0);
    if (!report.converged) return report;
    const double defect = energy_defect();
    VectorXd& dp = dp_hat_;
    N_.from_basis(dp);
    if (damped_)
      report.dissipated =
          D_.dot(d_.cwiseAbs2()) / h_ + h_ * theta_D_.dot(dp.cwiseAbs2()) + rest_work_;
    if (fourth_order() && load.active)
      report.extra_work = h_ / 12.0 * (load.end - load.start).dot(dp);
    state.q = q1_;
    if (load.coupling == nullptr || !load.coupling->finish(d_, defect, state.p)) {
      state.p += dp;
      give_back(defect, 0.5 * state.p.squaredNorm(), state.p);
    }
    ends_.accept(q1_);
    N_of_last_step_ = true;
    d_before_ = d_;
    G_before_ = G_;
    z1_ = state;
    if (predicted_)
      missed_ = d_ - without_;
    else
      missed_.setZero();
    return report;
  }

  void reset() override {
    N_of_last_step_ = false;
    ends_.forget();
  }
  void carry(StateStream& stream) override {
    stream(N_of_last_step_);
    if (!N_of_last_step_ || !stream.good()) return;
    stream(z1_, d_before_, G_before_, missed_, K_, N_, ends_, rate_, trusted_steps_);
  }
  std::string_view name() const override { return name_; }
  std::optional<double> known_potential(const VectorXd& q) const override {
    return ends_.known_energy(q);
  }

 private:
  // The brackets of (a) belong to ep4, whose N follows the state.
  static constexpr bool fourth_order() { return Filter::kFollowsTheState; }

  // The frozen Jacobian from a prediction, then from none, then the exact one; strictly where the
  // energy that the solve leaves could not be given back.
  StepReport solve(const State& z0) {
    StepReport report = solve_frozen();
    if (!report.converged && predicted_ && std::isfinite(report.residual)) {
      const int before = report.iterations;
      N_of_last_step_ = false;
      report = solve_frozen();
      report.iterations += before;
    }
    if (!report.converged && std::isfinite(report.residual)) {
      newton_.unknowns = h_ * z0.p;
      report = solve_exactly(report, true);
    }
    if (report.converged && !can_be_given_back() && tolerance_ > kStrict) {
      set_tolerance(kStrict);
      ends_.forget();
      ends_.start_at(*q0_);  // with the exact K0
      newton_.unknowns = d_;
      report = solve_exactly(report, false);
      set_tolerance(options_.tolerance);
    }
    return report;
  }

  void set_tolerance(double tolerance) {
    tolerance_ = tolerance;
    strain_.set_tolerance(tolerance);
  }

  // The error of H, J: the residual that the solve left does work along d.
  double energy_defect() const { return 2.0 / (h_ * h_) * g_hat_.dot(d_hat_) + missed_work_; }

  // False where the step ends with too little momentum; then the solve must leave less residual.
  bool can_be_given_back() {
    x_ = *p0_;
    N_.to_basis(x_);
    return std::abs(energy_defect()) <= 0.5 * kFarthestFix * (x_ + dp_hat_).squaredNorm();
  }

  // From d and G: Dp and g, both in the basis. Returns relative_residual().
  double evaluate_residual() {
    const double h = h_;
    StepCoupling* coupling = load_->coupling;
    double f_norm = load_->average.norm();
    x_ = G_ - load_->average;
    dp_hat_ = d_hat_ / h;
    N_.apply(dp_hat_);
    dp_hat_ += b_hat_;
    const bool coupled_momentum = coupling != nullptr && coupling->changes_momentum();
    if (damped_ || coupled_momentum) {
      N_.from_basis(dp_hat_);
      dp_hat_.array() *= S_.array();
      if (coupled_momentum) coupling->evaluate(d_, S_, dp_hat_, x_);
      N_.to_basis(dp_hat_);
    } else {
      dp_hat_ *= 2.0;
    }
    if (coupling != nullptr) {
      if (!coupled_momentum) coupling->evaluate(d_, S_, dp_hat_, x_);
      f_norm = std::max(f_norm, coupling->force_scale());
    }
    g_hat_ = dp_hat_;
    N_.apply(g_hat_);
    x_ *= h;
    if (damped_) x_ += D_.cwiseProduct(d_);
    if (strain_.present()) x_ += rest_;
    N_.to_basis(x_);
    g_hat_ = (0.5 * h) * (g_hat_ + x_);
    return relative_residual(g_hat_.norm(), tolerance_, h, p0_->norm(), G_.norm(), f_norm);
  }

  // G for the first correction, from the step before: with K near that step's midpoint m' and its
  // mean force G' over d', grad V(q) = G' + K (q - m'), so G = G' + K (d' + d)/2. The frozen
  // Jacobian has the same K. rest(qm) d has it instead of J^T G J.
  void predict_gradient() {
    enter_basis();
    x_ = 0.5 * (d_before_ + d_);
    bent_.noalias() = K_ * x_;
    G_ = G_before_ + bent_;
    missed_work_ = 0.0;
    if (!strain_.present()) return;
    bent_.noalias() = K_ * d_;
    rest_ = strain_.beta() * (bent_ - model_->lambda().cwiseProduct(d_));
  }

  // After the first correction from predict_gradient().
  void move_as_missed_before() {
    without_ = d_;
    d_ += missed_;
    x_ = missed_;
    N_.to_basis(x_);
    d_hat_ += x_;
  }

  // G and what is known at the end. near: the end has moved little, by move_.
  void evaluate_gradient(bool near = false) {
    q1_ = *q0_ + d_;
    if (near)
      ends_.end_near(move_, q1_, d_, G_);
    else
      ends_.end_at(q1_, d_, G_);
    missed_work_ = ends_.work() - G_.dot(d_);
    if (!strain_.present()) return;
    middle_ = *q0_ + 0.5 * d_;
    rest_work_ = strain_.force(middle_, d_, rest_) / h_;
  }

  // Computes N and the frozen Jacobian from the tangents at the ends, and the terms of (a) that
  // depend on them. False if that fails.
  bool make_filter() {
    N_of_last_step_ = false;
    ends_.mean_tangent(K_);
    Z_ = (0.25 * h_ * h_) * K_;
    const bool usable = Z_.allFinite() && N_.compute(Z_);
    enter_basis();
    return usable;
  }

  void enter_basis() {
    d_hat_ = d_;
    N_.to_basis(d_hat_);
    b_hat_ = -*p0_;
    if (fourth_order() && load_->active) b_hat_ += (h_ / 12.0) * (load_->end - load_->start);
    N_.to_basis(b_hat_);
  }

  // d = h p0 and G there, predicted where the step before ended at this one's start. False if the
  // frozen Jacobian cannot be had.
  bool begin_frozen() {
    ends_.start_at(*q0_);
    d_ = h_ * *p0_;
    predicted_ = N_of_last_step_ && z1_.q == *q0_ && z1_.p == *p0_;
    if (predicted_) {
      predict_gradient();
      return true;
    }
    trusted_steps_ = 0;
    evaluate_gradient();
    return make_filter();
  }

  // The predicted step, one correction (for an N that depends on the state by what is known from
  // the step before, if there is one), then N at the midpoint that this gave; more corrections with
  // the Jacobian frozen and Broyden's updates, in the basis.
  StepReport solve_frozen() {
    StepReport report;
    bool usable = begin_frozen();
    double ratio = evaluate_residual();
    const int most = std::min(kUpdates, options_.max_iterations);
    int updates = 0;  // since the filter was made
    for (int slow = 0;; ++report.iterations) {
      report.residual = g_hat_.norm();
      // N at the predicted midpoint would depend on the direction of time; it follows the midpoint
      // until its error is below the solve's tolerance.
      const bool settled = Filter::kFollowsTheState
                               ? report.iterations > 0 && (kFilterShare * ratio < 1.0 ||
                                                           report.iterations == kFilterFollows)
                               : report.iterations > 0 || !predicted_;
      // After one correction from a prediction a residual that is just small enough does not bound
      // the error.
      const bool guessed = predicted_ && report.iterations == 1;
      report.converged = ratio <= (!settled ? 0.0 : guessed ? kSurplus : 1.0);
      if (report.converged || !usable || !std::isfinite(ratio) || slow > 1 ||
          report.iterations == most)
        break;
      VectorXd& move = moves_[updates];
      next_move(updates, move);
      report.converged = settled && move.norm() <= kRounding * d_hat_.norm();
      if (report.converged) break;
      move_ = move;
      N_.from_basis(move_);
      d_hat_ += move;
      d_ += move_;
      const bool small = settled && is_small_move(ratio);
      if (small && updates == 0 && is_last_move(ratio)) {
        report.residual *= rate_;
        report.converged = follow_last_move();
        ++report.iterations;
        break;
      }
      if (predicted_ && report.iterations == 0) move_as_missed_before();
      evaluate_gradient(small);
      if (settled) {
        ++updates;
      } else {
        usable = make_filter();
        updates = 0;
      }
      const double next = evaluate_residual();
      if (settled && updates == 1) {
        rate_ = next / ratio;
        trusted_steps_ = kTrustedSteps;
      }
      if (settled && !(next < kSlow * ratio)) ++slow;
      ratio = next;
    }
    return report;
  }

  // True: after this correction of a residual no other one will be needed.
  bool is_last_move(double ratio) const {
    return predicted_ && trusted_steps_ > 0 && kRateMargin * rate_ * ratio <= 1.0;
  }

  // True: the end may move by move_ and keep its tangent. A move of much of d, as from d = 0 where
  // the step begins at rest, changes what the lag is measured by.
  bool is_small_move(double ratio) const {
    const double share = ends_.share(move_, d_);
    const double lag = 0.5 * h_ * h_ * ends_.lag(share);
    return share <= kMostShare && lag * ratio <= kMostLag * g_hat_.norm();
  }

  // The residual's parts and the energy after the step's last move, without an evaluation of V's
  // gradient. False: they are not finite.
  bool follow_last_move() {
    --trusted_steps_;
    q1_ = *q0_ + d_;
    ends_.move_end(move_, q1_, G_, bent_);
    missed_work_ = ends_.work() - G_.dot(d_);
    if (strain_.present()) follow_damping();
    return std::isfinite(evaluate_residual() + missed_work_);
  }

  // rest(qm) d and its work after the last move, where bent_ is K times the move. The work is of a
  // higher order than the force.
  void follow_damping() {
    if (!strain_.has_stresses()) {
      middle_ = *q0_ + 0.5 * d_;
      rest_work_ = strain_.force(middle_, d_, rest_) / h_;
      return;
    }
    rest_ += strain_.beta() * (bent_ - model_->lambda().cwiseProduct(move_));
    rest_work_ = strain_.work_after(move_, q1_, bent_, h_ * rest_work_, middle_) / h_;
    missed_work_ += rest_work_ - rest_.dot(d_) / h_;
  }

  // move = -J^-1 g by the frozen Jacobian and all updates so far.
  void next_move(int count, VectorXd& move) {
    move = -g_hat_;
    N_.solve(move);
    apply_broyden(std::span<const VectorXd>(moves_).first(count), move);
  }

  // Solves from newton_.unknowns with the exact Jacobian and the line search. far: N may have been
  // made far from the step; if it follows the state it is made again at the midpoint found.
  StepReport solve_exactly(const StepReport& before, bool far) {
    if (N_of_last_step_) {
      d_ = h_ * *p0_;
      evaluate_gradient();
      make_filter();
    }
    StepReport report;
    int iterations = before.iterations;
    bool settled = !far || !Filter::kFollowsTheState;
    for (int round = 1;; ++round) {
      report = solve_with_filter();
      iterations += report.iterations;
      if (settled || !report.converged) break;
      report.converged = make_filter();
      const double ratio = evaluate_residual();
      if (!report.converged || ratio <= 1.0) break;
      settled = kFilterShare * ratio < 1.0 || round == kFilterFollows;
      newton_.unknowns = d_;
    }
    report.iterations = iterations;
    return report;
  }

  StepReport solve_with_filter() {
    for (Index j = 0; j < N_matrix_.cols(); ++j) {
      x_.setZero();
      x_[j] = 1.0;
      N_.to_basis(x_);
      N_.apply(x_);
      N_.from_basis(x_);
      N_matrix_.col(j) = x_;
    }
    return solve_newton(newton_, options_.max_iterations, [&] { return evaluate_exactly(); });
  }

  // The residual and its Jacobian at d = newton_.unknowns, in the model's coordinates.
  double evaluate_exactly() {
    d_ = newton_.unknowns;
    d_hat_ = d_;
    N_.to_basis(d_hat_);
    evaluate_gradient();
    const double ratio = evaluate_residual();
    newton_.residual = g_hat_;
    N_.from_basis(newton_.residual);
    middle_ = *q0_ + 0.5 * d_;
    ends_.mean_derivative(middle_, newton_.jacobian);
    newton_.jacobian *= 0.5 * h_ * h_ + h_ * strain_.beta();
    MatrixXd& SN = Z_;
    SN = S_.asDiagonal() * N_matrix_;
    newton_.jacobian.noalias() += 0.5 * N_matrix_ * SN;
    newton_.jacobian.diagonal() += (0.5 * h_) * D_;
    if (strain_.present())
      newton_.jacobian.diagonal() -= (0.5 * h_ * strain_.beta()) * model_->lambda();
    return ratio;
  }

  std::string_view name_;
  Model::Pointer model_;
  IntegratorOptions options_;
  double tolerance_;  // of the present solve
  double h_;
  bool damped_;
  bool N_of_last_step_ = false;  // N_ is that of the last step that was made
  bool predicted_ = false;       // this solve began with predict_gradient()
  // The rate at which the last measured correction shrank its residual, and the number of steps for
  // which it may be used.
  double rate_ = 1.0;
  int trusted_steps_ = 0;
  // By how much V1 - V0 is more than the work G . d, less the same of damping, J.
  double missed_work_ = 0.0;
  State z1_;    // of the last step that was made
  VectorXd D_;  // 1/s
  VectorXd theta_D_;
  VectorXd S_;
  StrainDamping strain_;
  Filter N_;
  StepEnds ends_;
  MatrixXd K_;         // near the midpoint, of N_ and the frozen Jacobian
  MatrixXd Z_;         // h^2 K/4, spent by N_.compute(); scratch of the exact solve
  MatrixXd N_matrix_;  // N in the model's coordinates, for the exact solve
  NewtonWorkspace newton_;
  VectorXd d_;
  VectorXd q1_;
  VectorXd G_;
  VectorXd d_hat_;
  VectorXd dp_hat_;  // Dp
  VectorXd b_hat_;
  VectorXd g_hat_;
  VectorXd x_;                    // scratch
  VectorXd move_;                 // of d
  VectorXd d_before_, G_before_;  // of the last step that was made
  VectorXd missed_;               // d of the last step less what its first correction gave
  VectorXd without_;              // d after the first correction
  VectorXd bent_;                 // scratch
  // Of strain_: rest(qm) d, and its work d.rest(qm) d/h, J.
  VectorXd middle_;
  VectorXd rest_;
  double rest_work_ = 0.0;
  std::array<VectorXd, kUpdates> moves_;
  const VectorXd* q0_ = nullptr;
  const VectorXd* p0_ = nullptr;
  const StepLoad* load_ = nullptr;
};

template <class Filter>
IntegratorPointer make_step(std::string_view name, Model::Pointer model,
                            const IntegratorOptions& options, const InertiaDamping& damping,
                            Filter filter) {
  return std::make_unique<EnergyPreserving<Filter>>(name, std::move(model), options, damping,
                                                    std::move(filter));
}

IntegratorPointer make_diagonal(std::string_view name, Model::Pointer model,
                                const IntegratorOptions& options, InertiaWeight at_rest) {
  const InertiaDamping damping = make_inertia_damping(*model, options, at_rest, unit_weight);
  return make_step(name, std::move(model), options, damping, DiagonalFilter(damping));
}

}  // namespace

IntegratorPointer make_avf(Model::Pointer model, const IntegratorOptions& options) {
  return make_diagonal("avf", std::move(model), options, unit_weight);
}

IntegratorPointer make_ep2(Model::Pointer model, const IntegratorOptions& options) {
  return make_diagonal("ep2", std::move(model), options, cotangent_weight);
}

IntegratorPointer make_ep4(Model::Pointer model, const IntegratorOptions& options) {
  const InertiaDamping damping =
      make_inertia_damping(*model, options, rational_weight, rational_weight);
  if (!damping.present) {
    const Index r = model->modes();
    return make_step("ep4", std::move(model), options, damping, MatrixFilter(r));
  }
  return make_step("ep4", std::move(model), options, damping, DampedMatrixFilter(damping));
}

}  // namespace tremolo
