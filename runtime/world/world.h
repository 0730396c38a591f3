// A world: bodies of every kind, colliders and joints, which may come and go between its steps.
//
// A SceneWorld steps the reduced and rigid bodies, and with them its guests, bodies of tetrahedra
// and cloths. This is both as one list of bodies, for programs that change the scene while it runs.
// A world that nothing changes has the same bits as one of a scene file with the same values.
//
// A body is known by a WorldBody. The slot of a body that was removed is used again, with another
// generation, so that an old WorldBody is an error (kUsage) and never another body.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/mixed/mixed_guests.h"
#include "runtime/world/guest_bound.h"
#include "runtime/world/scene_world.h"
#include "runtime/world/watched_jobs.h"
#include "runtime/world/world_guests.h"

namespace tremolo {

// The bodies that a world begins with. path: of the scene's file, for errors; empty: none. source:
// of the models of scene.bodies.
struct WorldScene {
  std::string path;
  Scene scene;
  std::vector<TetSceneBody> tets;
  std::vector<ClothSceneBody> cloths;
  ModelSource source = load_scene_model;
};

struct WorldBody {
  std::uint32_t slot = 0, generation = 0;

  bool operator==(const WorldBody&) const = default;
};

enum class WorldBodyKind { kReduced, kRigid, kTets, kCloth };

// A material point of a body's drawn surface: the weights of the three corners of a triangle.
struct WorldSite {
  WorldBody body;
  std::size_t triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::UnitX();
};

// The first hit of a ray.
struct WorldHit {
  WorldSite site;
  double distance = 0.0;                            // from the ray's origin, m
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // m, world
  // Of the mesh of a body with a basis, as SurfaceHit::vertex; -1: a body of another kind.
  VertexId vertex = -1;
};

// The begin or the end of a contact of a body with another one or with a collider.
struct WorldEvent {
  ContactEvent::Kind kind = ContactEvent::Kind::kBegin;
  double time = 0.0;  // at the end of the step, s
  WorldBody body;
  std::optional<WorldBody> other;  // empty: a collider
  std::size_t collider = ContactEvent::kNone;
  // On `body`, since the contact began; of a guest, since the last restore() at most.
  ContactPlace place;
};

// The energy balance of a body of any kind, J: EnergyAccount, in which causes that a body of its
// kind does not have are 0, and:
struct WorldAccount {
  EnergyAccount sums;
  double wind = 0.0;       // given since the start
  double method = 0.0;     // the same, by the method, and by the damping of tetrahedra
  double remainder = 0.0;  // without a known cause; 0 for tetrahedra, whose method has it
};

// Contact of a body.
struct WorldContact {
  std::int64_t contacts = 0;                        // that began
  double penetration = 0.0;                         // the largest at the end of any step, m
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // mean on the body in the last step, N, world
  int points = 0;                                   // with a force in it
};

class World {
 public:
  // threads: of a step, the caller's included; 0: one for each core; no bit depends on it. Errors
  // of SceneWorld::create() and add_guests(); kContent: two bodies have one name.
  static Result<std::unique_ptr<World>> create(const WorldScene& scene, unsigned threads = 1);

  double step_size() const { return own_.step_size(); }  // s
  std::int64_t steps() const { return own_.steps(); }    // done so far
  double time() const { return own_.time(); }            // s
  // The reduced and rigid bodies, and the guests; null: there are none. For reading.
  const SceneWorld& own() const { return own_; }
  SceneWorld& own() { return own_; }
  const MixedGuests* guests() const { return guests_of(own_); }

  // Advances by `count` steps, or until bodies fail. done: receives the number of steps taken, that
  // in which bodies failed included. Error kSolver or kBound: it names the bodies that failed. They
  // keep their state and are not stepped again; the others have taken their step and continue in
  // the next call. kUsage: a filter threw an exception, or threads of set_jobs() broke a rule; the
  // step is complete.
  Status step(std::int64_t count = 1, std::int64_t* done = nullptr);
  bool is_stepping() const { return stepping_; }  // a callback must not call the world then

  // ---- what comes and goes ----

  // Add a body, as SceneWorld::add_body() and add_guest(). The step of a guest, and the gravity of
  // tetrahedra, are the world's.
  Result<WorldBody> add(const SceneBody& body, const ModelSource& source = load_scene_model);
  Result<WorldBody> add(TetSceneBody body);
  Result<WorldBody> add(const ClothSceneBody& body);
  // Removes a body with its hands and joints. Its contacts end without an event.
  Status remove(WorldBody body);
  // Colliders and joints, as those of SceneWorld; a collider must not begin around a guest either.
  Result<std::size_t> add_collider(const SceneCollider& collider);
  Status move_collider(std::size_t collider, const Pose& next);
  Status remove_collider(std::size_t collider);
  Result<std::size_t> add_joint(const SceneJoint& joint) { return own_.add_joint(joint); }
  Status remove_joint(std::size_t joint);
  // Null: it does not exist or is over. Valid until the next call.
  const Joint* joint(std::size_t joint) const;
  // The number of the collider of that name.
  std::optional<std::size_t> find_collider(const std::string& name) const;

  // ---- bodies: kUsage for a body that is not there ----

  std::vector<WorldBody> bodies() const;  // in the order of their slots
  std::size_t size() const;               // their number
  std::optional<WorldBody> find(const std::string& name) const;
  Status check(WorldBody body) const;

  // The following take a body that is there.
  const std::string& name(WorldBody body) const;
  WorldBodyKind kind(WorldBody body) const;
  bool asleep(WorldBody body) const;
  bool failed(WorldBody body) const;
  // The caller's: null at first.
  void* user_data(WorldBody body) const { return slots_[body.slot].user; }
  void set_user_data(WorldBody body, void* user) { slots_[body.slot].user = user; }
  // The body of a number in own() or among the guests.
  WorldBody of_own(std::size_t i) const { return body_of(i); }
  WorldBody of_guest(std::size_t i) const { return body_of(kFirstGuest + i); }
  const TetsKind& tets_kind(WorldBody body) const { return *guest(body).kind; }  // of tetrahedra
  // A guest gets energy that the world does not see, by states that the caller sets: its energy is
  // not bounded any more.
  void expect_energy(std::size_t guest) { guests_[guest].driven = true; }

  // The drawn surface: s vertices.
  std::size_t vertices(WorldBody body) const;
  std::span<const Triangle> triangles(WorldBody body) const;
  // x y z of each vertex, 3 s: positions, m; velocities, m/s. Errors of Body::surface() and
  // surface_velocities().
  Status positions(WorldBody body, std::span<float> out) const;
  Status positions(WorldBody body, std::span<double> out) const;
  Status velocities(WorldBody body, std::span<double> out) const;

  WorldAccount account(WorldBody body) const;
  Momenta momenta(WorldBody body) const;
  WorldContact contact(WorldBody body) const;

  // A reduced or rigid body; null: another kind.
  const ContactBody* reduced(WorldBody body) const;
  Status move(WorldBody body, const Pose& next);  // as SceneWorld::move_body(); kUsage: a guest
  // A force that is constant over the next `steps` steps, and one in time, which begins at the
  // body's time. Errors of Body::apply_force() and Body::add_load(); for guests those of
  // MixedGuests::apply_force() and add_guest_loads(); kUsage: a force that is not finite, or so
  // large that numbers overflow.
  Status apply_force(WorldBody body, VertexId vertex, const Eigen::Vector3d& force, int steps);
  Status add_load(WorldBody body, const SceneLoad& load);

  // Hands, as ContactBody::grab() and MixedGuests::hold(). vertex: of tetrahedra one of the mesh on
  // its surface, of a cloth one of its file or grid. Returns the hand's number on the body. A body
  // needs no contact for it, but a method that supports contact.
  Result<std::size_t> grab(WorldBody body, VertexId vertex, double stiffness, double damping);
  // The same at a point of the surface; a guest is held at the corner with the largest weight.
  Result<std::size_t> grab(const WorldSite& site, double stiffness, double damping);
  Status move_hand(WorldBody body, std::size_t hand, const Eigen::Vector3d& place);
  Result<Eigen::Vector3d> hand_force(WorldBody body, std::size_t hand) const;  // on the body, N
  // The spring and damper in use, which may be weaker than those asked for; kUsage: no such hand.
  Result<HandSpring> hand_spring(WorldBody body, std::size_t hand) const;
  Status let_go(WorldBody body, std::size_t hand);

  // ---- contact ----

  // Events of all steps of the last call of step(), in the order of time.
  std::span<const WorldEvent> events() const { return events_; }
  // The points of a pair with a force in the last step, with normals out of the other one and
  // impulses on the body, also points of the other one. other: empty: the collider.
  std::vector<ContactedPoint> points(WorldBody body, std::optional<WorldBody> other,
                                     std::size_t collider = ContactEvent::kNone) const;
  // The first hit of a ray on the drawn surface of a body. kUsage: it is not finite, or the
  // direction is zero.
  Result<std::optional<WorldHit>> pick(const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) const;
  // A site now: its position, m, and its velocity, m/s, either of which may be null. Both evaluate
  // the whole surface. kUsage: no such triangle. Errors of velocities().
  Status where(const WorldSite& site, Eigen::Vector3d* position, Eigen::Vector3d* velocity) const;

  // Bodies for which it returns false pass through each other. It is called once for each pair that
  // comes near in a step, by the thread that calls step(), and must not call the world. Empty:
  // none.
  using Filter = std::function<bool(WorldBody, WorldBody)>;
  void set_filter(Filter filter);
  Status set_threads(unsigned threads) { return own_.set_threads(threads); }
  // As BodyGroup::set_jobs(); what breaks its rules is an error of step().
  void set_jobs(std::optional<BodyGroup::Jobs> jobs);

  // As SceneWorld::save() and restore(). A state of a world that was changed fits one of the same
  // scene that was changed in the same way: between begin_replay() and end_replay() the changes are
  // made again, with replay_step() where steps were taken between two of them, and then the state
  // is restored. What is added meanwhile may be inside others, which are not where they were; a
  // joint gets the points that are there, so it needs the state before it was added.
  void begin_replay() { own_.set_replaying(true); }
  void replay_step();
  void end_replay() { own_.set_replaying(false); }
  std::vector<std::byte> save() const { return own_.save(); }
  Status restore(std::span<const std::byte> bytes);

 private:
  // generation: 0 is none. index: in own_ or among the guests.
  struct Slot {
    bool used = false, guest = false;
    std::uint32_t generation = 0;
    std::size_t index = 0;
    void* user = nullptr;
  };
  struct Guest {
    std::optional<TetsKind> kind{};  // of tetrahedra
    std::size_t slot = 0;
    GuestEnergy at_start{};
    GuestBound bound{};
    bool driven = false;                    // wind or pins put in energy that the bound misses
    bool over = false;                      // it has failed, which was reported
    std::vector<Eigen::Index> particles{};  // of each drawn vertex of a cloth
  };
  // Contact of a guest. Numbers are those of contact: bodies of own_, guests from kFirstGuest on,
  // colliders from kFirstCollider on; first < second.
  struct Touch {
    std::size_t first = 0, second = 0;
    ContactPlace place;
    bool seen = false;
  };

  explicit World(SceneWorld own, const WorldScene& scene);
  WorldBody take_slot(bool guest, std::size_t index);
  WorldBody begin_guest(std::size_t guest, std::optional<TetsKind> kind);
  WorldBody body_of(std::size_t number) const;
  std::size_t number_of(WorldBody body) const;
  bool is_guest(WorldBody body) const { return slots_[body.slot].guest; }
  std::size_t index(WorldBody body) const { return slots_[body.slot].index; }
  const Guest& guest(WorldBody body) const { return guests_[index(body)]; }
  MixedGuests& all_guests() const { return *guests_of(own_); }
  const ClothBody* cloth(WorldBody body) const;
  const TetStep* tets(WorldBody body) const;
  Status need_own(WorldBody body, const char* what) const;
  Status check_hand(WorldBody body, std::size_t hand) const;
  Status check_force(WorldBody body, const Eigen::Vector3d& force) const;
  Status check_spring(WorldBody body, double stiffness, double damping) const;
  Status check_collider(std::size_t collider) const;
  template <class Real>
  void place_guest(WorldBody body, bool velocities, Real* out) const;
  void account_of_cloth(WorldBody body, WorldAccount& account) const;

  bool look_at(std::size_t guest);
  Status take_step();
  void note_events();
  void note_guests();
  void meet(std::size_t first, std::size_t second);
  template <class Visit>
  void for_points_of(std::size_t first, std::size_t second, const Visit& visit) const;
  void pass_filter();

  SceneWorld own_;
  std::string path_;
  std::vector<Slot> slots_;
  std::vector<std::size_t> free_;
  std::vector<std::size_t> own_slots_;  // of each body of own_
  std::deque<Guest> guests_;            // they do not move when one is added
  std::vector<Touch> touches_;
  std::vector<WorldEvent> events_;
  Filter filter_;
  std::exception_ptr thrown_;          // by the filter
  std::unique_ptr<WatchedJobs> jobs_;  // null: the world's own threads
  bool stepping_ = false;
  // Buffers of a call.
  mutable std::vector<Eigen::Vector3d> vertices_;
  mutable std::vector<Eigen::Vector3f> normals_;
};

}  // namespace tremolo
