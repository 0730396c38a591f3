// TetBody::settle: the equilibrium of a body under gravity and constant forces.
//
// The forces F are applied in growing parts s. Newton's method solves E^T (s F - dW(x)) = 0 at each
// of them, from the state before it. A part counts only if its state is near the one that the
// tangent before it predicts and if the tangent is positive definite there: the states then form
// one path of stable equilibria from the shape at rest, and its end is the only one on that path.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "common/text.h"
#include "runtime/bodies/tets/motion/tet_body.h"

namespace tremolo {
namespace {

constexpr double kExact = 1e-12;      // of the forces: the residual at rest
constexpr double kRounded = 1e-8;     // of the forces: below this a residual may be rounding
constexpr double kLost = 1e4;         // of the forces: a larger residual leads nowhere
constexpr int kMostCorrections = 50;  // of one part of the forces
constexpr double kLeastPart = 1e-5;
constexpr double kNear = 0.25;      // of the predicted displacement
constexpr int kMostChoices = 20;    // of the edges' degrees
constexpr double kLinear = 1e-9;    // residual of a correction without a factor
constexpr int kMostLinear = 20000;  // directions of such a correction
constexpr std::size_t kMostRestFactorBytes = std::size_t{2} << 30;
// A factorisation with more multiplications takes longer than conjugate gradients.
constexpr double kMostMultiplications = 1e11;

Eigen::Index row_of_node(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

// False: the fixed control points in `held` leave a rotation.
bool span_a_triangle(const std::vector<Eigen::Vector3d>& held) {
  if (held.size() < 3) return false;
  const auto far = std::max_element(held.begin(), held.end(), [&](const auto& a, const auto& b) {
    return (a - held[0]).squaredNorm() < (b - held[0]).squaredNorm();
  });
  const Eigen::Vector3d axis = *far - held[0];
  constexpr double kLeastAngle = 1e-6;
  return std::any_of(held.begin(), held.end(), [&](const Eigen::Vector3d& one) {
    return axis.cross(one - held[0]).norm() > kLeastAngle * axis.squaredNorm();
  });
}

// The reason why fixed vertices do not hold every part of the mesh, whose elements share vertices;
// empty: they do.
std::string loose_part(const TetModel& model) {
  const auto has_held = [](std::uint8_t flag) { return flag != 0; };
  if (std::none_of(model.held().begin(), model.held().end(), has_held))
    return "it has no fixed vertices, so that nothing holds it: fix some "
           "(tremolo-precompute tets --fix), or leave `start` out";
  std::vector<std::uint32_t> roots(model.nodes());
  std::iota(roots.begin(), roots.end(), 0U);
  const auto root = [&roots](std::uint32_t node) {
    while (roots[node] != node) node = roots[node] = roots[roots[node]];
    return node;
  };
  for (const TetModelElement& element : model.elements())
    for (const std::uint32_t node : element.nodes) roots[root(node)] = root(element.nodes[0]);
  std::vector<std::vector<Eigen::Vector3d>> held(model.nodes());
  for (std::uint32_t i = 0; i < model.nodes(); ++i)
    if (model.held()[i] != 0) held[root(i)].push_back(model.rest().segment<3>(row_of_node(i)));
  std::vector<std::uint8_t> seen(model.nodes(), 0);
  for (const TetModelElement& element : model.elements()) {
    const std::uint32_t part = root(element.nodes[0]);
    if (seen[part] != 0) continue;
    seen[part] = 1;
    if (span_a_triangle(held[part])) continue;
    return "the part of its mesh with vertex " + std::to_string(element.nodes[0]) +
           " can still move: " +
           (held[part].empty() ? "none of its vertices is fixed"
                               : "its fixed vertices are on one line or at one point") +
           ", so that it has no single equilibrium; fix three or more that are not on a line "
           "(tremolo-precompute tets --fix), or leave `start` out";
  }
  return "";
}

}  // namespace

class TetRest {
 public:
  // load: of gravity and other forces, N.
  TetRest(TetBody& body, Eigen::VectorXd load)
      : body_(body), load_(std::move(load)), x_(body.now_.x), forces_(load_.norm()) {
    Result<BlockCholesky> made =
        BlockCholesky::create(body.model().pattern(), kMostRestFactorBytes);
    if (made && made->multiplications() <= kMostMultiplications) factor_.emplace(std::move(*made));
  }

  // From the state without forces.
  Status follow() {
    double done = 0.0, part = 1.0;
    while (done < 1.0) {
      const double next = std::min(1.0, done + part);
      const TetSystem kept = body_.system_;
      const Eigen::VectorXd from = x_;
      if (solve(next, &from) && is_stable()) {
        done = next;
        part *= 2.0;
        continue;
      }
      body_.system_ = kept;
      x_ = from;
      part *= 0.5;
      if (part < kLeastPart) return not_found(done);
    }
    return Success{};
  }

  // From a state near it, after a change of degrees.
  Status correct_at(const Eigen::VectorXd& x) {
    x_ = x;
    return solve(1.0, nullptr) && is_stable() ? Status(Success{}) : not_found(1.0);
  }

  const Eigen::VectorXd& positions() const { return x_; }

 private:
  // Leaves E^T (s F - dW) in residual_ of the body, and the same before E^T in its force_.
  double residual(double s) {
    body_.system_.follow_ends(x_);
    body_.system_.evaluate(x_);
    body_.s_ = x_;
    body_.inertia_.setZero();
    body_.force_ = s * load_;
    body_.system_.add_force(body_.force_);
    body_.residual_ = body_.force_;
    body_.system_.fold(body_.residual_);
    clear_inactive(body_.residual_);
    return body_.residual_.norm();
  }

  void clear_inactive(Eigen::VectorXd& y) const {
    const auto active = body_.system_.active();
    for (std::size_t i = 0; i < active.size(); ++i)
      if (active[i] == 0) y.segment<3>(row_of_node(i)).setZero();
  }

  // correction_ = K^-1 residual_ at the last evaluated positions. False: K is not positive
  // definite.
  bool find_correction(double tolerance) {
    body_.system_.assemble({0.0, {1.0, 0.0, TangentKind::kExact}}, body_.matrix_);
    if (factor_) {
      const auto active = body_.system_.active();
      still_.resize(active.size());
      for (std::size_t i = 0; i < active.size(); ++i) still_[i] = active[i] == 0 ? 1 : 0;
      body_.matrix_.hold(still_);
      if (!factor_->factor(body_.matrix_)) return false;
      body_.correction_ = body_.residual_;
      factor_->solve(body_.correction_);
    } else if (!body_.solve_
                    .solve(body_.matrix_, body_.residual_, tolerance, kMostLinear,
                           body_.correction_)
                    .positive) {
      return false;
    }
    body_.system_.follow_ends(body_.correction_);
    return body_.correction_.allFinite();
  }

  // from: null, or the state before, near whose prediction the solution must be.
  bool solve(double s, const Eigen::VectorXd* from) {
    Eigen::VectorXd predicted;
    positive_ = true;
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kMostCorrections; ++i) {
      const double size = residual(s);
      const double rounding = body_.stop_size(0.0);
      if (!(size <= kLost * forces_ + rounding)) return false;
      const bool rounded = size <= kRounded * forces_ && size > 0.5 * before;
      if (size <= kExact * forces_ + rounding || rounded)
        return from == nullptr || predicted.size() == 0 ||
               (x_ - *from - predicted).norm() <= kNear * predicted.norm();
      before = size;
      positive_ = find_correction(kLinear);
      if (!positive_) return false;
      x_ += body_.correction_;
      if (i == 0) predicted = body_.correction_;
    }
    return false;
  }

  // Without a factor directions with a negative curvature are searched from a vector that has all
  // of them.
  bool is_stable() {
    if (!factor_) {
      std::uint32_t number = 1;
      for (Eigen::Index i = 0; i < body_.residual_.size(); ++i) {
        number = number * 1664525U + 1013904223U;
        body_.residual_[i] = static_cast<double>(number >> 8) / (1 << 23) - 1.0;
      }
      body_.system_.fold(body_.residual_);
      clear_inactive(body_.residual_);
    }
    positive_ = find_correction(kLinear);
    return positive_;
  }

  Error not_found(double done) const {
    const std::string where = number_text(done) + " of its weight and loads";
    if (!positive_)
      return {ErrorKind::kSolver,
              "beyond " + where +
                  " the stiffness stops being positive: it buckles or snaps through, and has no "
                  "single equilibrium; make it stiffer or its loads smaller, or leave `start` out"};
    return {ErrorKind::kSolver, "no state at rest was found beyond " + where +
                                    "; make it stiffer or its loads smaller, or leave `start` out"};
  }

  TetBody& body_;
  Eigen::VectorXd load_, x_;
  double forces_;  // |load_|, N
  bool positive_ = true;
  std::optional<BlockCholesky> factor_;
  std::vector<std::uint8_t> still_;
};

Status TetBody::settle(const Eigen::VectorXd& forces) {
  const auto refused = [](const Error& error) {
    return Error{error.kind, "start = \"static\": " + error.message};
  };
  if (const std::string problem = loose_part(model()); !problem.empty())
    return refused(content_error(problem));
  if (hand_) return refused(usage_error("a hand holds it"));
  Eigen::VectorXd load = forces;
  for (std::size_t i = 0; i < model().nodes(); ++i)
    load.segment<3>(row_of_node(i)) += weight_[row_of_node(i)] * options_.gravity;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(load.size());
  if (load.isZero(0.0)) return set_state(now_.x, none);
  const bool chooses = options_.degree.kind == DegreeKind::kAdaptive;
  const TetSystem before = system_;
  const auto failed = [&](const Error& error) {
    system_ = before;
    solve_.choose(system_.active());
    return refused(error);
  };
  if (chooses) {
    system_.set_degrees(std::vector<std::uint8_t>(model().edges(), 2));
    solve_.choose(system_.active());
  }
  TetRest rest(*this, std::move(load));
  if (Status s = rest.follow(); !s) return failed(s.error());
  // The edges get the degrees that they would keep at rest.
  for (int k = 0; chooses && k < kMostChoices; ++k) {
    choice_ = DegreeChoice(model(), options_.degree);
    if (Status s = set_state(rest.positions(), none); !s) return failed(s.error());
    system_.evaluate(now_.x);
    const auto wanted = choice_.choose(system_, now_,
                                       {.residual = force_,
                                        .noise = edge_noise(),
                                        .energy = system_.energy(),
                                        .rate = 0.0,
                                        .h = options_.step,
                                        .calm = true});
    if (choice_.changed() == 0) break;
    set_degrees(wanted);
    if (Status s = rest.correct_at(now_.x); !s) return failed(s.error());
  }
  return set_state(rest.positions(), none);
}

}  // namespace tremolo
