#include "runtime/bodies/tets/motion/tet_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "common/overflow.h"
#include "runtime/bodies/tets/motion/tet_island.h"

namespace tremolo {
namespace {

// Rounding error of a residual, over the stiffness times the positions.
constexpr double kRounding = 4e-15;
// With fewer directions of conjugate gradients no factorisation is tried.
constexpr int kManyDirections = 100;
// Multiplications in a direction for each block of the matrix.
constexpr double kDirectionMultiplications = 18.0;
// An edge's row of the residual counts as more than noise above this multiple of its part of the
// residual that a step may leave.
constexpr double kNoise = 4.0;
constexpr std::size_t kMostFactorBytes = std::size_t{256} << 20;

Eigen::Index body_at(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

void clear_held(std::span<const std::uint8_t> active, Eigen::VectorXd& y) {
  for (std::size_t i = 0; i < active.size(); ++i)
    if (active[i] == 0) y.segment<3>(body_at(i)).setZero();
}

Status check_range(const char* name, double value, double least, bool open) {
  if (std::isfinite(value) && (open ? value > least : value >= least)) return Success{};
  return content_error(std::string(name) + " is " + std::to_string(value) + ", expected " +
                       (open ? "above " : "at least ") + std::to_string(least));
}

// The factor of a slender body, whose matrix costs no more to factor than this many directions.
std::optional<BlockCholesky> slender_factor(const BlockPatternPointer& pattern) {
  const double search =
      kManyDirections * kDirectionMultiplications * static_cast<double>(pattern->blocks());
  Result<BlockCholesky> made = BlockCholesky::create(pattern, kMostFactorBytes);
  if (!made || made->multiplications() > search) return std::nullopt;
  return std::move(*made);
}

}  // namespace

Status check(const TetBodyOptions& options) {
  if (!(options.step > 0.0) || !std::isfinite(options.step))
    return content_error("step must be positive and finite (s)");
  for (const Status& status :
       {check_range("alpha", options.alpha, 0.0, false),
        check_range("beta", options.beta, 0.0, false),
        check_range("drag", options.drag, 0.0, false),
        check_range("tolerance", options.tolerance, 0.0, true),
        check_range("linear tolerance", options.linear_tolerance, 0.0, true),
        check_range("max iterations", options.max_iterations, 0.0, true), check(options.degree)})
    if (!status) return status.error();
  if (Status s = check_step_size(options.step); !s) return s;
  for (const auto& [name, value, unit] : {std::tuple{"alpha", options.alpha, "1/s"},
                                          {"beta", options.beta, "s"},
                                          {"drag", options.drag, "1/s"}})
    if (Status s = check_size(name, value, unit); !s) return s;
  if (!options.gravity.allFinite()) return content_error("gravity is not finite");
  if (Status s = check_size("gravity", options.gravity.lpNorm<Eigen::Infinity>(), "m/s^2"); !s)
    return s;
  return Success{};
}

Result<TetBody> TetBody::create(TetModelPointer model, const TetBodyOptions& options) {
  if (Status status = check(options); !status) return status.error();
  return TetBody(std::move(model), options);
}

TetBody::TetBody(TetModelPointer model, const TetBodyOptions& options)
    : options_(options),
      system_(model, options.law),
      choice_(*model, options.degree),
      solve_(model->pattern(), model->smooth()),
      projection_(*model),
      matrix_(model->pattern()),
      factor_(slender_factor(model->pattern())),
      alone_(std::make_unique<TetIsland>()) {
  const Eigen::Index size = model->rest().size();
  for (TetMotion* motion : {&now_, &before_, &saved_, &saved_before_, &part_}) {
    motion->x = model->rest();
    motion->v.setZero(size);
    motion->a.setZero(size);
  }
  for (Eigen::VectorXd* v :
       {&way_, &s_, &start_, &velocity_, &force_, &residual_, &correction_, &direction_, &inertia_,
        &work_, &rigid_, &stage_.from, &stage_.inertial})
    v->setZero(size);
  for (const std::uint8_t flag : model->held()) held_ = held_ || flag != 0;
  freedom_ = rigid_freedom(*model);
  // A position's rounding error times this is the rounding error of a force.
  double squared = 0.0;
  for (const TetModelElement& element : model->elements())
    squared += std::pow(element.element.couple, 2) *
               std::pow(element.element.geometry.gradients.squaredNorm(), 2);
  rounding_scale_ = std::sqrt(squared);
  Eigen::VectorXd ones = Eigen::VectorXd::Ones(size);
  weight_.resize(size);
  if (factor_) folded_.resize(model->nodes());
  model->mass_times(ones, weight_);
  find_load();
  system_.set_degrees(choice_.first_degrees());
  solve_.choose(system_.active());
}

TetBody::TetBody(TetBody&&) noexcept = default;
TetBody& TetBody::operator=(TetBody&&) noexcept = default;
TetBody::~TetBody() = default;

Status TetBody::set_state(const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
  if (x.size() != now_.x.size() || v.size() != now_.x.size())
    return content_error("state of " + std::to_string(x.size()) + " and " +
                         std::to_string(v.size()) + " numbers, expected " +
                         std::to_string(now_.x.size()));
  if (!x.allFinite() || !v.allFinite()) return content_error("state is not finite");
  now_.x = x;
  now_.v = v;
  system_.follow_ends(now_.x);
  system_.follow_ends(now_.v);
  has_before_ = has_acceleration_ = guard_.known = false;
  return Success{};
}

double TetBody::elastic_energy() {
  system_.evaluate(now_.x);
  return system_.energy();
}

// The size of the weight.
void TetBody::find_load() {
  const auto gravity = options_.gravity.replicate(weight_.size() / 3, 1).array();
  load_ = (weight_.array() * gravity).matrix().norm();
}

void TetBody::set_gravity(const Eigen::Vector3d& gravity) {
  if (gravity == options_.gravity) return;
  const double before = gravity_energy();
  expect_change(gravity - options_.gravity);
  options_.gravity = gravity;
  gravity_shift_ += before - gravity_energy();
  has_acceleration_ = false;
  find_load();
}

double TetBody::gravity_energy() const {
  double sum = gravity_shift_;
  for (std::size_t i = 0; i < model().nodes(); ++i)
    sum -= weight_[body_at(i)] * options_.gravity.dot(now_.x.segment<3>(body_at(i)));
  return sum;
}

double TetBody::set_degrees(std::span<const std::uint8_t> degrees) {
  const double before = kinetic_energy() + elastic_energy() + gravity_energy();
  const bool only_more = std::equal(degrees.begin(), degrees.end(), system_.degrees().begin(),
                                    [](std::uint8_t a, std::uint8_t b) { return a >= b; });
  const Eigen::Vector3d spin = angular_momentum();
  system_.set_degrees(degrees);
  solve_.choose(system_.active());
  has_acceleration_ = guard_.known = false;
  if (only_more) return 0.0;
  const std::array<Eigen::VectorXd*, 4> vectors = {&now_.x, &now_.v, &before_.x, &before_.v};
  const std::size_t count = options_.method == TetMethod::kBdf2 ? 4 : 2;
  projection_.project(system_, std::span(vectors).first(count), !held_);
  if (!held_) restore_spin(model(), spin - angular_momentum(), now_.x, now_.v, correction_);
  return before - (kinetic_energy() + elastic_energy() + gravity_energy());
}

void TetBody::begin(TetMethod method, double h) {
  if (method == TetMethod::kNewmark && !has_acceleration_) find_acceleration();
  begin_stage(method, h, now_, has_before_ ? &before_ : nullptr, stage_);
}

void TetBody::guess(bool stay) {
  way_ = stage_.inertial;
  if (stay) way_ = now_.x - stage_.from;
  for (std::size_t i = 0; i < model().nodes(); ++i)
    if (model().held()[i] != 0)
      way_.segment<3>(body_at(i)) =
          now_.x.segment<3>(body_at(i)) - stage_.from.segment<3>(body_at(i));
  system_.follow_ends(way_);
}

void TetBody::find_forces() {
  s_ = stage_.from + way_;
  system_.evaluate(s_);
  velocity_ = stage_.rate * way_;
  correction_ = (stage_.rate * stage_.rate) * (way_ - stage_.inertial);
  add_mass_damping(s_, velocity_, correction_);
  model().mass_times(correction_, inertia_);
  for (std::size_t i = 0; i < model().nodes(); ++i)
    force_.segment<3>(body_at(i)) = weight_[body_at(i)] * options_.gravity;
  system_.add_force(force_);
  if (options_.beta > 0.0) system_.add_damping_force(velocity_, options_.beta, force_);
  if (hand_) add_hand_force();
  if (given_.size() != 0 && stage_.method == TetMethod::kBdf2) force_ += given_;
}

void TetBody::add_mass_damping(const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                               Eigen::VectorXd& deceleration) {
  if (options_.drag > 0.0) deceleration += options_.drag * v;
  if (!(options_.alpha > 0.0)) return;
  rigid_part(model(), freedom_, x, v, work_, rigid_);
  deceleration += options_.alpha * (v - rigid_);
}

void TetBody::add_hand_force() {
  add_to_held(hand_->stiffness * (hand_->point - hand_->of(s_)) +
              hand_->damping * (hand_->velocity - hand_->of(velocity_)));
}

// A force on the grabbed point.
void TetBody::add_to_held(const Eigen::Vector3d& force) {
  for (std::size_t k = 0; k < hand_->nodes.size(); ++k)
    force_.segment<3>(body_at(hand_->nodes[k])) += hand_->shares[k] * force;
}

Status TetBody::set_hand(const std::optional<TetHand>& hand) {
  if (hand) {
    for (const std::uint32_t node : hand->nodes)
      if (node >= model().nodes())
        return usage_error("a hand holds control point " + std::to_string(node) +
                           ", but there are " + std::to_string(model().nodes()));
    for (const double value : {hand->stiffness, hand->damping})
      if (!(value >= 0.0) || !std::isfinite(value))
        return usage_error("a hand's stiffness and damping must be finite and not negative");
    const bool finite = std::all_of(hand->shares.begin(), hand->shares.end(),
                                    [](double share) { return std::isfinite(share); });
    if (!finite || !hand->point.allFinite() || !hand->velocity.allFinite())
      return usage_error("a hand's place, point or velocity is not finite");
  }
  // A continuing grab is not a new one: its force at the start of the step was that of before.
  const bool same = hand && hand_ && hand->nodes == hand_->nodes && hand->shares == hand_->shares &&
                    hand->stiffness == hand_->stiffness && hand->damping == hand_->damping;
  hand_ = hand;
  guard_.known = false;
  if (!same) has_acceleration_ = false;
  return Success{};
}

Eigen::Matrix3d TetBody::give_at(const TetHand& place) {
  constexpr double kGiveTolerance = 1e-6;
  constexpr int kGiveIterations = 2000;
  // Edges with an adaptive degree become quadratic under a grab.
  const std::vector<std::uint8_t> degrees(system_.degrees().begin(), system_.degrees().end());
  if (options_.degree.kind == DegreeKind::kAdaptive) {
    system_.set_degrees(std::vector<std::uint8_t>(degrees.size(), 2));
    solve_.choose(system_.active());
  }
  system_.evaluate(now_.x);
  system_.assemble({0.0, {1.0, 0.0, TangentKind::kFrozen}}, matrix_);
  Eigen::Matrix3d give;
  for (int axis = 0; axis < 3; ++axis) {
    residual_.setZero();
    for (std::size_t k = 0; k < place.nodes.size(); ++k)
      residual_[body_at(place.nodes[k]) + axis] += place.shares[k];
    system_.fold(residual_);
    clear_held(system_.active(), residual_);
    solve_.solve(matrix_, residual_, kGiveTolerance, kGiveIterations, correction_);
    system_.follow_ends(correction_);
    give.col(axis) = place.of(correction_);
  }
  if (options_.degree.kind == DegreeKind::kAdaptive) {
    system_.set_degrees(degrees);
    solve_.choose(system_.active());
  }
  return give;
}

// r = E^T (M g^2 (d - d_a) - F); the uncondensed vector stays in force_.
double TetBody::close_residual() {
  force_ = inertia_ - force_;
  residual_ = force_;
  system_.fold(residual_);
  clear_held(system_.active(), residual_);
  return residual_.squaredNorm();
}

double TetBody::stop_size(double tolerance) const {
  return tolerance * ((inertia_ - force_).norm() + inertia_.norm() + load_) +
         kRounding * rounding_scale_ * s_.cwiseAbs().maxCoeff();
}

double TetBody::edge_noise() const {
  const auto edges = static_cast<double>(std::max<std::size_t>(1, model().edges()));
  return kNoise * stop_size(options_.tolerance) / std::sqrt(edges);
}

// The matrix M (g^2 + (alpha + drag) g) + dforce/dx + beta g ddamping/dv.
void TetBody::assemble(TangentKind tangent, bool single) {
  TetMatrixFactors factors;
  factors.mass = mass_factor();
  factors.tangent = {1.0, options_.beta * stage_.rate, tangent};
  if (single)
    system_.assemble(factors, solve_.begin_single());
  else
    system_.assemble(factors, matrix_);
}

void TetBody::take_preconditioner(bool single) {
  if (single)
    solve_.take_diagonal();
  else
    solve_.take_diagonal(matrix_);
  solve_.take_smooth(system_.mean_rotation(), mass_factor(), 1.0 + options_.beta * stage_.rate);
}

void TetBody::note_search(int iterations) {
  search_iterations_ = iterations;
  search_nodes_ = solve_.active_nodes();
}

bool TetBody::factor_pays() const {
  if (!factor_ || search_iterations_ < kManyDirections) return false;
  const auto nodes = static_cast<double>(solve_.active_nodes());
  const auto then = static_cast<double>(search_nodes_);
  // With many more or fewer control points the search is tried again.
  if (nodes < 0.8 * then || nodes > 1.25 * then) return false;
  const double share = nodes / static_cast<double>(model().nodes());
  const double direction =
      kDirectionMultiplications * share * static_cast<double>(model().pattern()->blocks());
  return factor_->multiplications() < direction * search_iterations_;
}

bool TetBody::solve_by_factor() {
  for (std::size_t i = 0; i < folded_.size(); ++i) folded_[i] = system_.active()[i] == 0 ? 1 : 0;
  matrix_.hold(folded_);
  if (!factor_->factor(matrix_)) return false;
  correction_ = residual_;
  factor_->solve(correction_);
  return true;
}

// Removes the rigid motions in the residual exactly, because no elastic force balances them; they
// are not free in a body with fixed points.
void TetBody::balance_momenta() {
  if (held_ || hand_) return;
  for (int pass = 0; pass < 3; ++pass) {
    const double factor = stage_.rate * (stage_.rate + options_.drag);
    if (!rigid_correction(model(), s_, residual_, factor, correction_)) return;
    way_ += correction_;
    find_forces();
    close_residual();
  }
}

void TetBody::free_rigid_correction() {
  if (!(options_.alpha > 0.0)) return;
  rigid_part(model(), freedom_, s_, correction_, work_, rigid_);
  correction_ += (options_.alpha / (stage_.rate + options_.drag)) * rigid_;
}

void TetBody::end() {
  end_stage(stage_, way_, now_, before_);
  has_before_ = true;
}

// a = M^-1 F at the start.
void TetBody::find_acceleration() {
  stage_.rate = 0.0;
  stage_.from = now_.x;
  way_.setZero();
  find_forces();
  close_residual();
  if (options_.alpha > 0.0 || options_.drag > 0.0 || options_.beta > 0.0 || hand_) {
    // With a rate of zero the velocity was zero: damping of the state's own velocity is added.
    force_.setZero();
    velocity_.setZero();
    add_mass_damping(now_.x, now_.v, velocity_);
    model().mass_times(velocity_, force_);
    force_ = -force_;
    if (options_.beta > 0.0) system_.add_damping_force(now_.v, options_.beta, force_);
    if (hand_) add_to_held(-hand_->damping * hand_->of(now_.v));
    system_.fold(force_);
    clear_held(system_.active(), force_);
    residual_ -= force_;
  }
  residual_ = -residual_;
  system_.assemble({1.0, {0.0, 0.0, TangentKind::kFrozen}}, matrix_);
  solve_.solve(matrix_, residual_, 1e-14, 300, now_.a);
  system_.follow_ends(now_.a);
  has_acceleration_ = true;
}

void TetBody::keep_state() {
  saved_.x = now_.x;
  saved_.v = now_.v;
  saved_before_.x = before_.x;
  saved_before_.v = before_.v;
  had_before_ = has_before_;
}

void TetBody::restore_state() {
  now_.x = saved_.x;
  now_.v = saved_.v;
  before_.x = saved_before_.x;
  before_.v = saved_before_.v;
  has_before_ = had_before_;
  has_acceleration_ = guard_.known = false;
}

void TetBody::rewind() {
  given_.setZero();  // it makes up for the step before, which is forgotten
  now_.x = saved_.x;
  now_.v = saved_.v;
  has_before_ = has_acceleration_ = guard_.known = false;
}

void TetBody::keep_part() {
  part_.x = now_.x;
  part_.v = now_.v;
}

void TetBody::rewind_part() {
  now_.x = part_.x;
  now_.v = part_.v;
  has_before_ = has_acceleration_ = false;
}

double TetBody::guarded_energy(const TetContact* contact) {
  return kinetic_energy() + elastic_energy() + gravity_energy() +
         (contact != nullptr ? contact->look(now_.x).energy : 0.0);
}

double TetBody::take_internal_energy(double excess) {
  rigid_part(model(), freedom_, now_.x, now_.v, work_, rigid_);
  correction_ = now_.v - rigid_;
  const double internal = system_.kinetic_energy(correction_);
  if (!(internal > 0.0)) return 0.0;
  const double taken = std::min(excess, internal);
  now_.v = rigid_ + std::sqrt(1.0 - taken / internal) * correction_;
  return taken;
}

void TetBody::restore_momenta(const TetMotion& start, double passed) {
  if (held_ || hand_ || options_.drag > 0.0) return;
  const Eigen::Vector3d centre_before = system_.momentum(start.x) / model().mass();
  const Eigen::Vector3d before = system_.momentum(start.v);
  const Eigen::Vector3d spin =
      system_.angular_momentum(start.x, start.v) - centre_before.cross(before);
  const Eigen::Vector3d momentum = before + model().mass() * passed * options_.gravity;
  const Eigen::Vector3d shift = (momentum - system_.momentum(now_.v)) / model().mass();
  for (std::size_t i = 0; i < model().nodes(); ++i) now_.v.segment<3>(body_at(i)) += shift;
  const Eigen::Vector3d centre = system_.momentum(now_.x) / model().mass();
  const Eigen::Vector3d now = angular_momentum() - centre.cross(momentum);
  restore_spin(model(), spin - now, now_.x, now_.v, correction_);
}

// The mean of v_1 - v_0 then stays as it was; without a step before it is that of gravity.
void TetBody::begin_bdf2_again(const TetMotion& start, const TetMotion* before) {
  before_.x = start.x;
  before_.v = start.v;
  has_before_ = true;
  if (held_ || hand_ || options_.method != TetMethod::kBdf2) return;
  const Eigen::Vector3d from = system_.momentum(start.v), to = system_.momentum(now_.v);
  Eigen::Vector3d change = model().mass() * options_.step * options_.gravity;
  if (before != nullptr) change = from - system_.momentum(before->v);
  const Eigen::Vector3d shift = (to - from - change) / model().mass();
  for (std::size_t i = 0; i < model().nodes(); ++i) before_.v.segment<3>(body_at(i)) += shift;
}

void TetBody::expect_change(const Eigen::Vector3d& acceleration) {
  if (held_ || !has_before_ || options_.method != TetMethod::kBdf2) return;
  const Eigen::Vector3d shift = options_.step * acceleration;
  for (std::size_t i = 0; i < model().nodes(); ++i) before_.v.segment<3>(body_at(i)) -= shift;
}

void TetBody::stop() {
  now_.v.setZero();
  has_before_ = has_acceleration_ = guard_.known = false;
}

void TetBody::skip_step() {
  time_ += options_.step;
  ++steps_;
}

void TetBody::choose_degrees(TetStepReport& report) {
  if (options_.degree.kind != DegreeKind::kAdaptive) return;
  rigid_part(model(), freedom_, now_.x, now_.v, work_, rigid_);
  const double deforming =
      std::max(0.0, kinetic_energy() - system_.kinetic_energy(rigid_)) + system_.energy();
  const auto wanted = choice_.choose(system_, now_,
                                     {.residual = force_,
                                      .noise = edge_noise(),
                                      .energy = deforming,
                                      .rate = stage_.rate * stage_.rate,
                                      .h = options_.step,
                                      .calm = steps_ % options_.degree.every == 0});
  report.switched = choice_.changed();
  if (report.switched == 0) return;
  saved_.x = now_.x;
  report.energy_of_switch = set_degrees(wanted);
  report.jump = largest_jump();
}

double TetBody::largest_jump() const {
  const auto way = [this](std::size_t node) -> Eigen::Vector3d {
    return now_.x.segment<3>(body_at(node)) - saved_.x.segment<3>(body_at(node));
  };
  double largest = 0.0;
  for (std::size_t e = 0; e < model().edges(); ++e) {
    const MeshEdge& edge = model().edge(e);
    const Eigen::Vector3d a = way(static_cast<std::size_t>(edge.a));
    const Eigen::Vector3d b = way(static_cast<std::size_t>(edge.b));
    const Eigen::Vector3d middle = 0.25 * (a + b) + 0.5 * way(static_cast<std::size_t>(edge.point));
    const double squared = std::max({a.squaredNorm(), b.squaredNorm(), middle.squaredNorm()});
    largest = std::max(largest, std::sqrt(squared) / model().edge_length(e));
  }
  return largest;
}

TetStepReport TetBody::step(TetContact* contact) {
  const TetMember member{this, contact};
  TetStepReport report;
  alone_->step({&member, 1}, {&report, 1});
  return report;
}

void TetBody::carry(StateStream& stream) {
  for (TetMotion* motion : {&now_, &before_}) {
    stream(motion->x, motion->v, motion->a);
    if (stream.reads())
      stream.require(motion->x.allFinite() && motion->v.allFinite() && motion->a.allFinite());
  }
  stream(has_before_, has_acceleration_, guard_, search_iterations_, search_nodes_, time_, steps_);
  stream(options_.gravity, gravity_shift_);
  stream.require(steps_ >= 0 && std::isfinite(time_) && options_.gravity.allFinite() &&
                 std::isfinite(gravity_shift_));
  if (stream.reads()) find_load();
  choice_.carry(stream);
  system_.carry(stream);
  if (stream.reads()) solve_.choose(system_.active());
}

std::size_t TetBody::bytes() const {
  return system_.bytes() + solve_.bytes() + projection_.bytes() +
         model().pattern()->blocks() * sizeof(Eigen::Matrix3d) +
         static_cast<std::size_t>(now_.x.size()) * 26 * sizeof(double) +
         (factor_ ? factor_->bytes() : 0);
}

}  // namespace tremolo
