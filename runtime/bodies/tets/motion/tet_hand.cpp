#include "runtime/bodies/tets/motion/tet_hand.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "runtime/bodies/tets/motion/tet_body.h"
#include "runtime/contact/springs.h"

namespace tremolo {
namespace {

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
  const double mass = body.model().mass();
  HandSpring spring;
  if (std::none_of(held.begin(), held.end(), [](std::uint8_t flag) { return flag != 0; })) {
    spring = swinging_spring(mass);
  } else {
    const Eigen::Matrix3d give = body.give_at(hand);
    const double most = give.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
    if (!(most > 0.0) || !std::isfinite(1.0 / most))
      return usage_error("no hand pulls there: the place is fixed");
    spring = pulling_spring(most, kMovingShare * mass);
  }
  hand.stiffness = spring.stiffness;
  hand.damping = spring.damping;
  return Success{};
}

}  // namespace tremolo
