// The bodies of a scene, stepped together.
//
// Each step takes every body from t to t + h. The motion of a driven body's frame in the step
// follows from its poses at t - h, t, t + h and t + 2h; gravity is that of the middle of the step.
// Colliders move from pose to pose of their motion; every body can be in contact with all of them,
// and with the other bodies that have a shape (runtime/contact/islands/body_group.h). The result
// for a body depends only on the scene's entries for it, for bodies and colliders in contact with
// it, and for its hands, bit for bit: not on the order of the entries (bodies are sorted by name).
//
// A body whose step fails keeps its state and is not stepped again; the other bodies continue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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
#include "runtime/contact/contact_law.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact_body.h"
#include "runtime/math/motion.h"
#include "runtime/math/state.h"
#include "runtime/model.h"
#include "runtime/scene/joint_loads.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_bones.h"
#include "runtime/scene/scene_colliders.h"
#include "runtime/scene/scene_links.h"

namespace tremolo {

// Energy balance of a body: what it has now and what each cause has given. All in J. The fields
// from `load` on are energy given since the start; a negative value was taken.
struct EnergyAccount {
  // Now; of a free body with its motion as a whole, of a driven one relative to its frame.
  double kinetic = 0.0;
  double potential = 0.0;  // now
  double contact = 0.0;    // now, stored between the body and colliders
  double at_start = 0.0;   // kinetic + potential + contact at the start
  double load = 0.0;       // by forces on vertices
  double support = 0.0;    // by accelerations of the frame
  double gravity = 0.0;
  double contact_given =
      0.0;                   // by moving colliders, and by a driven body's frame moving along them
  double restitution = 0.0;  // never positive
  double friction = 0.0;     // never positive
  double hand = 0.0;         // by hands that hold the body
  double joint = 0.0;        // by joints that hold the body
  double damping = 0.0;      // never positive
  // Contact energy that a step found although the step before had left none. It should be zero, and
  // is part of remainder().
  double contact_error = 0.0;

  double total() const { return kinetic + potential + contact; }
  double given() const {
    return load + support + gravity + contact_given + restitution + friction + hand + joint +
           damping;
  }
  // The error of the balance: energy without a known cause.
  double remainder() const { return total() - at_start - given(); }
};

// The identity of a scene in a saved world: each part with a hash of its contents. Parts: the step
// and gravity, then bodies with their models, colliders with their shapes, hands; but not the
// duration and the outputs. models, colliders: in the scene's order. shapes: of the bodies, null if
// there is none.
std::vector<SavedPart> scene_parts(const Scene& scene, const std::vector<const Model*>& models,
                                   const std::vector<const Collider*>& shapes,
                                   std::span<const PlacedCollider> colliders);

// Mean position of the last contact of a body with something, and its impulse since the contact
// began.
struct ContactPlace {
  double impulse = 0.0;                            // sum of |F| h, N s
  Eigen::Vector3d push = Eigen::Vector3d::Zero();  // sum of F h on the body, N s, world
  Eigen::Vector3d position = push;  // mean of the contact points, weighted by impulse, m, world
  // The mean normal with the same weights, out of the other thing, of unit length; zero if the
  // normals cancel.
  Eigen::Vector3d normal = push;

  void carry(StateStream& stream) { stream(impulse, push, position, normal); }
};

// The begin or end of a contact of a body with a collider or another body in the last step. A
// contact ends when its points separate for a single step: to get longer ones, join events that are
// close in time.
struct ContactEvent {
  enum class Kind { kBegin, kEnd };
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t body = 0;
  std::size_t collider = kNone;  // its index; kNone for a contact of two bodies
  std::size_t other = kNone;     // index of the second body; kNone for a collider
  Kind kind = Kind::kBegin;
  ContactPlace place;

  void carry(StateStream& stream) { stream(body, collider, other, kind, place); }
};

// Supplies the model of a body of a scene.
using ModelSource = std::function<Result<Model::Pointer>(const SceneBody&)>;

// Model::load; if the file is missing the error gives the command that makes it.
Result<Model::Pointer> load_scene_model(const SceneBody& body);

class SceneWorld {
 public:
  // source is called once for bodies that share file and options. Errors: as for check_scene; those
  // of the source, of Body::create, of selectors and of loads, with the body's name in front; those
  // of load_scene_collider; kContent for a frame's motion that jumps (JumpRule::kRefuse) or
  // accelerates a point of the body beyond its limit (checked for the first 1e6 steps), for a
  // collider's motion that jumps, for a body that begins inside a collider by more than its margin,
  // for a hand or a joint whose selector is not one vertex that moves; kSolver for a `settled` body
  // without an equilibrium. guests: bodies of other kinds will follow (set_guests()).
  static Result<SceneWorld> create(const Scene& scene, const ModelSource& source = load_scene_model,
                                   bool guests = false);

  // Adds bodies of other kinds to the world, which steps them with its bodies
  // (runtime/world/world_guests.h). Call it before the first step. links: of hands and joints on
  // them. identity: of the guests, for saved states.
  void set_guests(std::unique_ptr<IslandGuests> guests, std::unique_ptr<GuestLinks> links,
                  std::vector<SavedPart> identity) {
    guests_ = std::move(guests);
    links_ = std::move(links);
    guest_identity_ = std::move(identity);
    group_->set_guests(guests_.get());
  }

  double step_size() const { return scene_.step; }                           // s
  std::int64_t steps() const { return steps_; }                              // done so far
  double time() const { return static_cast<double>(steps_) * scene_.step; }  // s
  const Scene& scene() const { return scene_; }

  // Bodies, in the scene's order.
  std::size_t size() const { return actors_.size(); }
  const ContactBody& body(std::size_t i) const { return actors_[i].body; }
  // For applying forces; the world steps the body.
  ContactBody& body(std::size_t i) { return actors_[i].body; }
  const std::string& name(std::size_t i) const { return scene_.bodies[i].name; }
  std::optional<std::size_t> find(std::string_view name) const;
  // The number of body i in the group that steps it, and the body of a number there.
  std::size_t group_number(std::size_t i) const { return place_[i]; }
  std::size_t body_of_number(std::size_t number) const { return order_[number]; }
  // Of the i-th joint, one to the world: the body that stands for it, and its number in the group.
  const ContactBody& anchor(std::size_t i) const { return anchors_[*anchor_of_[i]]; }
  std::size_t anchor_number(std::size_t i) const { return anchor_numbers_[*anchor_of_[i]]; }
  // True if a joint between the two bodies switches their contact off.
  bool passes_through(std::size_t a, std::size_t b) const;

  // Adds a load to a body as if the scene had it. forces: those of the load, N, known already.
  // Errors of Body::add_load.
  Status add_load(std::size_t i, const SceneLoad& load, const DefaultLoad& forces);
  // The same with the forces that the load names. Errors also of selectors.
  Status add_load(std::size_t i, const SceneLoad& load);
  // Sets the state in which a body starts, before the first step. Errors of Body::set_state.
  Status start_at(std::size_t i, const State& state);

  // Changes of the scene between two steps (scene_changes.cpp). A state of a world that was changed
  // fits a world that was changed in the same way. A change that is refused leaves the world as it
  // was.
  //
  // Adds a body: its number is that of a body that was removed before the last step, or the next.
  // Sums take bodies that were added in the order of their numbers, after those of create().
  // Loads begin when it is added. Errors as for create(); kUsage after the first step: a body with
  // a motion, which move_body() replaces.
  Result<std::size_t> add_body(const SceneBody& wanted,
                               const ModelSource& source = load_scene_model);
  // Removes a body with its joints: nothing meets it, failed() is true. What it touched wakes; its
  // contacts end without an event. Its name is free.
  void remove_body(std::size_t i);
  bool removed(std::size_t i) const { return actors_[i].removed; }
  // The frame of a driven body goes to that pose in the next step and rests there until the next
  // call; its motion has ended. Errors as for Body::move_to().
  Status move_body(std::size_t i, const Pose& next);
  // Adds a collider at its pose and returns its number, the next. Errors of create(), also for a
  // body of the world that is inside it; kUsage as for add_body().
  Result<std::size_t> add_collider(const SceneCollider& wanted);
  // The same for a collider; its friction moves what lies on it. Error kUsage: a pose that is not
  // finite or whose rotation does not have length one to 1e-6.
  Status move_collider(std::size_t c, const Pose& next);
  // Removes it: it is 1e9 m away, and its number is not used again. Bodies wake.
  void remove_collider(std::size_t c);
  bool collider_removed(std::size_t c) const { return gone_colliders_.contains(c); }
  // Joins bodies of any kind of the world from now on, and returns the joint's number. Errors as
  // for create().
  Result<std::size_t> add_joint(const SceneJoint& wanted);
  void remove_joint(std::size_t i);
  // Pairs of bodies for which it returns false pass through each other. Bodies are those of the
  // world; guests have numbers from kFirstGuest on. It must not call the world, which must not be
  // moved afterwards. Empty: none do.
  void set_filter(PairFilter filter);
  // While it is on, nothing that is added is checked to be apart from the others: the changes of a
  // saved world are made again, whose bodies get their positions by restore() afterwards.
  void set_replaying(bool replaying) { replaying_ = replaying; }
  bool replaying() const { return replaying_; }
  // Between two of these changes the saved world took steps.
  void replay_step();
  // As BodyGroup::set_jobs().
  void set_jobs(std::optional<BodyGroup::Jobs> jobs) { group_->set_jobs(std::move(jobs)); }
  // Prepares all bodies that can be in contact for guests. Errors as for create().
  Status expect_guests();
  // Holds a body by a hand, also one without contact, which gets it: hold(ContactBody) ->
  // Result<std::size_t>, the hand's number. A saved state tells which bodies have contact for such
  // hands alone; restore() gives it to these, and to no others. Errors of `hold`; kUsage: those of
  // ContactBody::set_contact().
  template <class Hold>
  Result<std::size_t> hold_body(std::size_t i, const Hold& hold) {
    const BeforeChange before = before_change();
    if (Status s = expect_hand(i); !s) return s.error();
    Result<std::size_t> hand = hold(actors_[i].body);
    if (!hand) take_back(before);
    return hand;
  }
  // The parts of the world that a change may add to, as they are before it.
  struct BeforeChange {
    std::vector<char> contact;  // the body has contact
    std::size_t touching = 0, anchors = 0;
    bool guests = false;
  };
  BeforeChange before_change() const;
  // Removes the contact of bodies, the anchors and the guests that the change has added.
  void take_back(const BeforeChange& before);
  // True if a body of any kind has the name.
  bool has_name(const std::string& name) const {
    return find(name).has_value() || scene_.guests.contains(name);
  }
  IslandGuests* guests() const { return guests_.get(); }  // null: there are none
  // A guest was added, or is removed: its name is in use, or free, and its hands and joints end.
  void note_guest(const std::string& name, SavedPart identity) {
    scene_.guests.insert(name);
    guest_identity_.push_back(std::move(identity));
  }
  void forget_guest(std::size_t guest, const std::string& name);
  // The guest of that name got a load.
  void note_guest_load(const std::string& name, const SceneLoad& load);

  // As Body::set_method: sets another method of one body, or another step, s, of all. The world's
  // time is rounded to the nearest multiple of the step. Error kUsage: another step with guests.
  Status set_method(std::size_t i, std::string_view integrator);
  Status set_step(double step);

  // As BodyGroup::set_threads: sets the number of threads that step the bodies, the caller's
  // included; 0: one per core. The results do not depend on it.
  Status set_threads(unsigned threads) { return group_->set_threads(threads); }

  // Steps all bodies that have not failed. Returns the bodies that failed in this step, valid until
  // the next one. Allocates only for bodies in contact with each other.
  struct Failure {
    std::size_t body;
    StepReport report;
  };
  std::span<const Failure> step();
  bool failed(std::size_t i) const { return actors_[i].failed; }
  // True if the body is at rest and not stepped until something wakes it.
  bool asleep(std::size_t i) const { return group_->asleep(place_[i]); }

  // Events of the last step, those of colliders first; valid until the next one.
  std::span<const ContactEvent> events() const { return events_; }
  // The points in contact in the last step for an event's pair, with their impulses on the body;
  // empty for a contact that ended.
  std::vector<ContactedPoint> points_of(const ContactEvent& event) const;
  // Two bodies without a shape that met, by index: BodyGroup::passing().
  std::optional<std::pair<std::size_t, std::size_t>> passing() const {
    if (!group_->passing()) return std::nullopt;
    return std::pair(order_[group_->passing()->first], order_[group_->passing()->second]);
  }
  // The number of contacts that began, and the largest penetration of the body's contact points at
  // the end of any step, relative to the body's size (0: none).
  std::int64_t contacts(std::size_t i) const { return actors_[i].contacts; }
  double penetration_max(std::size_t i) const { return actors_[i].penetration; }
  // The largest distance of a contact point within the margin of a collider when it started, m; 0:
  // none was. Its contact begins at that distance (runtime/contact/contact_law.h).
  double begins_within(std::size_t i) const { return actors_[i].begins_within; }
  // The impulse of body i on a collider since the start, N s, world.
  Eigen::Vector3d collider_impulse(std::size_t i, std::size_t collider) const {
    const std::size_t at = i * colliders_.placed().size() + collider;
    return at < touching_.size() ? touching_[at].whole : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
  // The largest speed of a point of the body relative to something near it, m/s, and the number of
  // times that a point passed through something within a step, so that it was not pushed back
  // (runtime/contact/collider.h).
  double contact_speed_max(std::size_t i) const { return actors_[i].speed; }
  std::int64_t passed_through(std::size_t i) const { return actors_[i].passed; }
  // Below this speed, m/s, no point passes through a collider, or a body's shape, that is a sphere,
  // capsule, box or cylinder; infinite if there is none.
  double contact_speed_limit() const;
  // The colliders with their poses in the last step, in the scene's order.
  std::span<const PlacedCollider> colliders() const { return colliders_.placed(); }
  // In the scene's order, those on bodies of other kinds included once the world has its guests.
  const HandCourse& hand(std::size_t i) const {
    return own_hands_[i] ? hands_[*own_hands_[i]].hand : *links_->hand(i);
  }
  Eigen::Vector3d hand_force(std::size_t i) const {
    if (!own_hands_[i]) return links_->hand_force(i);
    const Hand& own = hands_[*own_hands_[i]];
    if (own.over) return Eigen::Vector3d::Zero();
    return own.hand.force(actors_[own.body].body);
  }

  // Of a hand on a body of another kind, m, world: the position of the vertex that it holds or will
  // hold; empty: it is on a body of the world.
  std::optional<Eigen::Vector3d> guest_vertex(std::size_t i) const {
    if (own_hands_[i]) return std::nullopt;
    return links_->hand_vertex(i);
  }

  // In the scene's order; null: its time is over. Of a weld the sums of its joints, without their
  // positions, valid until the next call for it.
  const Joint* joint(std::size_t i) const {
    return own_joints_[i] ? joints_[*own_joints_[i]].joint.find(*group_) : links_->joint(i);
  }
  // The number of its joints between points, which joint() sums up: above 1 for a weld.
  std::size_t joint_points(std::size_t i) const {
    return own_joints_[i] ? joints_[*own_joints_[i]].joint.points() : links_->joint_points(i);
  }

  // Saves the state between steps, as the bytes of a file (formats/saved/saved_file.h) or as a
  // file, which is written whole or not at all (kSystem). A world of the same scene that is
  // restored from it continues with the same bits as the saved one. Changes outside the scene are
  // not saved, except forces of Body::apply_force() and loads added to a body.
  std::vector<std::byte> save() const;
  Status save(const std::string& path) const;
  // Errors, which leave the world unchanged: kContent with the reason for data that are damaged,
  // cut off or of another version, or of a scene with another step, gravity, body, model, collider,
  // hand or joint; kSystem for a file that cannot be read.
  Status restore(std::span<const std::byte> bytes);
  Status restore(const std::string& path);
  // Saves or restores the state only, without the identity of the scene.
  void carry(StateStream& stream);

  // Body::pick over all bodies: the first hit of the ray, and its body. Errors as there.
  struct Hit {
    std::size_t body = 0;
    SurfaceHit hit;
  };
  Result<std::optional<Hit>> pick(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  SurfaceKind surface = SurfaceKind::kDrawn) const;

  // Evaluates the body's energy.
  EnergyAccount account(std::size_t i) const;
  // The momenta of a body that is not free need its inertia integrals; zeros without them.
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
    double begins_within = 0.0;         // m
    bool removed = false, old = false;  // old: before the last step
    std::optional<Pose> given = {};     // by move_body(); empty: the path moves it
    std::optional<BonePaths> bones = {};
  };
  // wanted: its number in the scene.
  struct Hand {
    MovingHand hand;
    std::size_t body, wanted;
    bool over = false;  // its body was removed
  };
  // a, b: the bodies' numbers in the group.
  struct JointOf {
    HeldJoint joint;
    std::size_t a, b, wanted;
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
  Result<Actor> make(const SceneBody& wanted, Model::Pointer model) const;
  Status begin(const SceneBody& wanted, Actor& actor) const;
  Status begin_contact(std::size_t i, bool needed);
  Status add_hands();
  Status add_anchors();
  Status add_anchor();
  Status add_joints();
  JointLoads joint_loads() const;
  // load: kg, see JointOptions.
  Status begin_joint(std::size_t i, double load, std::size_t a, const ContactBody& other,
                     std::size_t there);
  Result<Model::Pointer> model_of(const SceneBody& wanted, const ModelSource& source) const;
  std::size_t new_number(std::size_t body);
  void drop_number();
  Status expect_hand(std::size_t i);
  Status begin_added(std::size_t i);
  bool has_contact_for_hands(std::size_t i, const ContactNeeds& needs) const;
  Status check_apart_from_all(std::size_t i) const;
  void wake_all();
  Status damp(std::size_t i);
  void list_passing();
  std::span<const PlacedCollider> felt_by(std::size_t i) const;
  Result<ContactOptions> contact_of(const SceneBody& wanted);
  void move_frame(Actor& actor) const;
  void move_bones(Actor& actor) const;
  void move_hands();
  Status check_apart() const;
  void note_contact(std::size_t i);
  void press_on(std::size_t i);
  void note_pairs();
  template <class Visit>
  void for_points_of(std::size_t a, std::size_t b, Visit&& visit) const;
  SavedState saved_parts() const;
  SavedState saved_state() const;
  Status restore_from(const Result<SavedState>& saved, const std::string& name);
  struct HandContact {
    std::size_t body;
    std::shared_ptr<ContactStep> before;
  };
  Status match_hands(const SavedState& saved, std::vector<HandContact>& changed);
  void carry_contacts(StateStream& stream);

  Scene scene_;
  std::deque<Actor> actors_;  // they do not move when one is added
  SceneColliders colliders_;
  std::vector<Hand> hands_;
  std::vector<JointOf> joints_;
  // One for each joint to the world, so that it joins no islands; they follow the bodies in the
  // group. anchor_of_: for each joint of the scene; empty: it is not one to the world.
  std::vector<ContactBody> anchors_;
  std::vector<std::optional<std::size_t>> anchor_of_;
  std::vector<std::size_t> anchor_numbers_;  // of each in the group
  // For each of the scene its index in hands_ or joints_; empty: it is in links_.
  std::vector<std::optional<std::size_t>> own_hands_, own_joints_;
  std::vector<Touching> touching_;  // bodies x colliders
  std::vector<Failure> failures_;
  std::vector<ContactEvent> events_;
  std::vector<Pair> pairs_;  // those that touch
  std::unique_ptr<BodyGroup> group_;
  // The number of each body in the group: by their names, then those that were added later. order_:
  // the body of each number; kNobody: an anchor's.
  static constexpr std::size_t kNobody = static_cast<std::size_t>(-1);
  std::vector<std::size_t> order_, place_;
  std::vector<ContactBody*> stepped_;  // by their numbers; null: it has failed
  std::vector<StepReport> reports_;
  std::map<std::string, Collider> shapes_;                 // of bodies, by their files
  std::unordered_map<std::string, std::size_t> numbers_;   // of bodies, by their names
  std::set<std::pair<std::size_t, std::size_t>> passing_;  // a < b: a joint lets them pass through
  std::set<std::size_t> gone_colliders_;                   // those that were removed
  bool gravity_changes_ = false, replaying_ = false;
  std::int64_t steps_ = 0;
  std::unique_ptr<IslandGuests> guests_;   // null: none
  std::unique_ptr<GuestLinks> links_;      // null: there are no guests
  std::vector<SavedPart> guest_identity_;  // of saved states
};

}  // namespace tremolo
