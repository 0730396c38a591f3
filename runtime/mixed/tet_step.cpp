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

Vector3d sum_of(std::span<const std::uint32_t> nodes, const std::array<double, kMostNodes>& shares,
                StepBody::In x) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) sum += shares[i] * x.segment<3>(row_of(nodes[i]));
  return sum;
}

void add_shares(std::span<const std::uint32_t> nodes, const std::array<double, kMostNodes>& shares,
                const Vector3d& value, StepBody::Out rows) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    rows.segment<3>(row_of(nodes[i])) += shares[i] * value;
}

}  // namespace

TetStep::TetStep(TetBody& body, std::shared_ptr<const TetPoints> points,
                 const ContactOptions& options, TetHullPointer hull)
    : body_(&body),
      points_(std::move(points)),
      law_(tremolo::area_law(*points_, body.model().mass(), options)),
      sums_(body),
      hull_(std::move(hull)),
      factor_(make_guest_factor(body.model().pattern())) {
  const Index n = body.model().rest().size();
  for (VectorXd* v :
       {&known_way_, &own_, &pushed_, &pushed_before_, &kept_, &in_, &out_, &end_, &middle_})
    v->setZero(n);
  still_.resize(body.model().nodes());
  slopes_.reserve(points_->points.size() + 1);  // a hand may hold a point in contact
  shares_.resize(points_->points.size());
  if (has_hull())
    for (std::vector<TetTree::Box>* boxes : {&boxes_at_start_, &boxes_at_end_})
      boxes->resize(hull_->tree.size());
  if (!factor_) inverse_.resize(body.model().nodes());
  body.given_.setZero(n);
}

Index TetStep::unknowns() const {
  return body_->model().rest().size();
}

StepBall TetStep::find_ball() {
  const VectorXd &x = body_->now_.x, &v = body_->now_.v;
  Vector3d low = x.head<3>(), high = low;
  double speed2 = 0.0;
  for (std::size_t i = 0; i < body_->model().nodes(); ++i) {
    low = low.cwiseMin(x.segment<3>(row_of(i)));
    high = high.cwiseMax(x.segment<3>(row_of(i)));
    speed2 = std::max(speed2, v.segment<3>(row_of(i)).squaredNorm());
  }
  follows_hull_ = false;
  if (has_hull()) hull_->tree.fit(x, boxes_at_start_);
  const double h = step_size();
  return {0.5 * (low + high), 0.5 * (high - low).norm(),
          h * std::sqrt(speed2) + 0.5 * h * h * body_->options_.gravity.norm()};
}

bool TetStep::step_alone() {
  give_before();
  report_ = body_->step();
  pushed_before_.setZero();
  jumped_ = report_.switched > 0;
  forget_contact();
  return report_.converged;
}

void TetStep::rest_a_step() {
  pushed_before_.setZero();
  report_ = {};
  jumped_ = false;
  body_->skip_step();
}

bool TetStep::is_fixed(std::size_t point) const {
  const std::span<const std::uint8_t> held = body_->model().held();
  const std::span<const std::uint32_t> nodes = nodes_of(point);
  return std::all_of(nodes.begin(), nodes.end(),
                     [held](std::uint32_t node) { return held[node] != 0; });
}

std::optional<std::size_t> TetStep::point_of(VertexId vertex) const {
  for (std::size_t i = 0; i < points(); ++i)
    if (points_->points[i].count == 1 &&
        points_->points[i].nodes[0] == static_cast<std::uint32_t>(vertex))
      return i;
  return std::nullopt;
}

std::vector<std::size_t> TetStep::points_on(const std::vector<VertexId>& vertices) const {
  std::vector<bool> chosen(body_->model().nodes(), false);
  for (const VertexId vertex : vertices) chosen[static_cast<std::size_t>(vertex)] = true;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < points(); ++i) {
    const TetPoint& point = points_->points[i];
    if (chosen[point.nodes[0]] && (point.count == 1 || chosen[point.nodes[1]])) found.push_back(i);
  }
  return found;
}

// A point between vertices has the first of them.
int TetStep::number_of(std::size_t point) const {
  return static_cast<int>(points_->points[point].nodes[0]);
}

Vector3d TetStep::start_of(std::size_t point) const {
  return at_point(points_->points[point], body_->now_.x);
}

void TetStep::begin() {
  const TetMethod method = body_->options_.method;
  body_->keep_state();
  body_->begin(method == TetMethod::kNewmark ? TetMethod::kMidpoint : method, step_size());
  body_->guess(false);
  ends_ = body_->stage_.method == TetMethod::kMidpoint ? 2.0 : 1.0;
  share_ = body_->stage_.method == TetMethod::kBdf2 ? 1.5 : 1.0;
  give_before();
  known_ = false;
  clear_holds();
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
    if (follows_hull_) {
      end_ = body_->stage_.from + ends_ * body_->way_;
      middle_ = 0.5 * (body_->now_.x + end_);
      hull_->tree.fit(end_, boxes_at_end_);
    }
  }
  pushed_.setZero();
}

SiteMotion TetStep::motion(std::size_t point) const {
  const TetPoint& at = points_->points[point];
  const Vector3d from = at_point(at, body_->now_.x);
  const Vector3d to = at_point(at, body_->stage_.from) + ends_ * at_point(at, body_->way_);
  return {from, to, 0.5 * (from + to)};
}

Status TetStep::settle(const Eigen::VectorXd& forces) {
  pushed_.setZero();
  body_->given_.setZero();
  for (std::size_t i = 0; i < points(); ++i) add_force(i, forces.segment<3>(row_of(i)));
  return body_->settle(pushed_);
}

void TetStep::add_force(std::size_t point, const Vector3d& force) {
  const TetPoint& at = points_->points[point];
  for (std::uint32_t i = 0; i < at.count; ++i)
    pushed_.segment<3>(row_of(at.nodes[i])) += at.shares[i] * force;
}

// The part of F' in a step of bdf2.
void TetStep::give_before() {
  body_->given_ = -0.5 * pushed_before_;
}

double TetStep::close() {
  body_->force_ = own_ + share_ * pushed_;
  return std::sqrt(body_->close_residual());
}

double TetStep::enough() const {
  return body_->stop_size(kGuestTolerance) + held_rounding(body_->now_.x.lpNorm<Eigen::Infinity>());
}

void TetStep::residual(Out rows) const {
  rows = body_->residual_;
}

double TetStep::work_along(In direction) const {
  return ends_ / share_ * body_->residual_.dot(direction);
}

void TetStep::condense(std::span<const std::uint32_t> nodes,
                       std::array<double, kMostNodes>& shares) const {
  body_->system_.fold_point(nodes, std::span(shares.data(), nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (body_->system_.active()[nodes[i]] == 0) shares[i] = 0.0;
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
  const Matrix3d block = (0.5 * ends_) * (slope.by_end + slope.by_end.transpose());
  const BlockPattern& pattern = body_->matrix_.pattern();
  for (std::size_t i = 0; i < slope.nodes.size(); ++i)
    for (std::size_t j = 0; j < slope.nodes.size(); ++j) {
      const double both = slope.shares[i] * slope.shares[j];
      if (both != 0.0 && slope.nodes[i] >= slope.nodes[j])
        body_->matrix_.block(pattern.find(slope.nodes[i], slope.nodes[j])) += both * block;
    }
}

void TetStep::make_tangent(double heavier, bool follows) {
  (void)follows;
  heavier_ = heavier;
  slopes_.clear();
}

void TetStep::add_slope(std::size_t point, const Matrix3d& by_end, const Vector3d& force) {
  (void)force;  // its weights do not depend on the unknowns
  shares_[point] = points_->points[point].shares;
  condense(nodes_of(point), shares_[point]);
  slopes_.push_back({nodes_of(point), shares_[point], share_ * by_end});
}

// A point stays with an element until it is outside by this share: at rest on the boundary of two
// it would change between them. The second one is where it stays outside of all elements.
constexpr double kKeptShare = 1e-5, kContinuedShare = 0.2;

std::optional<TetDepth> TetStep::depth_at(const VectorXd& x, const std::vector<TetTree::Box>& boxes,
                                          const Vector3d& place,
                                          std::optional<std::uint32_t> element, bool stays) const {
  std::optional<TetPlace> found;
  if (!stays) found = hull_->tree.find(x, boxes, place);
  // An element of a restored state may not exist.
  if (element && *element < body_->model().elements().size() &&
      !(found && found->element == *element)) {
    const bool inside = found && found->weights.minCoeff() >= 0.0;
    const double least = inside ? -kKeptShare : -kContinuedShare;
    const std::optional<TetPlace> kept = hull_->tree.solve(*element, x, place, least);
    if (kept && kept->weights.minCoeff() > least) found = kept;
  }
  if (!found && stays) found = hull_->tree.find(x, boxes, place);
  if (!found) return std::nullopt;
  const DistanceGrid::Sample sample = hull_->grid->at(hull_->tree.rest_place(*found));
  const auto turned = [&sample](const Matrix3d& slope) {
    return Vector3d(slope.transpose().inverse() * sample.gradient);
  };
  const Vector3d gradient = turned(found->gradient);
  const Vector3d normal = turned(hull_->tree.smooth_gradient(*found, x));
  if (!(gradient.squaredNorm() > 1e-12) || !gradient.allFinite()) return std::nullopt;
  if (!(normal.squaredNorm() > 1e-12) || !normal.allFinite()) return std::nullopt;
  return TetDepth{sample.distance, gradient, normal, found->element, found->values};
}

std::optional<TetDepth> TetStep::depth_at_start(const Vector3d& place,
                                                std::optional<std::uint32_t> element) const {
  return depth_at(body_->now_.x, boxes_at_start_, place, element, element.has_value());
}

std::optional<TetDepth> TetStep::depth_at_end(const Vector3d& place,
                                              std::optional<std::uint32_t> element,
                                              bool stays) const {
  return depth_at(end_, boxes_at_end_, place, element, stays);
}

bool TetStep::find_site(const Vector3d& place, std::uint32_t element, TetSite& site) const {
  constexpr double kFarOutside = -4.0;  // in barycentric coordinates
  const std::optional<TetPlace> found = hull_->tree.solve(element, middle_, place, kFarOutside);
  if (!found) return false;
  site.element = element;
  site.values = found->values;
  site.gradient = hull_->tree.smooth_gradient(*found, middle_);
  site.weights = found->weights;
  site.inverse = found->gradient.inverse();
  return true;
}

Vector3d TetStep::way_of(const TetSite& site) const {
  const std::span<const std::uint32_t> nodes = nodes_of(site);
  Vector3d way = Vector3d::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Index row = row_of(nodes[i]);
    way += site.values[i] * (end_.segment<3>(row) - body_->now_.x.segment<3>(row));
  }
  return way;
}

void TetStep::push_site(const TetSite& site, const Vector3d& force) {
  const std::span<const std::uint32_t> nodes = nodes_of(site);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    pushed_.segment<3>(row_of(nodes[i])) += site.values[i] * force;
}

void TetStep::condense(TetSite& site) const {
  site.shares = site.values;
  condense(nodes_of(site), site.shares);
}

void TetStep::find_slopes(TetSite& site) const {
  const auto& gradients = body_->model().elements()[site.element].element.geometry.gradients;
  for (Index a = 0; a < 4; ++a)
    for (Index b = 0; b <= a; ++b)
      site.slopes[kNodeAt[a][b]] = (a == b ? 1.0 : 2.0) * (site.weights[a] * gradients.col(b) +
                                                           site.weights[b] * gradients.col(a));
  std::array<double, kMostNodes> along;
  for (Index d = 0; d < 3; ++d) {
    for (std::size_t i = 0; i < along.size(); ++i) along[i] = site.slopes[i][d];
    condense(nodes_of(site), along);
    for (std::size_t i = 0; i < along.size(); ++i) site.slope_shares[i][d] = along[i];
  }
}

Matrix3d TetStep::way_slope(const TetSite& site) const {
  const std::span<const std::uint32_t> nodes = nodes_of(site);
  Matrix3d slope = Matrix3d::Zero();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Index row = row_of(nodes[i]);
    slope += (end_.segment<3>(row) - body_->now_.x.segment<3>(row)) * site.slopes[i].transpose();
  }
  return slope;
}

void TetStep::add_shifted_site(const TetSite& site, const Vector3d& force, const Vector3d& shift,
                               Out rows) const {
  const std::span<const std::uint32_t> nodes = nodes_of(site);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    rows.segment<3>(row_of(nodes[i])) += (share_ * site.slope_shares[i].dot(shift)) * force;
}

void TetStep::add_site_slope(const TetSite& site, const Matrix3d& by_end) {
  slopes_.push_back({nodes_of(site), site.shares, share_ * by_end});
}

Vector3d TetStep::change_of(const TetSite& site, In x) const {
  return ends_ * sum_of(nodes_of(site), site.shares, x);
}

void TetStep::add_site_image(const TetSite& site, const Vector3d& fall, Out rows) const {
  add_shares(nodes_of(site), site.shares, share_ * fall, rows);
}

// The exact derivative with contact is tried first; where it is not positive, R K R^T.
bool TetStep::factor(bool fresh) {
  assemble(heavier_, body_->options_.tangent, true);
  if (factor_ && !fresh) return true;
  if (factor_) factor_->leave_out(still_);
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
  return factor_->factor(body_->matrix_);
}

void TetStep::multiply(In x, Out rows) const {
  in_ = x;
  body_->matrix_.multiply(still_, in_, out_);
  rows = out_;
  for (const Slope& slope : slopes_) {
    const Matrix3d rest = contact_in_matrix_
                              ? Matrix3d(0.5 * (slope.by_end - slope.by_end.transpose()))
                              : slope.by_end;
    const Vector3d image = ends_ * (rest * sum_of(slope.nodes, slope.shares, x));
    add_shares(slope.nodes, slope.shares, image, rows);
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
  return ends_ * sum_of(nodes_of(point), shares_[point], x);
}

void TetStep::add_image(std::size_t point, const Vector3d& fall, Out rows) const {
  add_shares(nodes_of(point), shares_[point], share_ * fall, rows);
}

void TetStep::finish(const ContactAccount& account, double start, bool jumped) {
  take_account(account, start, jumped);
  jumped_ = false;
  body_->end();
  // A step of midpoint in place of newmark's has no acceleration at its end.
  body_->has_acceleration_ = false;
  body_->guard_.known = false;
  report_ = {};
}

void TetStep::end() {
  sort_memories();
  if (body_->options_.method == TetMethod::kBdf2) {
    // The mean over the parts of the step.
    if (part().from == 0.0) pushed_before_.setZero();
    pushed_before_ += (part().to - part().from) * pushed_;
  }
  if (!part().whole) return;
  body_->skip_step();
  body_->choose_degrees(report_);
  jumped_ = report_.switched > 0;
}

void TetStep::keep_whole() {
  whole_ = {body_->now_, body_->before_, body_->has_before_, pushed_before_};
}

// Parts of bdf2 are steps of implicit-euler.
void TetStep::begin_part() {
  body_->has_before_ = false;
}

// The step before the next one is the whole step.
void TetStep::end_whole(int parts) {
  TetBody& body = *body_;
  if (parts > 0) {
    body.before_.x = whole_.now.x;
    body.before_.v = whole_.now.v;
    body.has_before_ = true;
    report_.parts = parts;
    body.skip_step();
    body.choose_degrees(report_);
    jumped_ = report_.switched > 0;
    return;
  }
  body.now_ = whole_.now;
  body.before_ = whole_.before;
  body.has_before_ = whole_.has_before;
  pushed_before_ = whole_.pushed_before;
}

void TetStep::carry_body(StateStream& stream) {
  body_->carry(stream);
  stream(report_, sums_, pushed_before_);
  stream.require(pushed_before_.allFinite());
  jumped_ = report_.switched > 0;
}

void TetStep::give_up() {
  body_->restore_state();
  report_ = {};
  report_.converged = false;
}

}  // namespace tremolo
