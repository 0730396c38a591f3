#include "runtime/apps/python/module/nodal_source.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/contact/springs.h"
#include "runtime/mixed/mixed_guests.h"

namespace tremolo::python {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

Status refuse_grab(std::size_t number) {
  return usage_error("there is no grab " + std::to_string(number));
}

// A body of tetrahedra, wherever it is.
class TetsSource : public NodalSource {
 public:
  TetsSource(std::string name, const TetsKind& kind)
      : name_(std::move(name)),
        kind_(&kind),
        vertices_(kind.surface->vertices()),
        normals_(vertices_.size()) {}

  const std::string& name() const override { return name_; }
  const char* kind() const override { return "tets"; }
  double mass() const override { return kind_->model->mass(); }
  double size() const override {
    return (kind_->model->rest_box().high - kind_->model->rest_box().low).maxCoeff();
  }
  const VectorXd& points() const override { return body().positions(); }
  const VectorXd& velocities() const override { return body().velocities(); }
  std::span<const std::uint8_t> held() const override { return kind_->model->held(); }
  Status set_state(const VectorXd& x, const VectorXd& v) override { return body().set_state(x, v); }
  std::size_t drawn() const override { return vertices_.size(); }
  const std::vector<Triangle>& triangles() const override {
    return kind_->surface->rest().triangles;
  }
  // Positions of the surface are sums of those of points with constant weights, and so are
  // velocities.
  std::span<const Vector3d> place(const VectorXd& of_points) override {
    kind_->surface->place(of_points, vertices_, normals_);
    return vertices_;
  }
  NodalEnergy energy() override {
    TetBody& b = body();
    return {b.kinetic_energy(), b.elastic_energy(), b.gravity_energy(), std::nullopt};
  }
  Momenta momenta() const override { return {body().momentum(), body().angular_momentum()}; }

 protected:
  virtual TetBody& body() const = 0;
  const TetsKind& tets_kind() const { return *kind_; }

 private:
  std::string name_;
  const TetsKind* kind_;
  std::vector<Vector3d> vertices_;
  std::vector<Eigen::Vector3f> normals_;
};

// One among bodies of other kinds: a TetsSource or a ClothSource with the balance of its contact.
template <class Source>
class GuestSource : public Source {
 public:
  template <class... Arguments>
  GuestSource(MixedGuests& guests, std::size_t i, Arguments&&... arguments)
      : Source(std::forward<Arguments>(arguments)...), guests_(guests), i_(i) {}

  bool failed() const override { return guests_.failed(i_); }
  bool asleep() const override { return guests_.asleep(i_); }
  NodalEnergy energy() override {
    NodalEnergy now = Source::energy();
    now.contact = guests_.account(i_).energy;
    return now;
  }
  // The contact point at the vertex, which may be the next one to it.
  Result<std::size_t> grab(std::size_t vertex, std::optional<double> stiffness,
                           std::optional<double> damping) override {
    const std::size_t point = guests_.point_near(i_, this->place(this->points())[vertex]);
    if (!std::isfinite(guests_.mass_at(i_, point)))
      return usage_error("body '" + this->name() + "': vertex " + std::to_string(vertex) +
                         " is fixed");
    const HandSpring most = guests_.stiffest_hand(i_, point);
    HandSpring spring{stiffness.value_or(most.stiffness), damping.value_or(most.damping)};
    limit_spring(most, guests_.step_size(), spring.stiffness, spring.damping);
    return guests_.hold(i_, point, spring);
  }
  Status move_grab(std::size_t number, const Vector3d& position) override {
    return is_grab(number) ? guests_.move_hand(number, position) : refuse_grab(number);
  }
  Status release(std::size_t number) override {
    if (!is_grab(number)) return refuse_grab(number);
    guests_.let_go(number);
    return Success{};
  }
  std::optional<NodalAccount> account() override {
    const ContactSums& sums = guests_.sums(i_);
    return NodalAccount{energy(),
                        sums.given,
                        -sums.lost,
                        -sums.friction_loss,
                        sums.work + sums.hand + sums.joint + guests_.load_work(i_),
                        sums.hand,
                        sums.joint,
                        guests_.load_work(i_)};
  }
  // The contact point as for grab().
  Status apply_force(std::size_t vertex, const Vector3d& force, int steps) override {
    return guests_.apply_force(i_, guests_.point_near(i_, this->place(this->points())[vertex]),
                               force, steps);
  }
  std::int64_t contacts() const override { return guests_.contacts(i_); }
  double penetration_max() const override { return guests_.penetration_max(i_); }

 protected:
  MixedGuests& guests_;
  std::size_t i_;

 private:
  bool is_grab(std::size_t number) const {
    const GuestHand* held = guests_.hand(number);
    return held != nullptr && held->guest == i_;
  }
};

class TetGuestSource final : public GuestSource<TetsSource> {
 public:
  TetGuestSource(MixedGuests& guests, std::size_t i, const TetsKind& kind)
      : GuestSource(guests, i, guests.name(i), kind) {}

 private:
  Status set_state(const VectorXd& x, const VectorXd& v) override {
    guests_.put_awake(i_);
    return body().set_state(x, v);
  }
  TetBody& body() const override { return guests_.tets(i_)->body(); }
};

// One in a scene of tetrahedra, which may have one grab.
class TetGroupSource final : public TetsSource {
 public:
  TetGroupSource(TetGroup& group, std::size_t i, std::string name, const TetsKind& kind)
      : TetsSource(std::move(name), kind), group_(group), i_(i) {}

  bool asleep() const override { return group_.asleep(i_); }
  Status set_state(const VectorXd& x, const VectorXd& v) override {
    return group_.set_state(i_, x, v);
  }
  Result<std::size_t> grab(std::size_t vertex, std::optional<double> stiffness,
                           std::optional<double> damping) override {
    if (holds_)
      return usage_error("body '" + name() + "' has a grab, and can have one: release it first");
    TetHand hand = hand_at(*tets_kind().model, tets_kind().surface->rest(), vertex);
    if (!stiffness || !damping)
      if (Status s = suit_springs(body(), hand); !s) return s.error();
    hand.stiffness = stiffness.value_or(hand.stiffness);
    hand.damping = damping.value_or(hand.damping);
    hand.point = goal_ = hand.of(body().positions());
    if (Status s = group_.set_hand(i_, hand); !s) return s.error();
    holds_ = true;
    return std::size_t{0};
  }
  Status move_grab(std::size_t number, const Vector3d& position) override {
    if (number != 0 || !holds_) return refuse_grab(number);
    goal_ = position;
    return Success{};
  }
  Status release(std::size_t number) override {
    if (number != 0 || !holds_) return refuse_grab(number);
    holds_ = false;
    return group_.set_hand(i_, std::nullopt);
  }
  // The grab's point goes to its goal in the step.
  Status begin_step() override {
    if (!holds_) return Success{};
    TetHand hand = *body().hand();
    hand.velocity = (goal_ - hand.point) / body().options().step;
    hand.point = goal_;
    return group_.set_hand(i_, hand);
  }

 private:
  TetBody& body() const override { return group_.body(i_); }
  TetGroup& group_;
  std::size_t i_;
  bool holds_ = false;
  Vector3d goal_ = Vector3d::Zero();
};

// A cloth, wherever it is.
class ClothSource : public NodalSource {
 public:
  explicit ClothSource(const ClothModel& model)
      : particles_(particles_of(model.parts())), vertices_(particles_.size()) {}

  const char* kind() const override { return "cloth"; }
  double mass() const override { return model().mass().sum(); }
  double size() const override {
    const VectorXd& x = model().parts().x;
    const Eigen::Map<const Eigen::Matrix3Xd> rest(x.data(), 3, x.size() / 3);
    return (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).maxCoeff();
  }
  std::span<const std::uint8_t> held() const override { return model().held(); }
  std::size_t drawn() const override { return particles_.size(); }
  const std::vector<Triangle>& triangles() const override {
    const ClothParts& parts = model().parts();
    return parts.drawn ? parts.drawn->triangles : parts.triangles;
  }
  std::span<const Vector3d> place(const VectorXd& of_points) override {
    for (std::size_t v = 0; v < particles_.size(); ++v)
      vertices_[v] = of_points.segment<3>(3 * particles_[v]);
    return vertices_;
  }
  // Of the free particles.
  NodalEnergy energy() override {
    const VectorXd &x = points(), &v = velocities();
    const auto fixed = held();
    double twice = 0.0;
    for (std::size_t k = 0; k < fixed.size(); ++k)
      if (fixed[k] == 0) twice += model().mass()[k] * v.segment<3>(3 * k).squaredNorm();
    const double elastic = model().elastic_energy(x);
    return {0.5 * twice, elastic, model().potential(x) - elastic, std::nullopt};
  }
  Momenta momenta() const override {
    Momenta sum;
    const auto fixed = held();
    for (std::size_t k = 0; k < fixed.size(); ++k) {
      if (fixed[k] != 0) continue;
      const Vector3d p = model().mass()[k] * velocities().segment<3>(3 * k);
      sum.linear += p;
      sum.angular += Vector3d(points().segment<3>(3 * k)).cross(p);
    }
    return sum;
  }

 protected:
  virtual const ClothModel& model() const = 0;
  Eigen::Index particle_of(std::size_t vertex) const { return particles_[vertex]; }

 private:
  static std::vector<Eigen::Index> particles_of(const ClothParts& parts) {
    const std::size_t count = parts.drawn ? parts.drawn->vertices.size() : parts.particles();
    std::vector<Eigen::Index> particles(count);
    for (std::size_t v = 0; v < count; ++v) {
      const bool renumbered = parts.drawn && !parts.drawn->sources.empty();
      const std::size_t vertex = renumbered ? static_cast<std::size_t>(parts.drawn->sources[v]) : v;
      particles[v] = static_cast<Eigen::Index>(parts.particle_of_vertex(vertex));
    }
    return particles;
  }

  std::vector<Eigen::Index> particles_;  // of each drawn vertex
  std::vector<Vector3d> vertices_;
};

class ClothGuestSource final : public GuestSource<ClothSource> {
 public:
  ClothGuestSource(MixedGuests& guests, std::size_t i)
      : GuestSource(guests, i, guests.cloth(i)->body().model()) {
    // Wind and pins put energy in that the bound does not know.
    driven = cloth().cloth().drag > 0.0 || !cloth().cloth().pins.empty();
  }

  const std::string& name() const override { return cloth().cloth().name; }
  const VectorXd& points() const override { return cloth().state().x; }
  const VectorXd& velocities() const override { return cloth().state().v; }
  Status set_state(const VectorXd& x, const VectorXd& v) override {
    guests_.put_awake(i_);
    return cloth().set_state(x, v);
  }

 private:
  ClothBody& cloth() const { return guests_.cloth(i_)->body(); }
  const ClothModel& model() const override { return cloth().model(); }
};

// One in a scene of cloth. A grab's number is the particle's, which the grab holds.
class ClothWorldSource final : public ClothSource {
 public:
  ClothWorldSource(ClothWorld& world, std::size_t i)
      : ClothSource(world.model(i)), world_(world), i_(i) {}

  const std::string& name() const override { return world_.scene().cloths[i_].name; }
  const VectorXd& points() const override { return world_.positions(i_); }
  const VectorXd& velocities() const override { return world_.velocities(i_); }
  Status set_state(const VectorXd& x, const VectorXd& v) override {
    return world_.set_state(i_, x, v);
  }
  Result<std::size_t> grab(std::size_t vertex, std::optional<double> stiffness,
                           std::optional<double> damping) override {
    if (stiffness || damping)
      return usage_error("a grab of a cloth holds its particle: leave stiffness and damping out");
    const auto particle = static_cast<std::size_t>(particle_of(vertex));
    if (held()[particle] != 0)
      return usage_error("cloth '" + name() + "': particle " + std::to_string(particle) +
                         " is held already");
    const Vector3d at = points().segment<3>(3 * particle_of(vertex));
    if (Status s = world_.hold(i_, particle, at); !s) return s.error();
    grabs_.insert(particle);
    return particle;
  }
  Status move_grab(std::size_t number, const Vector3d& position) override {
    if (!grabs_.contains(number)) return refuse_grab(number);
    return world_.hold(i_, number, position);
  }
  Status release(std::size_t number) override {
    if (grabs_.erase(number) == 0) return refuse_grab(number);
    return world_.let_go(i_, number);
  }

 private:
  const ClothModel& model() const override { return world_.model(i_); }

  ClothWorld& world_;
  std::size_t i_;
  std::set<std::size_t> grabs_;
};

}  // namespace

std::unique_ptr<NodalSource> source_of(MixedGuests& guests, std::size_t i, const TetsKind* kind) {
  if (kind == nullptr) return std::make_unique<ClothGuestSource>(guests, i);
  return std::make_unique<TetGuestSource>(guests, i, *kind);
}

NodalSources sources_of(TetGroup& group, const std::vector<std::string>& names,
                        const KindOf& kind_of) {
  NodalSources sources;
  for (std::size_t i = 0; i < group.size(); ++i)
    sources.push_back(std::make_unique<TetGroupSource>(group, i, names[i], kind_of(i)));
  return sources;
}

NodalSources sources_of(ClothWorld& world) {
  NodalSources sources;
  for (std::size_t i = 0; i < world.cloths(); ++i)
    sources.push_back(std::make_unique<ClothWorldSource>(world, i));
  return sources;
}

}  // namespace tremolo::python
