#include "runtime/viewer/live/live_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

#include "common/number_text.h"

namespace tremolo {
namespace {

constexpr double kShareOfWay =
    0.8;  // of the hand's displacement that the body follows under a slow pull
constexpr double kFreePull = 2.0;      // Hz, with which a free body swings about the hand
constexpr double kDampingShare = 0.5;  // of the critical one

}  // namespace

HandSprings suitable_springs(const ContactBody& body, const VertexRows& place) {
  // Compliance of the vertex at rest, m/N; its inverse mass, 1/kg, is below.
  const Eigen::Matrix3d give =
      place.rows * body.model().lambda().cwiseInverse().asDiagonal() * place.rows.transpose();
  const double most = give.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  const double inverse_mass =
      Eigen::Matrix3d(place.rows * place.rows.transpose()).diagonal().mean();
  double stiffness = kShareOfWay / (1.0 - kShareOfWay) / most;
  double mass = 1.0 / std::max(inverse_mass, 1e-30);
  if (body.frame() == FrameKind::kFree && body.model().inertia() != nullptr) {
    mass = body.model().inertia()->mass;
    stiffness = mass * std::pow(2.0 * std::numbers::pi * kFreePull, 2);
  }
  return {stiffness, 2.0 * kDampingShare * std::sqrt(stiffness * mass)};
}

void LiveHand::make_holdable(SceneWorld& world) {
  for (std::size_t i = 0; i < world.size(); ++i) {
    ContactBody& body = world.body(i);
    if (body.contact() == nullptr) {
      // As the scene would if it had the hand.
      ContactOptions contact = world.scene().bodies[i].contact;
      contact.colliders = world.scene().bodies[i].feels_contact;
      // For a body that cannot be grabbed the error is reported when the user tries.
      (void)body.set_contact(contact);
    }
    if (body.contact() != nullptr) body.reserve_contact(world.colliders(), 2);
  }
}

Status LiveHand::take(SceneWorld& world, const SceneWorld::Hit& hit, double firmness) {
  let_go(world);
  ContactBody& body = world.body(hit.body);
  const auto refused = [&](const std::string& why) {
    return usage_error(world.name(hit.body) + ": " + why);
  };
  Result<VertexRows> place = body.model().vertex(hit.hit.vertex);
  if (!place) return refused(place.error().message);
  if (body.frame() != FrameKind::kFree && place->rows.isZero(0.0))
    return refused("vertex " + std::to_string(hit.hit.vertex) + " does not move, it is fixed");
  if (body.contact() == nullptr) {
    const Status why = body.set_contact();
    return refused("no hand holds it: " + (why ? "it was made without" : why.error().message));
  }
  body_ = hit.body;
  vertex_ = hit.hit.vertex;
  place_ = std::move(*place);
  springs_ = suitable_springs(body, place_);
  // A number that is written with few digits, so that a record of it says the same.
  for (double* number : {&springs_.stiffness, &springs_.damping})
    *number = std::stod(number_text(*number * firmness));
  begun_ = held(world);
  way_.setZero();
  const Result<std::size_t> number =
      body.grab(vertex_, place_, springs_.stiffness, springs_.damping);
  if (!number) return refused(number.error().message);
  number_ = *number;
  return Success{};
}

Eigen::Vector3d LiveHand::held(const SceneWorld& world) const {
  const ContactBody& body = world.body(body_);
  return body.pose() * Eigen::Vector3d(place_.rest + place_.rows * body.state().q);
}

void LiveHand::before_step(SceneWorld& world) {
  // The number is valid, since the body returned it, and the point is finite.
  if (number_) (void)world.body(body_).move_hand(*number_, point());
}

void LiveHand::let_go(SceneWorld& world) {
  if (number_) (void)world.body(body_).release(*number_);
  number_.reset();
}

}  // namespace tremolo
