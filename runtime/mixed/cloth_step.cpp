#include "runtime/mixed/cloth_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/LU>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

PointAreas areas_of(const ClothBody& body) {
  PointAreas areas;
  const VectorXd& mass = body.model().mass();
  for (Index i = 0; i < mass.size(); ++i) {
    areas.masses.push_back(mass[i]);
    areas.areas.push_back(mass[i] / body.cloth().density);
    areas.area += areas.areas.back();
  }
  const VectorXd& x = body.model().parts().x;
  const Eigen::Map<const Eigen::Matrix3Xd> rest(x.data(), 3, mass.size());
  areas.extent = (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).maxCoeff();
  return areas;
}

// The margin is the cloth's thickness.
ContactLaw law_of_cloth(const ClothBody& body, const PointAreas& areas, ContactOptions options) {
  options.margin = body.cloth().thickness / areas.extent;
  options.friction = body.cloth().friction;
  options.restitution = body.cloth().restitution;
  return area_law(areas, body.mass(), options);
}

bool is_pinned(const ClothBody& body) {
  const std::span<const std::uint8_t> held = body.model().held();
  return std::any_of(held.begin(), held.end(), [](std::uint8_t flag) { return flag != 0; });
}

std::optional<QuickFactor> make_factor(const ClothBody& body) {
  if (body.options().solver == NodalSolver::kConjugateGradients) return std::nullopt;
  return make_guest_factor(body.model().pattern());
}

}  // namespace

std::string cloth_method_problem(std::string_view integrator) {
  if (integrator == "implicit-euler" || integrator == "midpoint" || integrator == "energy")
    return "";
  return "a cloth with the method '" + std::string(integrator) +
         "' cannot be in contact with other bodies, because their forces are found together with "
         "the end of the step: take implicit-euler, midpoint or energy";
}

ClothStep::ClothStep(ClothBody& body, const ContactOptions& options)
    : body_(&body),
      method_(body.integrator() == "implicit-euler" ? Method::kImplicitEuler : Method::kEnergy),
      areas_(areas_of(body)),
      law_(law_of_cloth(body, areas_, options)),
      pinned_(is_pinned(body)),
      matrix_(body.model().pattern()),
      factor_(make_factor(body)),
      ledger_(body.model(), true) {
  const Index n = body.state().x.size();
  for (VectorXd* v : {&way_, &known_way_, &kept_, &x1_, &v1_, &speed_, &force_, &inertia_, &pushed_,
                      &residual_, &in_, &out_, &missing_})
    v->setZero(n);
  slopes_.reserve(points() + 1);  // a hand may hold a particle in contact
  if (!factor_) inverse_.resize(points());
  x1_ = body.state().x;
  lacks_.set(1.0);
  assemble(false);
  for (std::size_t i = 0; i < points(); ++i)
    stiffest_ = std::max(stiffest_, matrix_.diagonal(i).diagonal().maxCoeff());
}

double ClothStep::mass_factor() const {
  const double h = step_size();
  return (method_ == Method::kImplicitEuler ? 1.0 : 2.0) / (h * h);
}

StepBall ClothStep::find_ball() {
  const ClothModel& model = body_->model();
  const VectorXd &x = body_->state().x, &v = body_->state().v;
  const double h = step_size();
  x1_ = x;
  put_held_nodes(model, end_time(), h, x, x1_, v1_);
  model.force(x, v, ForcePart::kAll, force_);
  Vector3d low = x.head<3>(), high = low;
  double travel = 0.0;
  for (std::size_t i = 0; i < points(); ++i) {
    const Vector3d place = at(x, i);
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
    // Springs hold a particle, so that their forces move it by little more than the thickness.
    const double pulled = 0.5 * h * h * at(force_, i).norm() / areas_.masses[i];
    const double falls = 0.5 * h * h * model.gravity().norm();
    const double way = is_held(i) ? (at(x1_, i) - place).norm()
                                  : h * at(v, i).norm() + falls + std::min(pulled, law_.margin);
    travel = std::max(travel, way);
  }
  return {0.5 * (low + high), 0.5 * (high - low).norm(), travel};
}

ContactLaw ClothStep::area_law_with(const ContactLaw& theirs) const {
  ContactLaw law = law_;
  if (pinned_)
    law.stiffness = std::max(law.stiffness, theirs.stiffness * theirs.margin / law.margin);
  return law;
}

bool ClothStep::step_alone() {
  forget_contact();
  return body_->step().made;
}

void ClothStep::begin() {
  const VectorXd &x = body_->state().x, &v = body_->state().v;
  const double h = step_size();
  x1_ = x + h * v;
  put_held_nodes(body_->model(), end_time(), h, x, x1_, v1_);
  way_ = x1_ - x;
  lacks_.set(0.0);
  known_ = false;
  clear_holds();
}

void ClothStep::go(double length, In direction) {
  for (std::size_t i = 0; i < points(); ++i)
    if (!is_held(i))
      way_.segment<3>(row_of(i)) =
          kept_.segment<3>(row_of(i)) - length * direction.segment<3>(row_of(i));
}

void ClothStep::evaluate(const ContactRenewal& renewal) {
  (void)renewal;
  pushed_.setZero();
  if (known_ && way_ == known_way_) return;
  const VectorXd &x = body_->state().x, &v = body_->state().v;
  const ClothModel& model = body_->model();
  const double h = step_size();
  x1_ = x + way_;
  if (method_ == Method::kEnergy) {
    work_ = model.step_force(x, x1_, h, force_);
  } else {
    speed_ = way_ / h;
    model.force(x1_, speed_, ForcePart::kAll, force_);
  }
  const double mu = mass_factor();
  for (Index i = 0; i < model.mass().size(); ++i)
    inertia_.segment<3>(3 * i) =
        (mu * model.mass()[i]) * (way_.segment<3>(3 * i) - h * v.segment<3>(3 * i));
  known_way_ = way_;
  known_ = true;
}

SiteMotion ClothStep::motion(std::size_t point) const {
  const Vector3d from = start_of(point), to = from + at(way_, point);
  return {from, to, 0.5 * (from + to)};
}

void ClothStep::add_force(std::size_t point, const Vector3d& force) {
  pushed_.segment<3>(row_of(point)) += force;
}

double ClothStep::close() {
  residual_ = inertia_ - force_ - pushed_;
  for (std::size_t i = 0; i < points(); ++i)
    if (is_held(i)) residual_.segment<3>(row_of(i)).setZero();
  return residual_.norm();
}

// Positions have rounding errors, which the springs turn into forces.
double ClothStep::enough() const {
  const double rounding = std::numeric_limits<double>::epsilon() * stiffest_ *
                          x1_.lpNorm<Eigen::Infinity>() *
                          std::sqrt(static_cast<double>(x1_.size()));
  return kGuestTolerance *
             ((force_ + pushed_).norm() + inertia_.norm() + body_->model().load_size()) +
         rounding + held_rounding(x1_.lpNorm<Eigen::Infinity>());
}

// Without what lacks_ says of the indefinite terms of springs under compression.
void ClothStep::assemble(bool with_contact) {
  const ClothModel& model = body_->model();
  const double h = step_size(), mu = (1.0 + heavier_) * mass_factor();
  matrix_.set_zero();
  for (std::size_t i = 0; i < points(); ++i)
    matrix_.diagonal(i).diagonal().setConstant(mu * model.mass()[static_cast<Index>(i)]);
  const double kept = lacks_.kept();
  if (method_ == Method::kEnergy) {
    model.add_step_tangent(body_->state().x, x1_, h, kept, matrix_);
  } else {
    model.add_tangent(x1_, speed_, ForcePart::kAll, 1.0, 1.0 / h, kept, matrix_);
  }
  contact_in_matrix_ = with_contact;
  if (with_contact)
    for (const Slope& slope : slopes_)
      matrix_.diagonal(slope.point) += 0.5 * (slope.by_end + slope.by_end.transpose());
  matrix_.hold(model.held());
}

void ClothStep::make_tangent(double heavier, bool follows) {
  heavier_ = heavier;
  exact_ = follows;
  slopes_.clear();
}

void ClothStep::add_slope(std::size_t point, const Matrix3d& by_end, const Vector3d& force) {
  (void)force;  // it acts at the particle, whatever the unknowns are
  if (!is_held(point)) slopes_.push_back({point, by_end});
}

void ClothStep::invert_diagonal() {
  for (std::size_t i = 0; i < inverse_.size(); ++i) {
    inverse_[i] = matrix_.diagonal(i).inverse();
    if (!inverse_[i].allFinite()) inverse_[i].setIdentity();
  }
}

// As much of the indefinite terms of the springs is kept as a factor allows, which makes the move
// one of descent.
bool ClothStep::factor(bool fresh) {
  if (!factor_) {
    lacks_.set(1.0);
    assemble(true);
    invert_diagonal();
    exact_ = false;
    return true;
  }
  if (!fresh && lacks_.fraction() == 0.0) {
    assemble(true);
    return true;
  }
  lacks_.less();
  for (;;) {
    assemble(true);
    if (factor_->factor(matrix_)) break;
    if (lacks_.fraction() == 1.0) {
      exact_ = false;
      assemble(false);
      return factor_->factor(matrix_);
    }
    lacks_.more();
  }
  exact_ = exact_ && lacks_.fraction() == 0.0;
  return true;
}

// Adds the terms that are not symmetric to the product out_ of the matrix and in_. Fixed particles
// have no motion in in_, and no rows of their own.
void ClothStep::add_missing_terms() const {
  const ClothModel& model = body_->model();
  const double h = step_size();
  for (std::size_t i = 0; i < points(); ++i)
    if (is_held(i)) in_.segment<3>(row_of(i)).setZero();
  missing_.setZero();
  if (method_ == Method::kEnergy)
    model.add_missing_step_product(body_->state().x, x1_, h, in_, missing_);
  else
    model.add_missing_product(x1_, speed_, 1.0, in_, missing_);
  for (std::size_t i = 0; i < points(); ++i)
    if (!is_held(i)) out_.segment<3>(row_of(i)) += missing_.segment<3>(row_of(i));
}

void ClothStep::multiply(In x, Out rows) const {
  in_ = x;
  matrix_.multiply(in_, out_);
  if (exact_) add_missing_terms();
  rows = out_;
  for (const Slope& slope : slopes_) {
    const Matrix3d rest = contact_in_matrix_
                              ? Matrix3d(0.5 * (slope.by_end - slope.by_end.transpose()))
                              : slope.by_end;
    rows.segment<3>(row_of(slope.point)) += rest * x.segment<3>(row_of(slope.point));
  }
}

void ClothStep::precondition(In rows, Out x) {
  if (factor_) {
    in_ = rows;
    factor_->solve(in_);
    x = in_;
  } else {
    for (std::size_t i = 0; i < inverse_.size(); ++i)
      x.segment<3>(row_of(i)) = inverse_[i] * rows.segment<3>(row_of(i));
  }
  for (std::size_t i = 0; i < points(); ++i)
    if (is_held(i)) x.segment<3>(row_of(i)).setZero();
}

Vector3d ClothStep::change_at(std::size_t point, In x) const {
  return is_held(point) ? Vector3d(Vector3d::Zero()) : Vector3d(x.segment<3>(row_of(point)));
}

void ClothStep::add_image(std::size_t point, const Vector3d& fall, Out rows) const {
  if (!is_held(point)) rows.segment<3>(row_of(point)) += fall;
}

// Fixed particles pass the force of contact to what fixes them.
void ClothStep::finish(const ContactAccount& account, double start, bool jumped) {
  take_account(account, start, jumped);
  const VectorXd& x0 = body_->state().x;
  const double h = step_size();
  x1_ = x0 + way_;
  v1_ = way_ / h;
  if (method_ != Method::kImplicitEuler) v1_ = 2.0 * v1_ - body_->state().v;
  put_held_nodes(body_->model(), end_time(), h, x0, x1_, v1_);
  double pinned = 0.0;
  for (std::size_t i = 0; i < points(); ++i)
    if (is_held(i)) pinned += pushed_.segment<3>(row_of(i)).dot(way_.segment<3>(row_of(i)));
  NodalReport report;
  report.made = true;
  const double held = held_work(body_->model(), force_, x0, x1_);
  ledger_.begin(body_->state());
  if (part().whole)
    body_->end_step(x1_, v1_);
  else
    body_->end_part(x1_, v1_);
  if (method_ == Method::kEnergy)
    ledger_.end(body_->state(), work_, held, report);
  else
    ledger_.end(body_->state(), h, 1.0, report);
  report.numerical += pinned - pushed_.dot(way_);
  report.held_work -= pinned;
  body_->add_work(report);
}

void ClothStep::end_whole(int parts) {
  if (parts > 0)
    body_->end_parts(parts);
  else
    body_->put_back(whole_);
}

}  // namespace tremolo
