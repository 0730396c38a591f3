// A sheet without tension has no stiffness across its plane, so that Newton's method alone does not
// find its equilibrium. The search repeats steps of implicit Euler from rest, each of which finds a
// minimum of M |x - x_k|^2/(2 h^2) + V(x), and lengthens h where a step succeeds: the potential
// falls in each (the proximal point method, Rockafellar 1976). Near the equilibrium Newton's method
// with the exact tangent ends it. That tangent also shows whether the equilibrium is stable.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "common/text.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/math/sparse/block_cholesky.h"
#include "runtime/step/implicit_solve.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kFirstStep = 0.05, kShortest = 1e-6, kLongest = 1e4;  // h, s
constexpr int kMostSearchSteps = 400, kMostSearchCorrections = 3000;
// Of the loads: of a step of the search near the equilibrium, and of one on the way to it.
constexpr double kSearchTolerance = 1e-9, kWayTolerance = 0.01, kFarFromRest = 0.05;
// Of the loads: Newton's method alone is tried below the first, and again at a fraction of that. If
// it fails below the last, the equilibrium has been found, and is not stable.
constexpr double kNearRest = 1e-4, kNearer = 0.1, kAtRest = 1e-8;
constexpr double kExactRest = 1e-12;    // of the loads
constexpr double kRestRounding = 1e-8;  // of the loads: above this a residual is no rounding
constexpr int kMostRestCorrections = 30;
constexpr double kFarAway = 1e3;  // of the cloth's size: a particle there falls
// The slowest oscillation of a stable equilibrium, as a fraction of that of a pendulum of the
// cloth's size: its square.
constexpr double kLeastFrequency = 1e-6;

// The cloth with constant forces.
class LoadedCloth final : public NodalSystem {
 public:
  LoadedCloth(const ClothModel& model, const VectorXd& forces) : model_(model), forces_(forces) {
    loads_ = forces;
    for (Index i = 0; i < model.mass().size(); ++i) {
      loads_.segment<3>(3 * i) += model.mass()[i] * model.gravity();
      if (model.held()[static_cast<std::size_t>(i)] != 0) loads_.segment<3>(3 * i).setZero();
    }
  }

  // Of gravity and the forces on free particles, N.
  const VectorXd& loads() const { return loads_; }

  std::size_t size() const override { return model_.size(); }
  const VectorXd& mass() const override { return model_.mass(); }
  std::span<const std::uint8_t> held() const override { return model_.held(); }
  const BlockPatternPointer& pattern() const override { return model_.pattern(); }
  double load_size() const override {
    const double size = loads_.norm();
    return size > 0.0 ? size : model_.load_size();
  }
  void put_held(double time, VectorXd& x) const override { model_.put_held(time, x); }
  void force(const VectorXd& x, const VectorXd& v, ForcePart part, VectorXd& f) const override {
    model_.force(x, v, part, f);
    f += forces_;
  }
  void add_tangent(const VectorXd& x, const VectorXd& v, ForcePart part, double position,
                   double velocity, double share, BlockMatrix& a) const override {
    model_.add_tangent(x, v, part, position, velocity, share, a);
  }
  double potential(const VectorXd& x) const override {
    return model_.potential(x) - forces_.dot(x);
  }
  StepWork power(const VectorXd& x, const VectorXd& v) const override { return model_.power(x, v); }
  StepWork step_force(const VectorXd& x0, const VectorXd& x1, double h,
                      VectorXd& f) const override {
    const StepWork work = model_.step_force(x0, x1, h, f);
    f += forces_;
    return work;
  }
  void add_step_tangent(const VectorXd& x0, const VectorXd& x1, double h, double share,
                        BlockMatrix& a) const override {
    model_.add_step_tangent(x0, x1, h, share, a);
  }

 private:
  const ClothModel& model_;
  const VectorXd& forces_;
  VectorXd loads_;
};

double size_of_cloth(const VectorXd& x) {
  const Eigen::Map<const Eigen::Matrix3Xd> points(x.data(), 3, x.size() / 3);
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

Error not_alone() {
  return {ErrorKind::kSolver,
          "its equilibrium is not the only one, or not stable: the sheet can turn "
          "about its pins or fold out of its plane without resistance; pin it at more places, add "
          "`crumple = 0.01` if it is flat, or leave `start` out"};
}

class ClothRest {
 public:
  ClothRest(const LoadedCloth& cloth, const VectorXd& start, BlockCholesky factor)
      : cloth_(cloth),
        x_(start),
        zero_(VectorXd::Zero(start.size())),
        force_(zero_),
        matrix_(cloth.pattern()),
        factor_(std::move(factor)),
        size_(size_of_cloth(start)) {}

  const VectorXd& positions() const { return x_; }

  // |f| of the free particles, N.
  double residual(const VectorXd& x) {
    cloth_.force(x, zero_, ForcePart::kAll, force_);
    const auto held = cloth_.held();
    for (std::size_t i = 0; i < held.size(); ++i)
      if (held[i] != 0) force_.segment<3>(3 * static_cast<Index>(i)).setZero();
    return force_.norm();
  }

  Status search() {
    NodalOptions options;
    options.solver = NodalSolver::kCholesky;
    options.tolerance = kSearchTolerance;
    Result<std::unique_ptr<ImplicitSolve>> exact = ImplicitSolve::create(cloth_, options);
    if (!exact) return exact.error();
    // On the way no step needs to be exact.
    options.tolerance = kWayTolerance;
    options.max_iterations = 150;
    Result<std::unique_ptr<ImplicitSolve>> quick = ImplicitSolve::create(cloth_, options);
    if (!quick) return quick.error();
    const VectorXd start = x_;
    int corrections = 0;
    double h = kFirstStep, near = kNearRest * cloth_.load_size();
    for (int k = 0; k < kMostSearchSteps && h >= kShortest && corrections < kMostSearchCorrections;
         ++k) {
      const double now = residual(x_);
      if (now <= near) {
        if (finish()) return Success{};
        near = kNearer * now;
        if (now <= kAtRest * cloth_.load_size()) return not_alone();
      }
      VectorXd x1 = x_;
      const ImplicitEquation equation{
          .mu = 1.0 / (h * h), .x0 = &x_, .x_hat = &x_, .v_hat = &zero_, .minimum = true};
      NodalReport report;
      ImplicitSolve& solve = now > kFarFromRest * cloth_.load_size() ? **quick : **exact;
      const bool solved = solve.solve(equation, x1, false, report);
      corrections += report.iterations;
      if (!solved) {
        h *= 0.2;
        continue;
      }
      x_ = x1;
      h = std::min(2.0 * h, kLongest);
      if (!((x_ - start).lpNorm<Eigen::Infinity>() < kFarAway * size_))
        return Error{ErrorKind::kSolver,
                     "a part of it falls without end: fix each part by `pins`, or leave `start` "
                     "out"};
    }
    return Error{ErrorKind::kSolver,
                 "no equilibrium was found: it folds in many ways under its loads; pin it at more "
                 "places, make it stiffer, or leave `start` out"};
  }

 private:
  // Newton's method with the exact tangent. False: that is not positive definite, or the method
  // does not converge; the positions are then unchanged.
  bool finish() {
    const VectorXd before = x_;
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kMostRestCorrections; ++i) {
      const double now = residual(x_);
      const double load = cloth_.load_size();
      if (now <= kExactRest * load || (now <= kRestRounding * load && now > 0.5 * last)) {
        if (factor_at(least_stiffness())) return true;
        break;
      }
      if (!(now <= load)) break;
      last = now;
      if (!factor_at(0.0)) break;
      residual(x_);
      factor_.solve(force_);
      x_ += force_;
    }
    x_ = before;
    return false;
  }

  // The tangent at x_ less `shift` times the mass.
  bool factor_at(double shift) {
    matrix_.set_zero();
    for (Index i = 0; i < cloth_.mass().size(); ++i)
      matrix_.diagonal(static_cast<std::size_t>(i))
          .diagonal()
          .setConstant(-shift * cloth_.mass()[i]);
    cloth_.add_tangent(x_, zero_, ForcePart::kAll, 1.0, 0.0, 1.0, matrix_);
    matrix_.hold(cloth_.held());
    return static_cast<bool>(factor_.factor(matrix_));
  }

  // 1/s^2.
  double least_stiffness() const {
    double loads = 0.0;
    for (Index i = 0; i < cloth_.mass().size(); ++i)
      loads += cloth_.loads().segment<3>(3 * i).norm();
    return kLeastFrequency * loads / cloth_.mass().sum() / size_;
  }

  const LoadedCloth& cloth_;
  VectorXd x_, zero_, force_;
  BlockMatrix matrix_;
  BlockCholesky factor_;
  double size_;  // m
};

// True if the cloth can turn about its fixed particles, which are on a line along which all loads
// act.
bool turns_freely(const LoadedCloth& cloth, const VectorXd& x) {
  constexpr double kParallel = 1e-9;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (Index i = 0; i < x.size(); i += 3)
    if (const Eigen::Vector3d load = cloth.loads().segment<3>(i); load.norm() > axis.norm())
      axis = load;
  const double most = axis.norm();
  if (!(most > 0.0)) return false;
  axis /= most;
  const auto held = cloth.held();
  const auto first = std::find_if(held.begin(), held.end(), [](auto flag) { return flag != 0; });
  const Index pivot = 3 * (first - held.begin());
  const double size = size_of_cloth(x);
  for (Index i = 0; i < x.size(); i += 3) {
    if (axis.cross(cloth.loads().segment<3>(i)).norm() > kParallel * most) return false;
    const Eigen::Vector3d arm = x.segment<3>(i) - x.segment<3>(pivot);
    if (held[static_cast<std::size_t>(i / 3)] != 0 && axis.cross(arm).norm() > kParallel * size)
      return false;
  }
  return true;
}

Result<VectorXd> rest_of(const ClothModel& model, const VectorXd& forces, const VectorXd& start) {
  const auto held = model.held();
  if (std::none_of(held.begin(), held.end(), [](std::uint8_t flag) { return flag != 0; }))
    return content_error(
        "it has no `pins` at t = 0, so that nothing holds it: pin some particles, or leave `start` "
        "out");
  const LoadedCloth cloth(model, forces);
  Result<BlockCholesky> factor = BlockCholesky::create(model.pattern());
  if (!factor) return factor.error();
  ClothRest rest(cloth, start, std::move(*factor));
  if (turns_freely(cloth, start)) return not_alone();
  if (cloth.loads().isZero(0.0) && rest.residual(start) <= kExactRest * model.load_size())
    return start;
  if (Status s = rest.search(); !s) return s.error();
  return rest.positions();
}

}  // namespace

Result<VectorXd> cloth_at_rest(const ClothModel& model, const VectorXd& forces,
                               const VectorXd& start) {
  Result<VectorXd> found = rest_of(model, forces, start);
  if (found) return found;
  return Error{found.error().kind, "start = \"static\": " + found.error().message};
}

}  // namespace tremolo
