#include "runtime/world/guest_links.h"

#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/guest_joints.h"
#include "runtime/world/guest_points.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A hand of the scene on a guest.
class GuestHandCourse : public HandCourse {
 public:
  static Result<GuestHandCourse> create(const SceneHand& wanted, const MixedGuests& guests,
                                        std::size_t guest) {
    const Result<std::size_t> point = guest_point(guests, guest, wanted.at, "at", "hand");
    if (!point) return point.error();
    if (!std::isfinite(guests.mass_at(guest, *point)))
      return content_error("at = \"" + wanted.at + "\": it does not move, it is fixed");
    Result<MotionPath> path = MotionPath::create(wanted.motion);
    if (!path) return path.error();
    return GuestHandCourse(std::move(*path), guests.number_of(guest, *point), guest, *point);
  }

  void before_step(const SceneHand& wanted, std::int64_t k, double step, MixedGuests& guests) {
    const Act next = act(wanted, k, step);
    if (next == Act::kRelease) {
      guests.let_go(*number_);
      number_.reset();
    }
    if (next != Act::kGrab && next != Act::kMove) return;
    if (next == Act::kGrab) {
      begin_at(wanted, guests.point_at(guest_, point_), k, step);
      HandSpring spring = guests.stiffest_hand(guest_, point_);
      if (!wanted.pin) {
        const HandSpring most = spring;
        spring = {wanted.stiffness, wanted.damping};
        limit_spring(most, step, spring.stiffness, spring.damping);
      }
      // A cloth's pin may have begun to hold the particle.
      const Result<std::size_t> number = guests.hold(guest_, point_, spring);
      over_ = !number;
      if (!number) return;
      number_ = *number;
      spring_ = spring;
    }
    (void)guests.move_hand(*number_, place_after(k, step));
  }

  void carry(StateStream& stream, const MixedGuests& guests) {
    stream(number_, over_, base_);
    if (!stream.reads()) return;
    spring_.reset();
    if (!number_) return;
    const GuestHand* held = guests.hand(*number_);
    stream.require(held != nullptr && held->guest == guest_ && held->point == point_);
    if (stream.good()) spring_ = HandSpring{held->stiffness, held->damping};
  }

  bool is_on(std::size_t guest) const { return guest_ == guest && !gone_; }
  // Its guest was removed: it does nothing any more.
  void end() {
    gone_ = over_ = true;
    number_.reset();
  }
  Vector3d held(const MixedGuests& guests) const {
    return gone_ ? Vector3d(Vector3d::Zero()) : guests.point_at(guest_, point_);
  }
  Vector3d force(const MixedGuests& guests) const {
    return number_ ? guests.hand(*number_)->force : Vector3d(Vector3d::Zero());
  }

 private:
  GuestHandCourse(MotionPath path, VertexId vertex, std::size_t guest, std::size_t point)
      : HandCourse(std::move(path), vertex), guest_(guest), point_(point) {}

  std::size_t guest_, point_;
  bool gone_ = false;
};

class WorldGuestLinks final : public GuestLinks {
 public:
  // Copies hands and joints of the scene, since the world may move.
  WorldGuestLinks(const Scene& scene, MixedGuests& guests)
      : step_(scene.step),
        guests_(&guests),
        wanted_hands_(scene.hands),
        wanted_joints_(scene.joints),
        hands_(scene.hands.size()),
        joints_(scene.joints.size()) {}

  Status add(const SceneWorld& world) {
    const std::map<std::string, std::size_t> numbers = numbers_of_guests();
    for (std::size_t i = 0; i < hands_.size(); ++i) {
      const auto guest = numbers.find(wanted_hands_[i].body);
      if (guest == numbers.end()) continue;
      Result<GuestHandCourse> hand =
          GuestHandCourse::create(wanted_hands_[i], *guests_, guest->second);
      if (!hand) return error_of_listed("hand", i, wanted_hands_[i], hand.error());
      hands_[i] = std::move(*hand);
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const SceneJoint& wanted = wanted_joints_[i];
      if (numbers.contains(wanted.body) || numbers.contains(wanted.to))
        if (Status s = make_joint(world, numbers, i); !s) return s;
    }
    return Success{};
  }

  Status join(const SceneWorld& world, std::size_t i) override {
    // Joints of other bodies may have been added since the last call.
    const std::size_t before = joints_.size();
    wanted_joints_ = world.scene().joints;
    joints_.resize(i + 1);
    Status made = make_joint(world, numbers_of_guests(), i);
    if (!made) joints_.resize(before);
    return made;
  }
  void end_joint(std::size_t i) override {
    if (i >= joints_.size() || !joints_[i]) return;
    for (const std::size_t number : joints_[i]->numbers) guests_->separate(number);
    joints_[i].reset();
  }
  void part_from(std::size_t body) override {
    end_joints([body](const GuestJoint& joint) { return !joint.to_guest && joint.other == body; });
  }
  void forget(std::size_t guest) override {
    for (std::optional<GuestHandCourse>& hand : hands_)
      if (hand && hand->is_on(guest)) hand->end();
    end_joints([guest](const GuestJoint& joint) {
      return joint.guest == guest || (joint.to_guest && joint.other == guest);
    });
  }

  void before_step(std::int64_t k) override {
    for (std::size_t i = 0; i < hands_.size(); ++i)
      if (hands_[i]) hands_[i]->before_step(wanted_hands_[i], k, step_, *guests_);
    const double now = static_cast<double>(k) * step_ + kSameTime * step_;
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (joints_[i] && now >= wanted_joints_[i].until)
        for (const std::size_t number : joints_[i]->numbers) guests_->separate(number);
  }

  void carry(StateStream& stream) override {
    for (std::optional<GuestHandCourse>& hand : hands_)
      if (hand) hand->carry(stream, *guests_);
  }

  const HandCourse* hand(std::size_t i) const override { return hands_[i] ? &*hands_[i] : nullptr; }
  Vector3d hand_force(std::size_t i) const override { return hands_[i]->force(*guests_); }
  Vector3d hand_vertex(std::size_t i) const override { return hands_[i]->held(*guests_); }
  const Joint* joint(std::size_t i) const override {
    if (!joints_[i]) return nullptr;
    const std::vector<std::size_t>& numbers = joints_[i]->numbers;
    const GuestJoint* found = guests_->joint(numbers.front());
    if (found == nullptr) return nullptr;
    Joint& shown = joints_[i]->shown;
    shown = numbers.size() == 1 ? found->joint : Joint{};
    for (std::size_t k = 0; numbers.size() > 1 && k < numbers.size(); ++k)
      add_joint(shown, guests_->joint(numbers[k])->joint);
    if (joints_[i]->turned) shown.force = -shown.force;
    return &shown;
  }
  std::size_t joint_points(std::size_t i) const override {
    return joints_[i] ? joints_[i]->numbers.size() : 0;
  }

 private:
  // numbers: one; of a weld several. shown: the joint, or the sums of the weld, with the force on
  // the scene's first body.
  struct Joined {
    std::vector<std::size_t> numbers;
    bool turned;
    mutable Joint shown;
  };

  std::map<std::string, std::size_t> numbers_of_guests() const {
    std::map<std::string, std::size_t> numbers;
    for (std::size_t i = 0; i < guests_->size(); ++i)
      if (!guests_->removed(i)) numbers[guests_->name(i)] = i;
    return numbers;
  }
  Status make_joint(const SceneWorld& world, const std::map<std::string, std::size_t>& numbers,
                    std::size_t i) {
    bool turned = false;
    Result<std::vector<GuestJoint>> made =
        GuestJointMaker(world, *guests_, numbers).make(i, turned);
    if (!made) return error_of_listed("joint", i, wanted_joints_[i], made.error());
    joints_[i] = Joined{{}, turned, {}};
    for (GuestJoint& joint : *made) joints_[i]->numbers.push_back(guests_->join(std::move(joint)));
    return Success{};
  }
  template <class Which>
  void end_joints(const Which& which) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (!joints_[i]) continue;
      const GuestJoint* joint = guests_->joint(joints_[i]->numbers.front());
      if (joint != nullptr && which(*joint)) end_joint(i);
    }
  }

  double step_;
  MixedGuests* guests_;
  std::vector<SceneHand> wanted_hands_;
  std::vector<SceneJoint> wanted_joints_;
  // One for each of the scene; empty: it holds other bodies.
  std::vector<std::optional<GuestHandCourse>> hands_;
  std::vector<std::optional<Joined>> joints_;
};

}  // namespace

Result<std::unique_ptr<GuestLinks>> make_guest_links(const SceneWorld& world, MixedGuests& guests) {
  auto links = std::make_unique<WorldGuestLinks>(world.scene(), guests);
  if (Status s = links->add(world); !s) return s.error();
  return std::unique_ptr<GuestLinks>(std::move(links));
}

}  // namespace tremolo
