#include <algorithm>
#include <utility>

#include <Eigen/Core>

#include "common/text.h"
#include "runtime/math/dense/decompositions.h"
#include "runtime/math/dense/dense_lu.h"
#include "runtime/scene/scene_start.h"

namespace tremolo {
namespace {

constexpr int kIterations = 15;
constexpr double kConverged = 1e-11;  // Newton's step relative to q; the next one is its square
constexpr double kLeastIncrement = 1.0 / 4096;

// q and the forces that hold it.
struct Standing {
  Eigen::VectorXd q, x;
};

class Solver {
 public:
  Solver(const Potential& potential, const Eigen::VectorXd& force, const Hold& hold)
      : potential_(potential),
        force_(force),
        hold_(hold),
        workspace_(potential.make_workspace(kUseTangent)),
        evaluation_(potential.make_evaluation()) {}

  // Solves for the shape under the fraction s of the force and of the target, starting at `at`;
  // false if there is none.
  bool solve(double s, Standing& at) {
    const Eigen::Index r = force_.size(), c = hold_.target.size();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(r + c, r + c);
    Eigen::VectorXd right(r + c);
    for (int i = 0; i < kIterations; ++i) {
      potential_.evaluate(at.q, kWantForce | kWantTangent, workspace_, evaluation_);
      matrix.topLeftCorner(r, r) = evaluation_.tangent;
      right.head(r) = s * force_ - evaluation_.force;
      if (c > 0) {
        matrix.topRightCorner(r, c) = -hold_.rows.transpose();
        matrix.bottomLeftCorner(c, r) = -hold_.rows;
        right.head(r) += hold_.rows.transpose() * at.x;
        right.tail(c) = hold_.rows * at.q - s * hold_.target;
      }
      const Eigen::VectorXd step = DenseLu(matrix).solve(right);
      if (!step.allFinite()) return false;
      at.q += step.head(r);
      at.x += step.tail(c);
      if (step.head(r).norm() <= kConverged * at.q.norm()) return true;
    }
    return false;
  }

  // True if the energy grows with every small motion that the hold permits.
  bool stable(const Standing& at) {
    potential_.evaluate(at.q, kWantTangent, workspace_, evaluation_);
    Eigen::MatrixXd tangent = evaluation_.tangent;
    if (hold_.target.size() > 0) {
      const Eigen::MatrixXd free = column_space(hold_.rows.transpose()).complement;
      tangent = (free.transpose() * tangent * free).eval();
    }
    return is_positive_definite(tangent);
  }

 private:
  const Potential& potential_;
  const Eigen::VectorXd& force_;
  const Hold& hold_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
};

}  // namespace

Result<Eigen::VectorXd> standing_shape(const Potential& potential, const Eigen::VectorXd& force,
                                       const Hold& hold) {
  const Eigen::Index r = potential.size(), c = hold.target.size();
  if (c > 0 && column_space(hold.rows.transpose()).rank < c)
    return content_error(
        "the model's coordinates cannot displace it in every direction: it is fixed, or the model "
        "has too few");
  Standing at{Eigen::VectorXd::Zero(r), Eigen::VectorXd::Zero(c)};
  if (force.isZero(0.0) && (c == 0 || hold.target.isZero(0.0))) return at.q;
  Solver solver(potential, force, hold);
  for (double reached = 0.0, increment = 1.0; reached < 1.0;) {
    const double next = std::min(reached + increment, 1.0);
    Standing trial = at;
    if (solver.solve(next, trial)) {
      at = std::move(trial);
      reached = next;
      increment *= 2;
    } else if ((increment *= 0.5) < kLeastIncrement) {
      return Error{ErrorKind::kSolver,
                   "no shape at rest was found beyond " + number_text(reached) + " of it"};
    }
  }
  if (!solver.stable(at))
    return Error{ErrorKind::kSolver, "the shape at rest is not stable: it would snap away"};
  return at.q;
}

}  // namespace tremolo
