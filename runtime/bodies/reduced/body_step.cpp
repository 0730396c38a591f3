// Body: the step, and the handling of a failed step.
#include <algorithm>
#include <cmath>
#include <string>

#include "common/text.h"
#include "runtime/body.h"

namespace tremolo {

StepReport Body::step() {
  if (const std::optional<StepReport> failed = begin_step()) return *failed;
  return end_step(advance(), 0.0, false);
}

// The loads of the step, and a message for loads that are not valid.
std::optional<StepReport> Body::begin_step() {
  gather_loads();
  kick_ = kick();
  if (!std::isfinite(kick_)) return explain({.converged = false, .failure = StepFailure::kLoad});
  q_before_ = state_.q;
  return std::nullopt;
}

// Adds a step that succeeded to the sums, or sets the reason of its failure.
StepReport Body::end_step(StepReport report, double outside, bool summed) {
  counts_.iterations += report.iterations;
  if (!report.converged) {
    end_frame_motion(false);
    return explain(report);
  }
  if (!summed) book_step(report, outside);
  if (++steps_since_look_ >= kStepsBetweenLooks && !look()) {
    put_back();
    report.converged = false;
    report.failure = StepFailure::kEnergy;
    return report;
  }
  take_place_forces();
  ++counts_.steps;
  if (report.parts > 1) ++counts_.halved;
  age_applied_forces();
  return report;
}

void Body::book_step(const StepReport& report, double outside, double kick) {
  const double frame_work = outside + end_frame_motion(true);
  const double work = frame_work + step_load_.average.dot(state_.q - q_before_) + report.extra_work;
  sums_.work += work;
  sums_.dissipated += report.dissipated;
  bound_.put_in(work, std::max(kick_, kick));
}

void Body::take_back(const Eigen::VectorXd& p) {
  state_.q = q_before_;
  state_.p = p;
  if (free_) free_->restore(rigid_before_);
  integrator_->reset();
}

double Body::stop_motion() {
  const double before = total_energy();
  if (free_)
    free_->set_motion(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), state_.q,
                      Eigen::VectorXd::Zero(state_.q.size()));
  state_.p.setZero();
  integrator_->reset();
  const double taken = before - total_energy();
  sums_.work -= taken;
  return taken;
}

void Body::rest_a_step() {
  ++counts_.steps;
  age_applied_forces();
}

Eigen::Matrix3d Body::turn_at_place(Eigen::Index place) const {
  if (!skin_) return pose().rotation.toRotationMatrix();
  return blended(place_weights_[static_cast<std::size_t>(place)], bone_maps()).leftCols<3>();
}

// Counts the forces of the step from time() on, which succeeded.
void Body::take_place_forces() {
  if (place_forces_.none()) return;
  place_forces_.end_step(time(), options_.step,
                         [this](Eigen::Index place) { return turn_at_place(place); });
}

// 1/2 (h |f|)^2 of the step's largest f, or that of gravity on a free body, J. A body that has come
// to rest has only rounding errors of energy, which nothing else would allow to grow.
double Body::kick() const {
  const double h = options_.step;
  const double falls = free_ ? 0.5 * free_->mass() * h * h * gravity_.squaredNorm() : 0.0;
  if (!step_load_.active) return falls;
  const double largest = std::max({step_load_.start.squaredNorm(), step_load_.average.squaredNorm(),
                                   step_load_.end.squaredNorm()});
  // std::max skips a value that is not a number.
  const bool known =
      step_load_.start.allFinite() && step_load_.average.allFinite() && step_load_.end.allFinite();
  return known ? std::max(falls, 0.5 * h * h * largest) : std::numeric_limits<double>::infinity();
}

// T + V, from the method's known potential if it has one.
double Body::total_energy() const {
  integrator_->synchronized_momentum(state_, momentum_);
  const double kinetic = frame_kinetic(momentum_);
  if (const std::optional<double> known = integrator_->known_potential(state_.q))
    return kinetic + *known;
  return kinetic + at_state().energy;
}

// The potential and its force at q.
const Evaluation& Body::at_state() const {
  if (state_.q.size() > 0 && evaluated_q_ == state_.q) return evaluation_;
  model_->potential().evaluate(state_.q, kWantEnergy | kWantForce, workspace_, evaluation_);
  evaluated_q_ = state_.q;
  return evaluation_;
}

// The harmonic energy of kEnergyRounding, with the momentum that total_energy() left.
double Body::harmonic_energy() const {
  return frame_kinetic(momentum_) +
         0.5 * (model_->lambda().array() * state_.q.array().square()).sum();
}

// False: the energy is far above the energy put in.
bool Body::look() {
  steps_since_look_ = 0;
  const double energy = total_energy();
  const EnergyFound found = bound_.look(energy, harmonic_energy());
  if (found == EnergyFound::kSound) keep_sound_state();
  return found != EnergyFound::kExploded;
}

void Body::keep_sound_state() {
  steps_since_look_ = 0;
  sound_ = state_;
  if (free_) sound_rigid_ = free_->rigid();
  sound_sums_ = sums_;
  keep_outside_sums();
}

void Body::put_back() {
  steps_since_look_ = 0;
  state_ = sound_;
  if (free_) free_->restore(sound_rigid_);
  sums_ = sound_sums_;
  put_back_outside_sums();
  integrator_->reset();
}

// Sets the reason of a failed step. The state is as before the step, which may be that of an
// explosion.
StepReport Body::explain(StepReport report) {
  const double energy = total_energy();
  if (!bound_.sound(energy, harmonic_energy())) {
    const bool as_set = state_.q == sound_.q && state_.p == sound_.p;  // its energy overflows
    put_back();
    report.failure = as_set ? StepFailure::kNumbers : StepFailure::kEnergy;
  } else if (report.failure == StepFailure::kNone) {
    const bool overflowed = report.iterations == 0 || !std::isfinite(report.residual);
    if (!overflowed)
      report.failure = StepFailure::kSolver;
    else
      report.failure = step_load_.active ? StepFailure::kLoad : StepFailure::kNumbers;
  }
  return report;
}

ErrorKind error_kind(StepFailure failure) {
  return failure == StepFailure::kEnergy ? ErrorKind::kBound : ErrorKind::kSolver;
}

std::string failure_message(const StepReport& report, double time) {
  const std::string step = "the step from t = " + number_text(time) + " s";
  switch (report.failure) {
    case StepFailure::kLoad:
      return step +
             " did not converge: its numbers overflow under the load; without it the "
             "body continues";
    case StepFailure::kNumbers:
      return step + " did not converge: its numbers overflow";
    case StepFailure::kEnergy:
      return step + " was not made: the energy is above " + number_text(kEnergyLimit) +
             " times all that the load put in, the method has exploded; the body is where its "
             "energy was last within the limit";
    default:
      return step + " did not converge: residual " + number_text(report.residual) + " after " +
             std::to_string(report.iterations) + " iterations";
  }
}

}  // namespace tremolo
