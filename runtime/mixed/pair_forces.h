// Contact between two bodies of an island, or of a body with a collider: the forces between them
// and their derivatives. Forces on the two bodies are opposite, at one position.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/mixed/step_body.h"

namespace tremolo {

// The rate of two bodies, or of a body and a collider, in a step: one of all their points,
// whichever of the two feels them.
struct SharedRate {
  PairRate rate;
  double growth = 0.0;  // of the part that restitution takes, for the present direction
};

class PairForces {
 public:
  static constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

  virtual ~PairForces() = default;

  // Members of the island: the body of the points, and the obstacle, which is kNobody for a
  // collider.
  std::size_t first = 0, second = kNobody;
  SharedRate* shared = nullptr;  // of the two, which several couplings may have

  // Starts an attempt: nothing is kept.
  virtual void begin() = 0;
  // Computes the distances at the present unknowns of both and adds them to the rate; then, with
  // the rate of all, the forces, which are added to the bodies. Call them between evaluate() and
  // close() of both, with the same renewal.
  virtual void approach(const ContactRenewal& renewal) = 0;
  virtual void press(const ContactRenewal& renewal) = 0;
  // Adds the bodies' own slopes, between make_tangent() and factor().
  virtual void make_slopes(bool follows) = 0;
  // Adds the growth for the direction x to the shared one.
  virtual void add_growth(StepBody::In first_x, StepBody::In second_x) = 0;
  // Adds the rest of the matrix times x, once the growth is that of all. Without a second body its
  // vectors are empty.
  virtual void multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                        StepBody::Out second_rows) const = 0;
  // Call it where the step is solved. Adds points that came within the margin unnoticed. True if
  // there are any: the step must be solved with them.
  virtual bool add_missed() = 0;
  // Adds the energies to the accounts, and those at the start of the step to the starts, J.
  virtual void settle(ContactAccount& first_account, ContactAccount& second_account,
                      double& first_start, double& second_start) const = 0;
  virtual void remember() = 0;             // after finish() of both bodies
  virtual std::size_t acting() const = 0;  // number of points with a force
};

}  // namespace tremolo
