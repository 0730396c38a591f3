#include "runtime/bodies/tets/motion/tet_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "runtime/bodies/tets/motion/tet_body.h"

namespace tremolo {
namespace {

constexpr double kShareOfWay = 0.8;    // of a supported body under a slow pull
constexpr double kFreePull = 2.0;      // Hz, frequency of a free body about the grab
constexpr double kDampingShare = 0.5;  // of critical damping
// The fraction of its mass with which a bar with one fixed end moves at the other (Rayleigh).
constexpr double kMovingShare = 33.0 / 140.0;

}  // namespace

TetHand hand_at(const TetModel& model, const TetsSurface& surface, std::size_t vertex) {
  TetHand hand;
  hand.nodes = model.elements()[surface.tetrahedra[vertex]].nodes;
  const Eigen::Vector4d& w = surface.weights[vertex];
  hand.shares = polynomials_at(2, {w[0], w[1], w[2], w[3]});
  return hand;
}

Status suit_springs(TetBody& body, TetHand& hand) {
  const auto held = body.model().held();
  double mass = body.model().mass();
  if (std::none_of(held.begin(), held.end(), [](std::uint8_t flag) { return flag != 0; })) {
    hand.stiffness = mass * std::pow(2.0 * std::numbers::pi * kFreePull, 2);
  } else {
    const Eigen::Matrix3d give = body.give_at(hand);
    const double most = give.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
    if (!(most > 0.0) || !std::isfinite(1.0 / most))
      return usage_error("no hand pulls there: the place is fixed");
    hand.stiffness = kShareOfWay / (1.0 - kShareOfWay) / most;
    mass *= kMovingShare;
  }
  hand.damping = 2.0 * kDampingShare * std::sqrt(hand.stiffness * mass);
  return Success{};
}

}  // namespace tremolo
