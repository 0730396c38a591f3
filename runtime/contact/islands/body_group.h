// Bodies that may touch each other, stepped together (docs/theory.md, section "Contact").
//
// Bodies whose balls come near are checked point by point. Bodies that may be in contact form an
// island, which is solved at once (contact_island.h). The others step by themselves, same as
// ContactBody::step(), with the same bits.
//
// A free body that has been at rest (rest_time.h) falls asleep with all bodies in contact with
// it: it then costs nothing. It wakes when something that is awake comes near, a load or a grab
// begins, gravity changes, a collider moves next to it, or its owner moves it. The motion that it
// loses is added to the energy taken by contact.
//
// Threads divide islands, and bodies without an island, among themselves. One thread steps each,
// from its own bodies alone, so that no bit depends on the number of threads.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/contact/islands/contact_island.h"
#include "runtime/contact/islands/island_guests.h"
#include "runtime/contact/islands/step_parts.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/rest_time.h"
#include "runtime/contact_body.h"
#include "runtime/math/thread_pool.h"

namespace tremolo {

class BodyGroup {
 public:
  struct Options {
    bool sleep = true;
  };

  BodyGroup() = default;
  explicit BodyGroup(const Options& options) : options_(options) {}

  // Sets the number of threads in step(), the caller's included; 0: one for each core. Default: 1.
  // Error kSystem, with nothing changed: the threads cannot be started.
  Status set_threads(unsigned threads);
  unsigned threads() const { return jobs_ ? jobs_->workers : pool_ ? pool_->threads() : 1; }
  // Threads of the caller's, in place of the group's. run: calls job(data, index, worker) once for
  // each index below count, on any threads, and returns when all are done; worker < workers is one
  // of its own for each call at a time. It must not throw.
  struct Jobs {
    unsigned workers = 1;
    std::function<void(std::size_t count, void (*job)(void*, std::size_t, unsigned), void* data)>
        run;
  };
  // Empty: the group's own threads again.
  void set_jobs(std::optional<Jobs> jobs) { jobs_ = std::move(jobs); }
  // Pairs of bodies for which it returns false pass through each other. Called by the thread that
  // calls step(). Empty: none do.
  void set_filter(PairFilter filter) { filter_ = std::move(filter); }
  // The next step has that many bodies, at least as many as the last one.
  void make_room(std::size_t bodies) {
    if (!rest_.empty()) rest_.resize(bodies);
  }
  // Sets the bodies of other kinds that are stepped with the group's; null: none. They must outlive
  // the group.
  void set_guests(IslandGuests* guests) { guests_ = guests; }

  // One step of all bodies, which have one step size; null entries are skipped. Body i must be the
  // same in each call. The order of the bodies decides the order of sums: choose an order that does
  // not depend on how they were added. reports: one for each body; a body that sleeps is converged
  // without iterations. If an island is not solved, none of its bodies moves and each reports it.
  // Errors of a body's own step: same as ContactBody::step().
  void step(std::span<ContactBody* const> bodies, std::span<const PlacedCollider> colliders,
            std::span<StepReport> reports);

  // Joins the bodies a and b of step(), a != b, and wakes them; returns the joint's number. Sums
  // follow the order of the pairs and, for several joints of one pair, of their numbers.
  std::size_t join(std::size_t a, std::size_t b, Joint joint);
  // Removes a joint; numbers of others are unchanged. False: there is no such joint.
  bool separate(std::size_t number);
  // The joint as the last step left it; null: there is no such joint.
  const Joint* joint(std::size_t number) const;

  // Two bodies with a force between them in the last step, a < b. Sorted.
  struct Touch {
    std::size_t a = 0, b = 0;
    double impulse = 0.0;  // N s
  };
  std::span<const Touch> touches() const { return touches_; }
  // Two bodies without a shape, of which one has come into the ball around the other: they pass
  // through each other. Empty: there were none since the start.
  const std::optional<std::pair<std::size_t, std::size_t>>& passing() const { return passing_; }
  bool asleep(std::size_t i) const { return i < rest_.size() && rest_[i].asleep; }
  void wake(std::size_t i) {
    if (i < rest_.size()) rest_[i] = {};
  }

  // Saves or restores which bodies rest and for how long, and the state of the joints, which must
  // exist already. bodies: their number.
  void carry(StateStream& stream, std::size_t bodies) {
    stream.sized(rest_);
    stream.require(rest_.empty() || rest_.size() == bodies);
    if (stream.reads()) touches_.clear();
    if (stream.reads()) passing_.reset();
    for (Link& link : links_) link.joint.carry(stream);
  }

 private:
  struct Rest {
    RestTime time;
    bool asleep = false;
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
    double alpha = 0.0, beta = 0.0;
    DampingRatios ratios;

    void carry(StateStream& stream) { stream(time, asleep, gravity, alpha, beta, ratios); }
  };
  // Two bodies that may be in contact.
  struct Pair {
    std::size_t a = 0, b = 0;
    // Their points.
    std::size_t first = 0, count = 0;
  };

  // Bodies that are solved at once.
  struct Island {
    // Its bodies: `count` entries of islands_ from `first` on.
    std::size_t first = 0, count = 0;
    // Its pairs: `pairs` entries of by_island_ from `first_pair` on.
    std::size_t first_pair = 0, pairs = 0;
  };
  // Buffers of a thread for its present island, and the contacts of the islands that it has
  // stepped.
  struct Worker {
    std::vector<PairPoint> points;
    std::vector<IslandJoint> joints;
    std::vector<IslandMember> members;
    std::vector<StepReport> reports;
    std::vector<Touch> touches;
    ContactIsland island;
    // For an island whose step is subdivided.
    std::vector<PartBody> bodies;
    std::vector<PartPair> pairs;
    StepParts parts;
    ImpactSearch impacts;
  };

  // A joint, a < b.
  struct Link {
    std::size_t a = 0, b = 0;
    std::size_t number = 0;
    bool turned = false;  // b has the joint's first position
    Joint joint;
  };

  bool has_to_wake(std::size_t i) const;
  bool wake_pair(std::size_t a, std::size_t b);
  bool may_touch(std::size_t a, std::size_t b) const;
  bool is_joined(std::size_t i) const;
  void gather_joints(std::size_t root_here, std::vector<IslandJoint>& joints);
  void begin(std::size_t i);
  void begin_or_sleep(std::size_t i);
  void find_pairs();
  bool meet_guests();
  bool hosts(std::size_t root_here) const { return guests_ != nullptr && hosts_[root_here] != 0; }
  void look_at(std::size_t a, std::size_t b);
  void make_islands();
  void list_islands();
  void step_alone(std::size_t i);
  void wake_around_moved();
  void step_island(const Island& island, Worker& worker);
  bool step_in_parts(const Island& island, Worker& worker, PartReason reason);
  bool step_impact(const Island& island, std::size_t points, Worker& worker);
  void step_islands();
  void note_touches(std::span<const PairPoint> points, std::span<const std::size_t> who,
                    std::vector<Touch>& touches) const;
  void put_to_sleep();
  template <class Work>
  void share(std::size_t count, Work&& work);

  Options options_;
  std::span<ContactBody* const> bodies_;
  std::span<const PlacedCollider> colliders_;
  std::span<StepReport> reports_;
  std::vector<Rest> rest_;
  std::vector<char> begun_;  // the body's step is under way
  std::vector<char> near_;   // it may touch a collider, or a hand holds it
  // parent_: once islands are made the lowest body of each one's island.
  std::vector<std::size_t> by_place_, parent_, islands_;
  std::vector<Island> listed_;
  std::vector<std::size_t> by_island_;  // of pairs_, those of an island next to each other
  std::vector<std::size_t> member_of_;  // the body's number in its island
  std::optional<std::pair<std::size_t, std::size_t>> passing_;
  std::vector<char> restless_;  // of an island, by its root
  std::vector<Pair> pairs_;
  std::vector<Link> links_;  // by a, b and number
  std::size_t next_joint_ = 0;
  IslandGuests* guests_ = nullptr;
  std::vector<ContactStep*> met_;  // bodies that guests can be in contact with
  std::vector<char> hosts_;        // of an island with guests, by its root
  std::vector<PairPoint> points_;
  std::size_t used_ = 0;
  std::vector<Touch> touches_;
  std::unique_ptr<ThreadPool> pool_;  // null: the caller alone
  std::optional<Jobs> jobs_;          // in its place
  PairFilter filter_;
  std::vector<Worker> workers_;  // one a thread
};

// Joints between vertices of bodies (runtime/contact/joint.h). Joins a vertex of each body. Both
// bodies need Body::set_contact() and one step size. Errors: kUsage for a value that is not finite
// or negative, and if neither vertex can move; otherwise same as for Model::vertex.
Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         VertexId to, const JointOptions& options = {});
// Joins a vertex of the first body to its present position on the second: to a point that moves
// with the nearest vertex of the second body's boundary.
Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         const JointOptions& options = {});
// The point of the body that is at a position now, m, world, and moves with the nearest vertex of
// its boundary.
JointPlace place_at(const ContactBody& body, const Eigen::Vector3d& where);
// The point that is a vertex. Errors: those of Model::vertex; kUsage: a vertex without weights of
// the body's bones.
Result<JointPlace> vertex_place(const ContactBody& body, VertexId vertex);
// The vertex of the boundary that is nearest to a position now, m, world.
JointPlace vertex_near(const ContactBody& body, const Eigen::Vector3d& where);
// Moves the point in the body to a position now, m, world.
void bring_to(const ContactBody& body, const Eigen::Vector3d& where, JointPlace& place);
// Joins a vertex of the first body to a point of the second.
Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         JointPlace to, const JointOptions& options);
// Error (kUsage): a body without Body::set_contact() takes no joint.
Status check_joinable(const ContactBody& body);
// Present position of a point of the body, m, world.
Eigen::Vector3d place_now(const ContactBody& body, const JointPlace& place);
// Present distance of the joint's two points, m.
double joint_distance(const Joint& joint, const ContactBody& first, const ContactBody& second);

}  // namespace tremolo
