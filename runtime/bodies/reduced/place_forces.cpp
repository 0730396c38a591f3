#include "runtime/place_forces.h"

#include <algorithm>
#include <optional>

namespace tremolo {
namespace {

// The number by which the model's default load is multiplied in `load`.
std::optional<double> share_of_default(const DefaultLoad& own, const DefaultLoad& load) {
  if (own.vertices.empty() || load.vertices != own.vertices) return std::nullopt;
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < own.forces.size(); ++i) {
    product += own.forces[i].dot(load.forces[i]);
    square += own.forces[i].squaredNorm();
  }
  if (!(square > 0.0)) return std::nullopt;
  const double share = product / square;
  // Rounding error of a multiplied force.
  constexpr double kSame = 1e-12;
  for (std::size_t i = 0; i < own.forces.size(); ++i)
    if ((load.forces[i] - share * own.forces[i]).norm() >
        kSame * std::abs(share) * std::sqrt(square))
      return std::nullopt;
  return share;
}

}  // namespace

PlaceForces::PlaceForces(std::size_t places)
    : now_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(places))) {}

void PlaceForces::add(const Signal& signal, Eigen::Index place, const Eigen::Vector3d& force,
                      int steps) {
  forces_.push_back({signal, place, force, steps});
}

void PlaceForces::add(const Signal& signal, const Model& model, const DefaultLoad& load,
                      int steps) {
  if (none()) return;
  if (const auto place = model.response_place(kAtDefaultLoad))
    if (const auto share = share_of_default(model.default_load(), load)) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& force : model.default_load().forces) sum += *share * force;
      return add(signal, *place, sum, steps);
    }
  for (std::size_t i = 0; i < load.vertices.size(); ++i)
    if (const auto place = model.response_place(load.vertices[i]))
      add(signal, *place, load.forces[i], steps);
}

Eigen::VectorXd place_forces_of(const Model& model, const DefaultLoad& load) {
  PlaceForces forces(model.response_places().size());
  forces.add(Signal{}, model, load, 1);
  forces.end_step(0.0, 1.0, [](Eigen::Index) { return Eigen::Matrix3d::Identity(); });
  return forces.now();
}

void PlaceForces::clear() {
  forces_.clear();
}

void PlaceForces::clear_applied() {
  std::erase_if(forces_, [](const Force& force) { return force.steps > 0; });
}

void PlaceForces::carry(StateStream& stream) {
  if (none()) return;
  stream(now_);
  std::vector<Force> applied;
  for (const Force& force : forces_)
    if (force.steps > 0) applied.push_back(force);
  std::size_t count = applied.size();
  stream(count);
  stream.require(!stream.reads() || count <= stream.left() / sizeof(double));
  if (!stream.good()) return;
  applied.resize(count);
  for (Force& force : applied) {
    stream(force.place, force.force, force.steps);
    stream.require(force.place >= 0 && 3 * force.place < now_.size() && force.force.allFinite() &&
                   force.steps > 0);
  }
  stream.require(now_.allFinite());
  if (!stream.reads()) return;
  clear_applied();
  if (stream.good()) forces_.insert(forces_.end(), applied.begin(), applied.end());
}

}  // namespace tremolo
