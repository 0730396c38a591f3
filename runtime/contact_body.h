// A body that meets colliders and other bodies, and that hands hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/bodies/reduced/bones/bone_points.h"
#include "runtime/body.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"

namespace tremolo {

class BodyGroup;
class ContactStep;
struct ContactNear;
struct ContactPoints;
enum class PartReason;

// Sums of contact since the start. work = given - lost - friction_loss - growth of
// contact_account().energy + error.
struct ContactSums {
  double work = 0.0;           // on the body, a part of BodySums::work, J
  double lost = 0.0;           // taken by restitution, J
  double friction_loss = 0.0;  // taken by friction, J
  double given = 0.0;          // by moving colliders, J
  // Contact energy found at the start of a step but not at the end of the step before, J; it should
  // be zero.
  double error = 0.0;
  double hand = 0.0;   // work of grabs on the body, a part of BodySums::work, J
  double joint = 0.0;  // the same for joints, J

  void carry(StateStream& stream) { stream(work, lost, friction_loss, given, error, hand, joint); }
};

// The present place of a body with contact.
struct PresentPlace {
  Pose pose;                                // of its one frame
  std::shared_ptr<const BonePoints> bones;  // of a body on several bones; else null
  // A ball around its boundary and its shape, m, world.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  // Of a body that is deformed: its contact points and their displacements, m; else null and empty.
  std::shared_ptr<const ContactPoints> points = nullptr;
  Eigen::VectorXd displacement = {};

  // A position of the world in the mesh's coordinates; on several bones nullopt if it is outside
  // the body, far from each of them. Not for two threads at once.
  std::optional<Eigen::Vector3d> into_rest(const Eigen::Vector3d& x) const;
  // The depth of a position of the world in the body's shape, m; below 0: it is outside, and minus
  // infinity where it is outside the ball by more than `near`.
  double depth_in(const Collider& shape, const Eigen::Vector3d& x, double near = 0.0) const;
};

// Without set_contact() it is a Body. Not thread-safe; different bodies may step on different
// threads.
class ContactBody : public Body {
 public:
  explicit ContactBody(Body&& body) : Body(std::move(body)) {}
  // Errors as Body::create.
  static Result<ContactBody> create(Model::Pointer model,
                                    std::string_view integrator = kDefaultIntegrator,
                                    const IntegratorOptions& options = {},
                                    FrameKind frame = FrameKind::kFixed);
  static Result<ContactBody> create(Model::Pointer model, std::string_view integrator,
                                    const IntegratorOptions& options,
                                    std::shared_ptr<const Skin> skin);

  // As those of Body, with contact and grabs. A saved body with other contact is refused.
  std::vector<std::byte> save() const;
  Status restore(std::span<const std::byte> bytes);
  void carry(StateStream& stream);
  std::uint64_t content_hash() const;
  Status set_damping(double alpha, double beta) { return set_damping({{alpha, beta}, {}, {}}); }
  Status set_damping(const DampingRatios& damping);
  // kUsage also for a method that does not support contact.
  Status set_method(std::string_view integrator, double step);

  // Enables contact with colliders. Error kUsage: options out of range, a method that does not
  // support contact (a fixed body supports any; near a collider it takes the step of
  // runtime/contact/solve/contact_step.h), a model without inertia integrals.
  Status set_contact(const ContactOptions& options = {});
  // Energy balance of contact in the last step; zeros without contact.
  ContactAccount contact_account() const;
  const ContactSums& contact_sums() const { return touched_; }
  const ContactStep* contact() const { return contact_.get(); }
  // Replaces the contact by that of an earlier call, or by none, and returns the one until now: for
  // a world that takes a change back.
  std::shared_ptr<ContactStep> exchange_contact(std::shared_ptr<ContactStep> other = nullptr) {
    contact_.swap(other);
    return other;
  }
  // Reserves memory for steps among these colliders with this number of grabs; call set_contact()
  // first.
  void reserve_contact(std::span<const PlacedCollider> colliders, std::size_t hands);

  // As Body::step() among colliders, which must stay in memory until it returns; call set_contact()
  // first.
  StepReport step(std::span<const PlacedCollider> colliders = {});

  // Grabs a vertex at its position by a spring (N/m) and a damper (N s/m) to a point that
  // move_hand() moves. Returns the grab's number. Needs set_contact(). A spring stiffer than that
  // of stiffest_hand() is replaced by that spring and its damper, as for pin(): beyond it rounding
  // errors exceed the step's tolerance. A damper is limited to h/2 times that stiffness.
  // hand_spring() returns the values in use. Errors as Model::vertex; kUsage for values that are
  // not finite or negative, and for a vertex without weights of the body's bones.
  Result<std::size_t> grab(VertexId vertex, double stiffness, double damping = 0.0);
  // The same for a vertex from Model::vertex: allocates nothing where reserve_contact() has
  // reserved memory.
  Result<std::size_t> grab(VertexId vertex, VertexRows place, double stiffness, double damping);
  // The same at any point of a surface, as returned by pick(). Errors as Model::place, and kUsage
  // for a body on several bones.
  Result<std::size_t> grab(const SurfacePlace& place, double stiffness, double damping = 0.0);
  // Holds a vertex, or a point of a surface, at its position, or where move_hand() moves it, until
  // release(). The stiffness follows from mass and step, k = (30/h)^2 m, and the damper is 60 m/h,
  // with m the effective mass of the point in a step. Under a force F the point is displaced by
  // F/k; with a hanging body of mass M by M g h^2/(900 m). An initial motion decays by an eighth in
  // each step. Errors as grab(), and kUsage for a point that cannot move.
  Result<std::size_t> pin(VertexId vertex);
  Result<std::size_t> pin(const SurfacePlace& place);
  Result<std::size_t> pin(VertexId vertex, VertexRows place);  // as grab() of such a vertex
  // The spring and damper of a pin at the point with the present step; infinite for a point that
  // cannot move.
  HandSpring stiffest_hand(const VertexRows& place) const;
  // Sets the grab's point at the end of the next step, m, world. Error kUsage: no such grab, not
  // finite.
  Status move_hand(std::size_t hand, const Eigen::Vector3d& place);
  bool has_hand(std::size_t hand) const { return find_hand(hand) != nullptr; }
  std::span<const Grip> grips() const { return grips_; }  // those that are not released
  // The force on the body in the last step, N, world; the hand feels the opposite. Zero if there is
  // no such grab.
  Eigen::Vector3d hand_force(std::size_t hand) const;
  // The spring and damper in use; zeros if there is no such grab. A longer step (set_method()) may
  // lower them again.
  HandSpring hand_spring(std::size_t hand) const;
  // Ends a grab; numbers of other grabs are unchanged.
  Status release(std::size_t hand);
  // Allocates for a body on several bones; needs set_contact().
  PresentPlace present_place() const;
  // The present position of a contact point, m, world; needs set_contact().
  Eigen::Vector3d contact_point(std::size_t point) const;
  // The present position of a vertex from Model::vertex without the response to forces, m, world.
  Eigen::Vector3d place_now(VertexId vertex, const VertexRows& place) const;
  // The effective mass of a point for a force in a step, the mean over all directions, kg; infinite
  // for a point that cannot move. A coordinate of the frequency omega has the resistance 1 + (h
  // omega)^2/4.
  double mass_at(const VertexRows& place) const;
  // Of a body on several bones, for places of joints.
  using Body::bone_maps;
  using Body::weights_of;

 private:
  // The parts of a step, for groups of bodies that touch each other.
  friend class BodyGroup;
  friend class StepParts;
  std::optional<StepReport> begin_step() {
    booked_ = false;
    return Body::begin_step();
  }
  bool near_something(std::span<const PlacedCollider> colliders);
  Eigen::Vector3d blend(const Eigen::Vector3d& y, std::span<const double> weights) const;
  ContactNear near(std::span<const PlacedCollider> colliders, std::span<Grip> grips);
  StepReport advance_near(bool near);
  StepReport advance_in_parts(const StepReport& failure, PartReason reason);
  void end_contact();
  StepReport end_step(StepReport report);
  void book_step(const StepReport& report);
  StepPush step_push() const;
  void fall_asleep();
  void keep_outside_sums() override { sound_touched_ = touched_; }
  void put_back_outside_sums() override { touched_ = sound_touched_; }
  const Grip* find_hand(std::size_t hand) const;
  Grip* find_hand(std::size_t hand);
  void limit_hand(Grip& grip) const;
  void carry_hands(StateStream& stream);

  std::shared_ptr<ContactStep> contact_;  // its type is incomplete here; it is not shared
  ContactSums touched_, sound_touched_;   // the latter at the last valid check of the energy
  std::vector<Grip> grips_;               // those that are not released
  std::vector<std::size_t> hands_;        // the number of each
  std::size_t next_hand_ = 0;
  std::vector<StepMaps> grip_maps_;  // of a body on several bones, one a grab
  bool booked_ = false;  // the present step was taken in parts whose energies are in the sums
  Eigen::VectorXd p_before_;
};

}  // namespace tremolo
