// A scene that goes: its bodies, stepped together.
//
// Each step takes every body from t to t + h. A driven body is told where its frame will be and how
// it moves on the way, from the poses of its motion at t - h, t, t + h and t + 2h; gravity is that
// of the middle of the step. Colliders move from pose to pose of their motion; every body touches
// all of them, and the other bodies that have a shape (runtime/contact/solve/body_group.h). What a
// body does depends on nothing but the scene's entries of it, of what it touches and of its hands,
// bit for bit: not on the order in which they stand (bodies are taken by their names).
//
// A step of a body that cannot be made leaves it where it was, and it stands still from then on;
// the others go on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "formats/saved/saved_file.h"
#include "runtime/contact/solve/body_group.h"
#include "runtime/contact_body.h"
#include "runtime/scene/energy_account.h"
#include "runtime/scene/motion.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_bones.h"
#include "runtime/scene/scene_colliders.h"
#include "runtime/scene/scene_hands.h"
#include "runtime/scene/scene_joints.h"
#include "runtime/values/momenta.h"

namespace tremolo {

// Where a body touched something in the last step in which it did, and its impulse since that
// began.
struct ContactPlace {
  double impulse = 0.0;                            // sum of |F| h, N s
  Eigen::Vector3d push = Eigen::Vector3d::Zero();  // sum of F h on the body, N s, world
  Eigen::Vector3d position = push, normal = push;  // means of the points that pushed, each
                                                   // weighted by its impulse: m, world; out of
                                                   // what is touched, of length 1 (zero if the
                                                   // normals cancel)

  void carry(StateStream& stream) { stream(impulse, push, position, normal); }
};

// A body that began to touch a collider or another body in the last step, or that did not touch it
// any more. Points that leave for a single step end a contact: who wants long ones joins what is
// close in time.
struct ContactEvent {
  enum class Kind { kBegin, kEnd };
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t body = 0;
  std::size_t collider = kNone;  // its number; kNone of two bodies,
  std::size_t other = kNone;     // of which this is the second
  Kind kind = Kind::kBegin;
  ContactPlace place;

  void carry(StateStream& stream) { stream(body, collider, other, kind, place); }
};

// The model of a body of a scene.
using ModelSource = std::function<Result<Model::Pointer>(const SceneBody&)>;

// Model::load; where the file is missing the error names the command that makes it.
Result<Model::Pointer> load_scene_model(const SceneBody& body);

class SceneWorld {
 public:
  // source is asked once for bodies that share file and options. Errors: as check_scene; those of
  // the source, of Body::create, of selectors and of loads, with the body's name in front; kContent
  // for a motion that jumps and does not say how, or that accelerates a point of the body more than
  // it may (looked at in the first 1e6 steps), for a collider's motion that jumps, for a body that
  // begins inside a collider by more than its margin, for a hand whose selector is not one vertex
  // that moves, for a joint likewise; those of load_scene_collider; kSolver where a body that
  // should begin settled finds no shape to stand in.
  static Result<SceneWorld> create(const Scene& scene,
                                   const ModelSource& source = load_scene_model);

  double step_size() const { return scene_.step; }                           // s
  std::int64_t steps() const { return steps_; }                              // done so far
  double time() const { return static_cast<double>(steps_) * scene_.step; }  // s
  const Scene& scene() const { return scene_; }

  // Bodies, in the scene's order.
  std::size_t size() const { return actors_.size(); }
  const ContactBody& body(std::size_t i) const { return actors_[i].body; }
  // To push it; the world steps it.
  ContactBody& body(std::size_t i) { return actors_[i].body; }
  const std::string& name(std::size_t i) const { return scene_.bodies[i].name; }
  std::optional<std::size_t> find(std::string_view name) const;
  // Whether a joint holds the two bodies that do not touch each other.
  bool passes_through(std::size_t a, std::size_t b) const;

  // As Body::set_method: of one body another method, of all another step, s. The world's time goes
  // to the nearest multiple of it.
  Status set_method(std::size_t i, std::string_view integrator);
  Status set_step(double step);

  // As BodyGroup::set_threads: how many threads step the bodies, the caller's included; 0: one a
  // core. No bit depends on it.
  Status set_threads(unsigned threads) { return group_->set_threads(threads); }

  // One step of all bodies that have not failed. The bodies that failed in this step are returned,
  // valid until the next one. Nothing is allocated but for bodies that touch each other.
  struct Failure {
    std::size_t body;
    StepReport report;
  };
  std::span<const Failure> step();
  bool failed(std::size_t i) const { return actors_[i].failed; }
  // At rest and not stepped, until something wakes it.
  bool asleep(std::size_t i) const { return group_->asleep(place_[i]); }

  // Events of the last step, those of colliders first; valid until the next one.
  std::span<const ContactEvent> events() const { return events_; }
  // The points of an event's body and of what it touches that pushed in the last step, with their
  // impulses on the body: empty for a contact that ended.
  std::vector<ContactedPoint> points_of(const ContactEvent& event) const;
  // How often the body began to touch something, and how deep its contact points were behind a
  // surface at most at the end of any step, as a share of the body's size (0: never).
  std::int64_t contacts(std::size_t i) const { return actors_[i].contacts; }
  double penetration_max(std::size_t i) const { return actors_[i].penetration; }
  // How far a contact point of the body began within the margin of a collider, m; 0: none did. Its
  // contact begins where it is (runtime/contact/contact_law.h).
  double begins_within(std::size_t i) const { return actors_[i].begins_within; }
  // The impulse of the body on a collider since the start, N s, world. Both by their numbers.
  Eigen::Vector3d collider_impulse(std::size_t i, std::size_t collider) const {
    const std::size_t at = i * colliders_.placed().size() + collider;
    return at < touching_.size() ? touching_[at].whole : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
  // How fast a point of the body near something went relative to it at most, m/s, and how often one
  // went through it within a step, so that it was not pushed back (runtime/contact/passage.h).
  double contact_speed_max(std::size_t i) const { return actors_[i].speed; }
  std::int64_t passed_through(std::size_t i) const { return actors_[i].passed; }
  // Below this speed, m/s, no point goes through a collider or a body's shape that is a sphere,
  // capsule, box or cylinder; infinite if there is none.
  double contact_speed_limit() const;
  // Where they were in the last step, in the scene's order.
  std::span<const PlacedCollider> colliders() const { return colliders_.placed(); }
  // In the scene's order.
  const MovingHand& hand(std::size_t i) const { return hands_[i].hand; }
  Eigen::Vector3d hand_force(std::size_t i) const {
    return hands_[i].hand.force(actors_[hands_[i].body].body);
  }

  // In the scene's order; null: its time is over.
  const Joint* joint(std::size_t i) const { return joints_[i].joint.find(*group_); }

  // All that the world carries from step to step: the bytes of a file
  // (formats/saved/saved_file.h), or the file, which appears whole or not at all (kSystem). With it
  // put back into a world of the same scene, the steps that follow have the same bits as those of
  // the world that was saved. What is not in the scene is not among it, but for forces of
  // Body::apply_force() and what a body holds by itself: loads in time that were added.
  std::vector<std::byte> save() const;
  Status save(const std::string& path) const;
  // kContent, which names what is wrong and leaves the world as it was, for what is damaged or cut
  // off, of another version, or of a scene with another step, gravity, body, model, collider,
  // hand or joint; kSystem for a file that cannot be read.
  Status restore(std::span<const std::byte> bytes);
  Status restore(const std::string& path);
  // What save() holds without saying whose it is.
  void carry(StateStream& stream);

  // Body::pick of all bodies: what the ray meets first, and of which body. Errors as there.
  struct Hit {
    std::size_t body = 0;
    SurfaceHit hit;
  };
  Result<std::optional<Hit>> pick(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  SurfaceKind surface = SurfaceKind::kDrawn) const;

  // Evaluates the body's energy.
  EnergyAccount account(std::size_t i) const;
  // A body that is not free needs the inertia integrals for them; zeros without.
  Momenta momenta(std::size_t i) const;

 private:
  struct Actor {
    ContactBody body;
    MotionPath path;
    std::shared_ptr<const FrameInertia> inertia;  // about the frame's origin; may be null
    std::size_t piece = 0;
    double energy_at_start = 0.0;
    bool failed = false;
    double size = 0.0;         // m, of the contact points
    double penetration = 0.0;  // share of the size
    double speed = 0.0;        // m/s
    std::int64_t passed = 0;
    std::int64_t contacts = 0;
    double begins_within = 0.0;  // m
    std::optional<BonePaths> bones = {};
  };
  struct Hand {
    MovingHand hand;
    std::size_t body;
  };
  // a, b: the bodies' numbers in the group.
  struct JointOf {
    HeldJoint joint;
    std::size_t a, b;
  };
  // A body and a collider.
  struct Touching {
    bool now = false;
    ContactPlace place;
    Eigen::Vector3d whole = Eigen::Vector3d::Zero();  // on the collider since the start, N s, world

    void carry(StateStream& stream) { stream(now, place, whole); }
  };
  // Two bodies, by their numbers. seen: in the last step.
  struct Pair {
    std::size_t a = 0, b = 0;
    ContactPlace place;
    bool seen = false;

    void carry(StateStream& stream) { stream(a, b, place, seen); }
  };

  explicit SceneWorld(const Scene& scene) : scene_(scene) {}
  Status add(const SceneBody& wanted, Model::Pointer model);
  Status begin(const SceneBody& wanted, Actor& actor) const;
  Status begin_contact(std::size_t i, const ContactNeeds& needs);
  Status add_hands();
  Status add_joints();
  Status damp(std::size_t i);
  void list_passing();
  std::span<const PlacedCollider> felt_by(std::size_t i) const;
  Result<ContactOptions> contact_of(const SceneBody& wanted);
  void move_frame(Actor& actor) const;
  void move_bones(Actor& actor) const;
  void move_hands();
  Status check_apart() const;
  void note_contact(std::size_t i);
  void note_pairs();
  template <class Visit>
  void for_points_of(std::size_t a, std::size_t b, Visit&& visit) const;
  SavedState saved_parts() const;
  SavedState saved_state() const;
  Status restore_from(const Result<SavedState>& saved, const std::string& name);
  void carry_contacts(StateStream& stream);

  Scene scene_;
  std::vector<Actor> actors_;
  SceneColliders colliders_;
  std::vector<Hand> hands_;
  std::vector<JointOf> joints_;
  std::vector<Touching> touching_;  // bodies x colliders
  std::vector<Failure> failures_;
  std::vector<ContactEvent> events_;
  std::vector<Pair> pairs_;  // those that touch
  std::unique_ptr<BodyGroup> group_;
  std::vector<std::size_t> order_, place_;  // bodies by their names, and where each is there
  std::vector<ContactBody*> stepped_;       // by their names; null: it has failed
  std::vector<StepReport> reports_;
  std::map<std::string, Collider> shapes_;                 // of bodies, by their files
  std::unordered_map<std::string, std::size_t> numbers_;   // of bodies, by their names
  std::set<std::pair<std::size_t, std::size_t>> passing_;  // a < b: a joint lets them pass through
  bool gravity_changes_ = false;
  std::int64_t steps_ = 0;
};

}  // namespace tremolo
