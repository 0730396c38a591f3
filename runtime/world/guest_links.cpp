#include "runtime/world/guest_links.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/mesh/selector.h"
#include "common/text.h"
#include "formats/basis/selector_reader.h"
#include "runtime/bodies/cloth/cloth_places.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

std::string told(const char* key, const std::string& text) {
  return std::string(key) + " = \"" + text + "\"";
}

std::optional<VertexId> whole_vertex(const std::string& text) {
  VertexId vertex = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, vertex);
  return stop == end && code == std::errc{} ? std::optional(vertex) : std::nullopt;
}

// The numbers of a `file:` are read here.
Status read_files(Selector& selector, std::size_t vertices) {
  if (auto* file = std::get_if<SelectFile>(&selector.choice))
    if (Status s = take(file->ids, read_id_list(file->path, vertices)); !s) return s;
  for (Selector& other : selector.further)
    if (Status s = read_files(other, vertices); !s) return s;
  return Success{};
}

// Vertices of the surface of a body of tetrahedra.
Result<std::vector<VertexId>> tets_vertices(const TetStep& step, const std::string& text) {
  const TetModel& model = step.body().model();
  Result<Selector> selector = parse_selector(text);
  if (!selector) return selector.error();
  if (Status s = read_files(*selector, model.vertices()); !s) return s.error();
  std::map<std::string, std::vector<VertexId>> sets;
  std::vector<bool> outside(model.nodes(), false);
  for (std::size_t v = 0; v < model.vertices(); ++v) {
    if (!step.point_of(static_cast<VertexId>(v))) continue;
    outside[v] = true;
    if (model.held()[v] != 0) sets["fixed"].push_back(static_cast<VertexId>(v));
  }
  return select_vertices(*selector, {model.mesh().vertices, std::move(outside), sets,
                                     model.mesh().colours, "inside the body"});
}

Result<std::vector<VertexId>> cloth_vertices(const ClothStep& step, const std::string& text) {
  const ClothBody& body = step.body();
  std::vector<std::size_t> particles;
  if (Status s = add_cloth_place(body.cloth(), &body.model().parts(), text, particles); !s)
    return s.error();
  return std::vector<VertexId>(particles.begin(), particles.end());
}

Result<VertexId> one_vertex(const MixedGuests& guests, std::size_t guest, const std::string& text,
                            const char* key, const char* holder) {
  // A number may be that of a vertex inside, which has its own error.
  if (const std::optional<VertexId> number = whole_vertex(text)) return *number;
  const ClothStep* cloth = guests.cloth(guest);
  const Result<std::vector<VertexId>> found =
      cloth != nullptr ? cloth_vertices(*cloth, text) : tets_vertices(*guests.tets(guest), text);
  if (!found) return content_error(told(key, text) + ": " + found.error().message);
  if (found->size() != 1)
    return content_error(told(key, text) + " is " + std::to_string(found->size()) +
                         (cloth != nullptr ? " particles, a " : " vertices, a ") + holder +
                         " holds one: near:X,Y,Z takes the nearest");
  return found->front();
}

}  // namespace

Result<std::size_t> guest_point(const MixedGuests& guests, std::size_t guest,
                                const std::string& text, const char* key, const char* holder) {
  const Result<VertexId> vertex = one_vertex(guests, guest, text, key, holder);
  if (!vertex) return vertex.error();
  const Result<std::size_t> point = guests.point_of_vertex(guest, *vertex);
  if (!point) return content_error(told(key, text) + ": " + point.error().message);
  return *point;
}

namespace {

// A hand of the scene on a guest.
class GuestHandCourse : public HandCourse {
 public:
  static Result<GuestHandCourse> create(const SceneHand& wanted, const MixedGuests& guests,
                                        std::size_t guest) {
    const Result<std::size_t> point = guest_point(guests, guest, wanted.at, "at", "hand");
    if (!point) return point.error();
    if (!std::isfinite(guests.mass_at(guest, *point)))
      return content_error(told("at", wanted.at) + ": it does not move, it is fixed");
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

  Vector3d held(const MixedGuests& guests) const { return guests.point_at(guest_, point_); }
  Vector3d force(const MixedGuests& guests) const {
    return number_ ? guests.hand(*number_)->force : Vector3d(Vector3d::Zero());
  }

 private:
  GuestHandCourse(MotionPath path, VertexId vertex, std::size_t guest, std::size_t point)
      : HandCourse(std::move(path), vertex), guest_(guest), point_(point) {}

  std::size_t guest_, point_;
};

// One of the two ends of a joint: a guest's point, or a place of a body.
struct JointEnd {
  std::optional<std::size_t> guest;
  std::size_t point = 0;
  std::size_t body = 0;
  VertexRows place;
};

// Makes the joints of a world with guests.
class JointMaker {
 public:
  JointMaker(const SceneWorld& world, const MixedGuests& guests,
             const std::map<std::string, std::size_t>& numbers)
      : world_(world), guests_(guests), numbers_(numbers) {}

  // turned: the joint's guest is `to`.
  Result<GuestJoint> make(const SceneJoint& wanted, bool& turned) const {
    JointEnd first = end_of(wanted.body), second = end_of(wanted.to);
    if (on_bones(first) || on_bones(second))
      return content_error("a body on several bones takes no joint");
    if (Status s = find_place(first, wanted.at, "at"); !s) return s.error();
    if (wanted.to_at.empty())
      find_nearest(second, where(first), wanted.options.length);
    else if (Status s = find_place(second, wanted.to_at, "to-at"); !s)
      return s.error();
    if (Status s = check_apart(wanted, first, second); !s) return s.error();
    turned = !first.guest;
    return join(wanted, turned ? second : first, turned ? first : second);
  }

 private:
  JointEnd end_of(const std::string& name) const {
    JointEnd end;
    if (const auto found = numbers_.find(name); found != numbers_.end())
      end.guest = found->second;
    else
      end.body = *world_.find(name);
    return end;
  }

  bool on_bones(const JointEnd& end) const {
    return !end.guest && world_.body(end.body).bones() > 1;
  }

  Status find_place(JointEnd& end, const std::string& text, const char* key) const {
    if (end.guest) return take(end.point, guest_point(guests_, *end.guest, text, key, "joint"));
    const ContactBody& body = world_.body(end.body);
    const Result<VertexId> vertex = joint_vertex(key, text, body);
    if (!vertex) return vertex.error();
    if (Status s = take(end.place, body.model().vertex(*vertex)); !s)
      return content_error(told(key, text) + ": " + s.error().message);
    return Success{};
  }

  // Of a guest, which has no rotation, the nearest point; of a body the point that is there now, or
  // the nearest vertex if the joint has a length.
  void find_nearest(JointEnd& end, const Vector3d& place, double length) const {
    if (end.guest) {
      end.point = guests_.point_near(*end.guest, place);
      return;
    }
    const ContactBody& body = world_.body(end.body);
    end.place = place_at(body, place);
    if (length == 0.0) return;
    const Vector3d there = body.pose().rotation.conjugate() * (place - body.pose().position);
    end.place.rest += nearest_vertex(body, there) - there;
  }

  // Its position now along the body's axes, m.
  static Vector3d nearest_vertex(const ContactBody& body, const Vector3d& there) {
    const VertexBlock& boundary = body.model().surface();
    Vector3d nearest = Vector3d::Constant(std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < boundary.rest.size(); ++i) {
      const Vector3d vertex =
          boundary.rest[i] + boundary.rows.middleRows(3 * i, 3) * body.state().q;
      if ((vertex - there).squaredNorm() < (nearest - there).squaredNorm()) nearest = vertex;
    }
    return nearest;
  }

  Vector3d where(const JointEnd& end) const {
    if (end.guest) return guests_.point_at(*end.guest, end.point);
    const ContactBody& body = world_.body(end.body);
    return body.pose() * Vector3d(end.place.rest + end.place.rows * body.state().q);
  }

  double mass_at(const JointEnd& end) const {
    return end.guest ? guests_.mass_at(*end.guest, end.point)
                     : world_.body(end.body).mass_at(end.place);
  }

  Status check_apart(const SceneJoint& wanted, const JointEnd& first,
                     const JointEnd& second) const {
    const double apart = (where(first) - where(second)).norm(), length = wanted.options.length;
    const double limit = first.guest ? guests_.margin(*first.guest)
                                     : world_.body(first.body).contact()->surface().law.margin;
    if (wanted.options.stiffness || std::abs(apart - length) <= limit) return Success{};
    return content_error("its places are " + number_text(apart) + " m apart at the start, not " +
                         number_text(length) +
                         " m: say `length`, a `stiffness`, or put a body "
                         "elsewhere");
  }

  Result<GuestJoint> join(const SceneJoint& wanted, const JointEnd& held,
                          const JointEnd& other) const {
    const double lightness = 1.0 / mass_at(held) + 1.0 / mass_at(other);
    if (!(lightness > 0.0)) return content_error("neither place moves: there is nothing to join");
    GuestJoint made;
    made.guest = *held.guest;
    made.point = held.point;
    made.to_guest = other.guest.has_value();
    made.other = made.to_guest ? *other.guest : world_.group_number(other.body);
    made.other_point = other.point;
    made.along = wanted.options.stiffness.has_value();
    Joint& joint = made.joint;
    joint.second = other.place;
    joint.length = wanted.options.length;
    joint.touch = wanted.options.touch;
    const HandSpring most = stiffest_spring(1.0 / lightness, world_.step_size());
    joint.stiffness = wanted.options.stiffness.value_or(most.stiffness);
    joint.damping = made.along ? wanted.options.damping : most.damping;
    limit_spring(most, world_.step_size(), joint.stiffness, joint.damping);
    return made;
  }

  const SceneWorld& world_;
  const MixedGuests& guests_;
  const std::map<std::string, std::size_t>& numbers_;
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
    std::map<std::string, std::size_t> numbers;
    for (std::size_t i = 0; i < guests_->size(); ++i) numbers[guests_->name(i)] = i;
    for (std::size_t i = 0; i < hands_.size(); ++i) {
      const auto guest = numbers.find(wanted_hands_[i].body);
      if (guest == numbers.end()) continue;
      Result<GuestHandCourse> hand =
          GuestHandCourse::create(wanted_hands_[i], *guests_, guest->second);
      if (!hand) return error_of_listed("hand", i, wanted_hands_[i], hand.error());
      hands_[i] = std::move(*hand);
    }
    const JointMaker maker(world, *guests_, numbers);
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const SceneJoint& wanted = wanted_joints_[i];
      if (!numbers.contains(wanted.body) && !numbers.contains(wanted.to)) continue;
      bool turned = false;
      Result<GuestJoint> joint = maker.make(wanted, turned);
      if (!joint) return error_of_listed("joint", i, wanted, joint.error());
      joints_[i] = Joined{guests_->join(std::move(*joint)), turned, {}};
    }
    return Success{};
  }

  void before_step(std::int64_t k) override {
    for (std::size_t i = 0; i < hands_.size(); ++i)
      if (hands_[i]) hands_[i]->before_step(wanted_hands_[i], k, step_, *guests_);
    const double now = static_cast<double>(k) * step_ + kSameTime * step_;
    for (std::size_t i = 0; i < joints_.size(); ++i)
      if (joints_[i] && now >= wanted_joints_[i].until) guests_->separate(joints_[i]->number);
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
    const GuestJoint* found = guests_->joint(joints_[i]->number);
    if (found == nullptr) return nullptr;
    Joint& shown = joints_[i]->shown;
    shown = found->joint;
    if (joints_[i]->turned) shown.force = -shown.force;
    return &shown;
  }

 private:
  // shown: the joint with the force on the scene's first body.
  struct Joined {
    std::size_t number;
    bool turned;
    mutable Joint shown;
  };

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
