#include "runtime/bodies/cloth/cloth_model.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/packed_index.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Status check_springs(const ClothSprings& springs, const char* kind, std::size_t particles) {
  const std::string name(kind);
  for (const double value : {springs.law.stiffness, springs.law.damping})
    if (!(value >= 0.0) || !std::isfinite(value))
      return content_error(name + ": stiffness and damping must be finite and not negative");
  if (springs.rest.size() != springs.pairs.size())
    return content_error(name + ": each spring needs a rest length");
  for (const auto& [a, b] : springs.pairs)
    if (a >= particles || b >= particles || a == b)
      return content_error(name + ": a spring joins particles " + std::to_string(a) + " and " +
                           std::to_string(b) + " of " + std::to_string(particles));
  for (const double rest : springs.rest)
    if (!(rest > 0.0) || !std::isfinite(rest))
      return content_error(name + ": a rest length must be positive and finite (m)");
  return Success{};
}

Status check_parts(const ClothParts& parts) {
  const std::size_t n = parts.mass.size();
  if (n == 0) return content_error("the cloth has no particle");
  if (parts.x.size() != 3 * parts.mass.size())
    return content_error("each particle needs a place and a mass");
  if (!parts.x.allFinite()) return content_error("a particle's place is not finite");
  for (std::size_t i = 0; i < n; ++i)
    if (const double m = parts.mass[i]; !(m > 0.0) || !std::isfinite(m))
      return content_error("the mass of particle " + std::to_string(i) +
                           " must be positive and finite (kg)");
  for (const Triangle& t : parts.triangles)
    for (const VertexId corner : t)
      if (!is_index(corner, n)) return content_error("a triangle has a corner that is no particle");
  if (!(parts.drag >= 0.0) || !std::isfinite(parts.drag))
    return content_error("drag must be finite and not negative (kg/m^3)");
  if (Status s = check_springs(parts.structural, "structural", n); !s) return s;
  if (Status s = check_springs(parts.shear, "shear", n); !s) return s;
  return check_springs(parts.bend, "bend", n);
}

}  // namespace

ClothModel::ClothModel(ClothParts parts)
    : parts_(std::move(parts)),
      structural_(parts_.structural),
      shear_(parts_.shear),
      bend_(parts_.bend),
      drag_(parts_.triangles, parts_.drag),
      held_(static_cast<std::size_t>(parts_.mass.size()), 0) {}

Result<ClothModel> ClothModel::create(ClothParts parts) {
  if (Status s = check_parts(parts); !s) return s.error();
  ClothModel model(std::move(parts));
  std::vector<NodePair> pairs;
  const ClothParts& known = model.parts_;
  for (const auto& [springs, set] :
       {std::pair{&known.structural, &model.structural_}, std::pair{&known.shear, &model.shear_},
        std::pair{&known.bend, &model.bend_}})
    if (set->size() > 0) pairs.insert(pairs.end(), springs->pairs.begin(), springs->pairs.end());
  if (model.drag_.blows())
    for (const Triangle& t : known.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        pairs.emplace_back(static_cast<std::uint32_t>(t[k]),
                           static_cast<std::uint32_t>(t[(k + 1) % 3]));
  if (Status s = take(model.pattern_, BlockPattern::create(model.size(), pairs)); !s)
    return s.error();
  for (SpringSet* set : {&model.structural_, &model.shear_, &model.bend_})
    set->find_places(*model.pattern_);
  model.drag_.find_places(*model.pattern_);
  model.hands_.reserve(16);
  return model;
}

Status ClothModel::pin(std::span<const std::size_t> particles, MotionPath path, double until) {
  for (const std::size_t particle : particles)
    if (particle >= size())
      return content_error("a pin holds particle " + std::to_string(particle) + ", but there are " +
                           std::to_string(size()));
  pins_.push_back({{particles.begin(), particles.end()}, std::move(path), until, true});
  count_holds();
  return Success{};
}

bool ClothModel::release_pins(double time) {
  bool any = false;
  for (Pin& pin : pins_)
    if (pin.active && pin.until <= time) {
      pin.active = false;
      any = true;
    }
  if (any) count_holds();
  return any;
}

bool ClothModel::pins_stay() const {
  return std::all_of(pins_.begin(), pins_.end(), [](const Pin& pin) {
    return !pin.active || (pin.path.still() && pin.until == kForEver);
  });
}

void ClothModel::carry(StateStream& stream) {
  for (Pin& pin : pins_) stream(pin.active);
  stream(gravity_, wind_);
  if (!stream.reads()) return;
  stream.require(gravity_.allFinite() && wind_.allFinite());
  ++potential_version_;
  count_holds();
}

void ClothModel::hold(std::size_t particle, const Vector3d& at) {
  const auto same = [particle](const Hand& hand) { return hand.particle == particle; };
  if (const auto known = std::find_if(hands_.begin(), hands_.end(), same); known != hands_.end())
    known->at = at;
  else
    hands_.push_back({.particle = particle, .at = at, .from = at});
  held_[particle] = 1;
}

void ClothModel::begin_holds(double time, double h, const Eigen::VectorXd& x) {
  for (Hand& hand : hands_) {
    hand.from = x.segment<3>(3 * static_cast<Eigen::Index>(hand.particle));
    hand.begun = time;
    hand.length = h;
  }
}

Vector3d ClothModel::Hand::place(double time) const {
  const double gone = time - begun;
  // Because of rounding the sum of a step's parts may end slightly before it.
  if (gone >= (1.0 - kSameTime) * length) return at;
  return from + std::max(0.0, gone / length) * (at - from);
}

bool ClothModel::let_go(std::size_t particle) {
  const auto gone = std::remove_if(hands_.begin(), hands_.end(), [particle](const Hand& hand) {
    return hand.particle == particle;
  });
  if (gone == hands_.end()) return false;
  hands_.erase(gone, hands_.end());
  count_holds();
  return true;
}

void ClothModel::count_holds() {
  std::fill(held_.begin(), held_.end(), std::uint8_t{0});
  for (const Pin& pin : pins_)
    if (pin.active)
      for (const std::size_t particle : pin.particles) held_[particle] = 1;
  for (const Hand& hand : hands_) held_[hand.particle] = 1;
}

double ClothModel::load_size() const {
  double size = parts_.mass.norm() * gravity_.norm();
  // Without weight: the force that stretches the springs by a thousandth.
  for (const ClothSprings* springs : {&parts_.structural, &parts_.shear, &parts_.bend})
    if (size == 0.0 && !springs->rest.empty())
      size = 1e-3 * springs->law.stiffness * springs->rest.front() *
             std::sqrt(static_cast<double>(springs->rest.size()));
  return size > 0.0 ? size : parts_.mass.norm();
}

void ClothModel::put_held(double time, Eigen::VectorXd& x) const {
  for (const Pin& pin : pins_) {
    if (!pin.active) continue;
    const bool still = pin.path.still();
    const Pose pose = still ? Pose{} : pin.path.pose(time);
    for (const std::size_t particle : pin.particles) {
      const auto at = 3 * static_cast<Eigen::Index>(particle);
      const Vector3d rest = parts_.x.segment<3>(at);
      x.segment<3>(at) = still ? rest : pose * rest;
    }
  }
  for (const Hand& hand : hands_)
    x.segment<3>(3 * static_cast<Eigen::Index>(hand.particle)) = hand.place(time);
}

void ClothModel::force(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                       Eigen::VectorXd& f) const {
  f.setZero();
  if (part != ForcePart::kSoft) structural_.add_force(x, v, f);
  if (part == ForcePart::kStiff) return;
  shear_.add_force(x, v, f);
  bend_.add_force(x, v, f);
  drag_.add_force(wind_, x, v, f);
  for (Eigen::Index i = 0; i < parts_.mass.size(); ++i)
    f.segment<3>(3 * i) += parts_.mass[i] * gravity_;
}

void ClothModel::add_tangent(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                             double position, double velocity, double share, BlockMatrix& a) const {
  const SpringWeights weights{position, velocity, share};
  constexpr std::uint32_t kTogether = 64;  // particles
  const bool stiff = part != ForcePart::kSoft, soft = part != ForcePart::kStiff;
  std::size_t structural = 0, shear = 0, bend = 0;
  for (std::uint32_t first = 0; first < size(); first += kTogether) {
    const std::uint32_t end = first + kTogether;
    if (stiff) structural = structural_.add_tangent({structural, end}, x, v, weights, a);
    if (soft) shear = shear_.add_tangent({shear, end}, x, v, weights, a);
    if (soft) bend = bend_.add_tangent({bend, end}, x, v, weights, a);
  }
  if (soft) drag_.add_tangent(wind_, x, v, weights.velocity, a);
}

double ClothModel::elastic_energy(const Eigen::VectorXd& x) const {
  return structural_.energy(x) + shear_.energy(x) + bend_.energy(x);
}

double ClothModel::potential(const Eigen::VectorXd& x) const {
  double fall = 0.0;
  for (Eigen::Index i = 0; i < parts_.mass.size(); ++i)
    fall += parts_.mass[i] * gravity_.dot(x.segment<3>(3 * i));
  return elastic_energy(x) - fall;
}

StepWork ClothModel::power(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const {
  StepWork work = drag_.power(wind_, x, v);
  work.damped +=
      structural_.damping_power(x, v) + shear_.damping_power(x, v) + bend_.damping_power(x, v);
  return work;
}

StepWork ClothModel::step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                Eigen::VectorXd& f) const {
  f.setZero();
  StepWork work = drag_.add_step_force(wind_, x0, x1, h, f);
  for (const SpringSet* set : {&structural_, &shear_, &bend_})
    work.damped += set->add_step_force(x0, x1, h, f);
  for (Eigen::Index i = 0; i < parts_.mass.size(); ++i)
    f.segment<3>(3 * i) += parts_.mass[i] * gravity_;
  return work;
}

void ClothModel::add_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                  double share, BlockMatrix& a) const {
  for (const SpringSet* set : {&structural_, &shear_, &bend_})
    set->add_step_tangent(x0, x1, h, share, a);
  drag_.add_step_tangent(wind_, x0, x1, h, a);
}

void ClothModel::add_missing_product(const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                                     double position, const Eigen::VectorXd& u,
                                     Eigen::VectorXd& y) const {
  for (const SpringSet* set : {&structural_, &shear_, &bend_})
    set->add_missing_product(x, v, position, u, y);
}

void ClothModel::add_missing_step_product(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1,
                                          double h, const Eigen::VectorXd& u,
                                          Eigen::VectorXd& y) const {
  for (const SpringSet* set : {&structural_, &shear_, &bend_})
    set->add_missing_step_product(x0, x1, h, u, y);
}

}  // namespace tremolo
