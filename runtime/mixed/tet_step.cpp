#include "runtime/mixed/tet_step.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kMomentaTolerance = 1e-10;  // of the forces in a step
constexpr std::size_t kMostFactorBytes = std::size_t{1} << 30;

Index row_of(std::size_t node) {
  return static_cast<Index>(3 * node);
}

bool is_before(const ContactMemory& x, const ContactMemory& y) {
  return x.obstacle < y.obstacle || (x.obstacle == y.obstacle && x.point < y.point);
}

std::optional<BlockCholesky> make_factor(const BlockPatternPointer& pattern) {
  Result<BlockCholesky> made = BlockCholesky::create(pattern, kMostFactorBytes);
  if (!made) return std::nullopt;
  return std::move(*made);
}

}  // namespace

TetStep::TetStep(TetBody& body, std::shared_ptr<const TetPoints> points,
                 const ContactOptions& options)
    : body_(&body),
      points_(std::move(points)),
      law_(tremolo::area_law(*points_, body.model().mass(), options)),
      factor_(make_factor(body.model().pattern())) {
  const Index n = body.model().rest().size();
  for (VectorXd* v : {&known_way_, &own_, &pushed_, &kept_, &in_, &out_}) v->setZero(n);
  still_.resize(body.model().nodes());
  slopes_.reserve(points_->points.size());
  if (!factor_) inverse_.resize(body.model().nodes());
}

Index TetStep::unknowns() const {
  return body_->model().rest().size();
}

void TetStep::start() {
  const VectorXd &x = body_->now_.x, &v = body_->now_.v;
  Vector3d low = x.head<3>(), high = low;
  double speed2 = 0.0;
  for (std::size_t i = 0; i < body_->model().nodes(); ++i) {
    low = low.cwiseMin(x.segment<3>(row_of(i)));
    high = high.cwiseMax(x.segment<3>(row_of(i)));
    speed2 = std::max(speed2, v.segment<3>(row_of(i)).squaredNorm());
  }
  const double h = body_->options_.step;
  ball_ = {0.5 * (low + high), 0.5 * (high - low).norm(),
           h * std::sqrt(speed2) + 0.5 * h * h * body_->options_.gravity.norm()};
}

void TetStep::step_alone() {
  report_ = body_->step();
  account_ = {};
  memories_.clear();
  contacted_.clear();
}

// A point between vertices has the first of them.
int TetStep::number_of(std::size_t point) const {
  return static_cast<int>(points_->points[point].nodes[0]);
}

Vector3d TetStep::start_of(std::size_t point) const {
  return at_point(points_->points[point], body_->now_.x);
}

const ContactMemory* TetStep::memory(std::size_t obstacle, std::size_t point) const {
  const ContactMemory wanted{.obstacle = obstacle, .point = point};
  const auto found = std::lower_bound(memories_.begin(), memories_.end(), wanted, is_before);
  return found != memories_.end() && !is_before(wanted, *found) ? &*found : nullptr;
}

void TetStep::begin() {
  const TetMethod method = body_->options_.method;
  body_->keep_state();
  body_->begin(method == TetMethod::kNewmark ? TetMethod::kMidpoint : method, body_->options_.step);
  body_->guess(false);
  ends_ = body_->stage_.method == TetMethod::kMidpoint ? 2.0 : 1.0;
  known_ = false;
}

void TetStep::keep() {
  kept_ = body_->way_;
}

void TetStep::go(double length, In direction) {
  in_ = direction;
  body_->system_.follow_ends(in_);
  body_->way_ = kept_ - length * in_;
}

void TetStep::evaluate(const ContactRenewal& renewal) {
  (void)renewal;
  if (!known_ || body_->way_ != known_way_) {
    body_->find_forces();
    own_ = body_->force_;
    known_way_ = body_->way_;
    known_ = true;
  }
  pushed_.setZero();
}

SiteMotion TetStep::motion(std::size_t point) const {
  const TetPoint& at = points_->points[point];
  const Vector3d from = at_point(at, body_->now_.x);
  const Vector3d to = at_point(at, body_->stage_.from) + ends_ * at_point(at, body_->way_);
  return {from, to, 0.5 * (from + to)};
}

void TetStep::add_force(std::size_t point, const Vector3d& force) {
  const TetPoint& at = points_->points[point];
  for (std::uint32_t i = 0; i < at.count; ++i)
    pushed_.segment<3>(row_of(at.nodes[i])) += at.shares[i] * force;
}

double TetStep::close() {
  body_->force_ = own_ + pushed_;
  return std::sqrt(body_->close_residual());
}

double TetStep::enough() const {
  return body_->stop_size(kMomentaTolerance);
}

void TetStep::residual(Out rows) const {
  rows = body_->residual_;
}

double TetStep::work_along(In direction) const {
  return ends_ * body_->residual_.dot(direction);
}

std::array<double, kMostNodes> TetStep::condensed(std::size_t point) const {
  const TetPoint& at = points_->points[point];
  std::array<double, kMostNodes> shares = at.shares;
  body_->system_.fold_point(std::span(at.nodes.data(), at.count),
                            std::span(shares.data(), at.count));
  for (std::uint32_t i = 0; i < at.count; ++i)
    if (body_->system_.active()[at.nodes[i]] == 0) shares[i] = 0.0;
  return shares;
}

// The matrix of the body itself.
void TetStep::assemble(double heavier, TangentKind tangent, bool with_contact) {
  TetMatrixFactors factors;
  factors.mass = (1.0 + heavier) * body_->mass_factor();
  factors.tangent = {1.0, body_->options_.beta * body_->stage_.rate, tangent};
  body_->system_.assemble(factors, body_->matrix_);
  contact_in_matrix_ = with_contact;
  if (with_contact)
    for (const Slope& slope : slopes_) add_contact(slope);
  for (std::size_t i = 0; i < still_.size(); ++i)
    still_[i] = body_->system_.active()[i] == 0 ? 1 : 0;
  body_->matrix_.hold(still_);
}

// The symmetric part of a contact. All pairs of its control points are of one element, so that the
// pattern has their blocks.
void TetStep::add_contact(const Slope& slope) {
  const TetPoint& at = points_->points[slope.point];
  const Matrix3d block = (0.5 * ends_) * (slope.by_end + slope.by_end.transpose());
  const BlockPattern& pattern = body_->matrix_.pattern();
  for (std::uint32_t i = 0; i < at.count; ++i)
    for (std::uint32_t j = 0; j <= i; ++j) {
      const double both = slope.shares[i] * slope.shares[j];
      if (both != 0.0) body_->matrix_.block(pattern.find(at.nodes[i], at.nodes[j])) += both * block;
    }
}

void TetStep::make_tangent(double heavier, bool follows) {
  (void)follows;
  heavier_ = heavier;
  slopes_.clear();
}

void TetStep::add_slope(std::size_t point, const Matrix3d& by_end, const Vector3d& force) {
  (void)force;  // its weights do not depend on the unknowns
  slopes_.push_back({point, condensed(point), by_end});
}

// The exact derivative with contact is tried first; where it is not positive, R K R^T.
bool TetStep::factor() {
  assemble(heavier_, body_->options_.tangent, true);
  if (!factor_) {
    for (std::size_t i = 0; i < inverse_.size(); ++i) {
      inverse_[i] = body_->matrix_.diagonal(i).inverse();
      if (!inverse_[i].allFinite()) inverse_[i].setIdentity();
    }
    return true;
  }
  if (factor_->factor(body_->matrix_)) return true;
  assemble(heavier_, TangentKind::kFrozen, true);
  if (factor_->factor(body_->matrix_)) return true;
  assemble(heavier_, TangentKind::kFrozen, false);
  return static_cast<bool>(factor_->factor(body_->matrix_));
}

void TetStep::multiply(In x, Out rows) const {
  in_ = x;
  body_->matrix_.multiply(in_, out_);
  rows = out_;
  for (const Slope& slope : slopes_) {
    const TetPoint& at = points_->points[slope.point];
    Vector3d part = Vector3d::Zero();
    for (std::uint32_t i = 0; i < at.count; ++i)
      part += slope.shares[i] * x.segment<3>(row_of(at.nodes[i]));
    const Matrix3d rest = contact_in_matrix_
                              ? Matrix3d(0.5 * (slope.by_end - slope.by_end.transpose()))
                              : slope.by_end;
    const Vector3d image = ends_ * (rest * part);
    for (std::uint32_t i = 0; i < at.count; ++i)
      rows.segment<3>(row_of(at.nodes[i])) += slope.shares[i] * image;
  }
}

void TetStep::precondition(In rows, Out x) {
  in_ = rows;
  if (factor_) {
    factor_->solve(in_);
    x = in_;
  } else {
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      x.segment<3>(row_of(i)) = inverse_[i] * rows.segment<3>(row_of(i));
  }
  for (std::size_t i = 0; i < still_.size(); ++i)
    if (still_[i] != 0) x.segment<3>(row_of(i)).setZero();
}

Vector3d TetStep::change_at(std::size_t point, In x) const {
  const TetPoint& at = points_->points[point];
  const std::array<double, kMostNodes> shares = condensed(point);
  Vector3d change = Vector3d::Zero();
  for (std::uint32_t i = 0; i < at.count; ++i)
    change += shares[i] * x.segment<3>(row_of(at.nodes[i]));
  return ends_ * change;
}

void TetStep::add_image(std::size_t point, const Vector3d& fall, Out rows) const {
  const TetPoint& at = points_->points[point];
  const std::array<double, kMostNodes> shares = condensed(point);
  for (std::uint32_t i = 0; i < at.count; ++i)
    rows.segment<3>(row_of(at.nodes[i])) += shares[i] * fall;
}

void TetStep::finish(const ContactAccount& account, double start) {
  const double before = account_.energy;
  account_ = account;
  account_.surplus = start - before;
  account_.given = account.work + account.energy - start + account.lost + account.rubbed;
  memories_.clear();
  contacted_.clear();
  body_->end();
  // A step of midpoint in place of newmark's has no acceleration at its end.
  body_->has_acceleration_ = false;
  body_->guard_.known = false;
  report_ = {};
}

void TetStep::remember(const ContactMemory& memory) {
  memories_.push_back(memory);
}

void TetStep::end() {
  std::sort(memories_.begin(), memories_.end(), is_before);
  body_->skip_step();
  body_->choose_degrees(report_);
}

void TetStep::give_up() {
  body_->restore_state();
  report_ = {};
  report_.converged = false;
}

}  // namespace tremolo
