// Bodies that may touch each other, stepped together (docs/theory.md, section "Contact").
//
// Bodies whose balls come near are looked at point by point; those that may touch make an island,
// which is solved for at once (contact_island.h); the others step by themselves, as Body::step()
// does, with the same bits. A free body that has been nearly at rest for kQuiet falls asleep with
// all that it touches: it costs nothing, and wakes when something that is awake comes near, a load
// or a hand begins, gravity changes, or a collider moves beside it. Its motion is booked as taken
// by contact.
//
// Islands, and bodies by themselves, are shared by threads, as many as are asked for: each is
// stepped by one, from its own bodies alone, so that no bit depends on the number of threads.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/body.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_island.h"
#include "runtime/contact/solve/step_parts.h"
#include "runtime/threads/thread_pool.h"

namespace tremolo {

class BodyGroup {
 public:
  static constexpr double kQuiet = 0.5;  // s

  struct Options {
    bool sleep = true;
  };

  BodyGroup() = default;
  explicit BodyGroup(const Options& options) : options_(options) {}

  // How many threads work in step(), the caller's included; 0: one a core. At first it is one.
  // kSystem, and nothing changes, where the threads cannot be had.
  Status set_threads(unsigned threads);
  unsigned threads() const { return pool_ ? pool_->threads() : 1; }

  // One step of all bodies, which have one step size; a null is left out. Body i is the same in
  // each call. The order of the bodies decides the order of sums: let it be one that does not
  // change with how they came. reports: one a body; that of a body that sleeps is converged,
  // without iterations. Where an island is not solved, none of its bodies is moved and each reports
  // it. Errors of a body's own step: as Body::step().
  void step(std::span<Body* const> bodies, std::span<const PlacedCollider> colliders,
            std::span<StepReport> reports);

  // Joins the bodies a and b of step(), a != b, which wake; returns the joint's number. Sums follow
  // the order of the pairs, and of the joints of one pair that of their numbers.
  std::size_t join(std::size_t a, std::size_t b, Joint joint);
  // False: there is no such joint. Numbers of others stay.
  bool separate(std::size_t number);
  // The joint as the last step left it; null: there is no such joint.
  const Joint* joint(std::size_t number) const;

  // Two bodies that pushed each other in the last step, a < b, and the impulse, N s. Sorted.
  struct Touch {
    std::size_t a = 0, b = 0;
    double impulse = 0.0;
  };
  std::span<const Touch> touches() const { return touches_; }
  bool asleep(std::size_t i) const { return i < rest_.size() && rest_[i].asleep; }
  void wake(std::size_t i) {
    if (i < rest_.size()) rest_[i] = {};
  }

  // Who rests and for how long, and what joints tell; the joints themselves are as before. bodies:
  // as many as there are.
  void carry(StateStream& stream, std::size_t bodies) {
    stream.sized(rest_);
    stream.require(rest_.empty() || rest_.size() == bodies);
    if (stream.reads()) touches_.clear();
    for (Link& link : links_) link.joint.carry(stream);
  }

 private:
  struct Rest {
    double quiet = 0.0;  // s
    bool asleep = false;
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
    double alpha = 0.0, beta = 0.0;

    void carry(StateStream& stream) { stream(quiet, asleep, gravity, alpha, beta); }
  };
  // Bodies that may touch, and their points.
  struct Pair {
    std::size_t a = 0, b = 0;
    std::size_t first = 0, count = 0;
  };

  // Bodies that are solved for at once: `count` of islands_ from `first` on, and `pairs` of
  // by_island_ from `first_pair` on.
  struct Island {
    std::size_t first = 0, count = 0;
    std::size_t first_pair = 0, pairs = 0;
  };
  // What a thread needs for the island at hand, and the touches of those that it has stepped.
  struct Worker {
    std::vector<PairPoint> points;
    std::vector<IslandJoint> joints;
    std::vector<IslandMember> members;
    std::vector<StepReport> reports;
    std::vector<Touch> touches;
    ContactIsland island;
    // For an island that is taken in parts.
    std::vector<PartBody> bodies;
    std::vector<PartPair> pairs;
    StepParts parts;
  };

  // A joint, a < b; turned: b has its first place.
  struct Link {
    std::size_t a = 0, b = 0;
    std::size_t number = 0;
    bool turned = false;
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
  void look_at(std::size_t a, std::size_t b);
  std::size_t root(std::size_t i);
  void make_islands();
  void list_islands();
  void step_alone(std::size_t i);
  void step_island(const Island& island, Worker& worker);
  bool step_in_parts(const Island& island, Worker& worker);
  void step_islands();
  void note_touches(std::span<const PairPoint> points, std::span<const std::size_t> who,
                    std::vector<Touch>& touches) const;
  void put_to_sleep();
  template <class Work>
  void share(std::size_t count, Work&& work);

  Options options_;
  std::span<Body* const> bodies_;
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
  std::vector<char> restless_;          // of an island, by its root
  std::vector<Pair> pairs_;
  std::vector<Link> links_;  // by a, b and number
  std::size_t next_joint_ = 0;
  std::vector<PairPoint> points_;
  std::size_t used_ = 0;
  std::vector<Touch> touches_;
  std::unique_ptr<ThreadPool> pool_;  // null: the caller alone
  std::vector<Worker> workers_;       // one a thread
};

}  // namespace tremolo
