#include "runtime/bodies/tets/solve/mass_projection.h"

#include <algorithm>
#include <cmath>

#include "common/processor.h"

namespace tremolo {
namespace {

using std::size_t;

typedef float Lanes __attribute__((vector_size(64), may_alias));
typedef double HalfLanes __attribute__((vector_size(64)));
typedef float HalfFloats __attribute__((vector_size(32)));

constexpr double kProjectionTolerance = 1e-6;  // of E^T M rest
constexpr int kMostProjectionSteps = 60;

[[gnu::always_inline]] inline Lanes& lanes_at(float* list, size_t node) {
  return *reinterpret_cast<Lanes*>(list + MassProjection::kMassLanes * node);
}

// Data for products with the mass matrix. linear: edges; a, b: ends of each edge.
struct MassRows {
  size_t nodes;
  const std::uint32_t *first, *column;
  const float* masses;
  const std::uint32_t* linear;
  size_t linears;
  const MeshEdge* edges;
  const float* inverse;
};

[[gnu::always_inline]] inline void follow_lanes(const MassRows& g, float* p) {
  for (size_t k = 0; k < g.linears; ++k) {
    const MeshEdge& edge = g.edges[g.linear[k]];
    lanes_at(p, static_cast<size_t>(edge.point)) =
        0.5F *
        (lanes_at(p, static_cast<size_t>(edge.a)) + lanes_at(p, static_cast<size_t>(edge.b)));
  }
}

// q = E^T M p for a p whose linear edges follow already.
[[gnu::always_inline]] inline void mass_lanes(const MassRows& g, float* p, float* q) {
  for (size_t i = 0; i < g.nodes; ++i) {
    const Lanes own = lanes_at(p, i);
    const size_t last = g.first[i + 1] - 1;
    Lanes sum = g.masses[last] * own;
    for (size_t k = g.first[i]; k < last; ++k) {
      sum += g.masses[k] * lanes_at(p, g.column[k]);
      lanes_at(q, g.column[k]) += g.masses[k] * own;
    }
    lanes_at(q, i) = sum;
  }
  for (size_t k = 0; k < g.linears; ++k) {
    const MeshEdge& edge = g.edges[g.linear[k]];
    const Lanes half = 0.5F * lanes_at(q, static_cast<size_t>(edge.point));
    lanes_at(q, static_cast<size_t>(edge.a)) += half;
    lanes_at(q, static_cast<size_t>(edge.b)) += half;
  }
  for (size_t i = 0; i < g.nodes; ++i)
    if (g.inverse[i] == 0.0F) lanes_at(q, i) = Lanes{};
}

TREMOLO_CLONES
void multiply_masses(const MassRows& g, float* p, float* q) {
  follow_lanes(g, p);
  mass_lanes(g, p, q);
}

TREMOLO_CLONES
void first_product(const MassRows& g, float* p, float* q) {
  mass_lanes(g, p, q);
}

// Sums over the nodes of a.b, and of a.D^-1 b, lane by lane.
TREMOLO_CLONES
void lane_products(const MassRows& g, float* a, float* b, bool scaled, double* sums) {
  HalfLanes low = {}, high = {};
  for (size_t i = 0; i < g.nodes; ++i) {
    Lanes product = lanes_at(a, i) * lanes_at(b, i);
    if (scaled) product *= g.inverse[i];
    HalfFloats halves[2];
    __builtin_memcpy(halves, &product, sizeof(product));
    low += __builtin_convertvector(halves[0], HalfLanes);
    high += __builtin_convertvector(halves[1], HalfLanes);
  }
  for (size_t k = 0; k < 8; ++k) {
    sums[k] = low[k];
    sums[8 + k] = high[k];
  }
}

// x += length p, r -= length q.
TREMOLO_CLONES
void advance_lanes(const MassRows& g, const float* lengths, float* p, float* q, float* x,
                   float* r) {
  Lanes length;
  __builtin_memcpy(&length, lengths, sizeof(length));
  for (size_t i = 0; i < g.nodes; ++i) {
    lanes_at(x, i) += length * lanes_at(p, i);
    lanes_at(r, i) -= length * lanes_at(q, i);
  }
}

// p = D^-1 r + share p.
TREMOLO_CLONES
void turn_lanes(const MassRows& g, const float* shares, float* r, float* p) {
  Lanes share;
  __builtin_memcpy(&share, shares, sizeof(share));
  for (size_t i = 0; i < g.nodes; ++i)
    lanes_at(p, i) = g.inverse[i] * lanes_at(r, i) + share * lanes_at(p, i);
}

Eigen::Index mass_at(size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

MassRows mass_rows(const TetModel& model, const std::vector<float>& masses,
                   const std::vector<std::uint32_t>& linear, const AlignedFloats& inverse) {
  const BlockPattern& pattern = *model.pattern();
  return {pattern.size(), pattern.first().data(), pattern.columns().data(), masses.data(),
          linear.data(),  linear.size(),          &model.edge(0),           inverse.data()};
}

}  // namespace

MassProjection::MassProjection(const TetModel& model)
    : masses_(model.masses().begin(), model.masses().end()), inverse_(model.nodes(), 0.0F) {
  linear_.reserve(model.edges());
  for (AlignedFloats* list : {&x_, &r_, &p_, &q_}) list->assign(kMassLanes * model.nodes(), 0.0F);
  const Eigen::Index size = mass_at(model.nodes());
  rest_.setZero(size);
  weight_.setZero(size);
  model.mass_times(Eigen::VectorXd::Ones(size), weight_);
}

// Lists the linear edges; computes one over the sums of the rows of E^T M E, which are E^T M 1.
void MassProjection::choose(const TetSystem& system) {
  const TetModel& model = system.model();
  linear_.clear();
  for (size_t e = 0; e < model.edges(); ++e)
    if (system.degrees()[e] < 2) linear_.push_back(static_cast<std::uint32_t>(e));
  rest_ = weight_;
  system.fold(rest_);
  for (size_t i = 0; i < model.nodes(); ++i)
    inverse_[i] = system.active()[i] == 0 ? 0.0F : static_cast<float>(1.0 / rest_[mass_at(i)]);
}

// Sets p to the rests, each vector divided by its largest entry; the vectors then follow their
// ends.
void MassProjection::take_rests(const TetSystem& system,
                                std::span<Eigen::VectorXd* const> vectors) {
  const size_t nodes = system.model().nodes();
  std::fill(p_.begin(), p_.end(), 0.0F);
  scale_.fill(0.0);
  for (size_t v = 0; v < vectors.size(); ++v) {
    Eigen::VectorXd& y = *vectors[v];
    rest_ = y;
    system.follow_ends(y);
    rest_ -= y;
    const double largest = rest_.cwiseAbs().maxCoeff();
    if (!(largest > 0.0) || !std::isfinite(largest)) continue;
    scale_[v] = largest;
    for (size_t i = 0; i < nodes; ++i)
      for (size_t k = 0; k < 3; ++k)
        p_[kMassLanes * i + 3 * v + k] =
            static_cast<float>(rest_[mass_at(i) + static_cast<Eigen::Index>(k)] / largest);
  }
}

// Conjugate gradients for E^T M E x = r, each lane separately.
int MassProjection::search(const TetSystem& system) {
  const MassRows g = mass_rows(system.model(), masses_, linear_, inverse_);
  // One E^T M rest, whose linear edges do not follow.
  first_product(g, p_.data(), r_.data());
  std::fill(x_.begin(), x_.end(), 0.0F);
  std::fill(p_.begin(), p_.end(), 0.0F);
  std::array<float, kMassLanes> lengths{}, shares{};
  std::array<double, kMassLanes> product{}, along{}, first{};
  lane_products(g, r_.data(), r_.data(), true, product.data());
  first = product;
  int steps = 0;
  for (; steps < kMostProjectionSteps; ++steps) {
    bool more = false;
    for (size_t k = 0; k < kMassLanes; ++k)
      more = more || product[k] > kProjectionTolerance * kProjectionTolerance * first[k];
    if (!more) break;
    turn_lanes(g, shares.data(), r_.data(), p_.data());
    multiply_masses(g, p_.data(), q_.data());
    lane_products(g, p_.data(), q_.data(), false, along.data());
    for (size_t k = 0; k < kMassLanes; ++k)
      lengths[k] = along[k] > 0.0 ? static_cast<float>(product[k] / along[k]) : 0.0F;
    advance_lanes(g, lengths.data(), p_.data(), q_.data(), x_.data(), r_.data());
    const std::array<double, kMassLanes> before = product;
    lane_products(g, r_.data(), r_.data(), true, product.data());
    for (size_t k = 0; k < kMassLanes; ++k)
      shares[k] = before[k] > 0.0 ? static_cast<float>(product[k] / before[k]) : 0.0F;
  }
  return steps;
}

int MassProjection::project(const TetSystem& system, std::span<Eigen::VectorXd* const> vectors,
                            bool keep_sums) {
  const TetModel& model = system.model();
  const size_t nodes = model.nodes();
  const auto sum_of = [&](const Eigen::VectorXd& y) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < nodes; ++i) sum += weight_[mass_at(i)] * y.segment<3>(mass_at(i));
    return sum;
  };
  std::array<Eigen::Vector3d, kMostVectors> sums;
  for (size_t v = 0; v < vectors.size(); ++v) sums[v] = sum_of(*vectors[v]);
  choose(system);
  take_rests(system, vectors);
  if (std::all_of(scale_.begin(), scale_.end(), [](double s) { return s == 0.0; })) return 0;
  const int steps = search(system);
  for (size_t v = 0; v < vectors.size(); ++v) {
    if (scale_[v] == 0.0) continue;
    Eigen::VectorXd& y = *vectors[v];
    for (size_t i = 0; i < nodes; ++i)
      for (size_t k = 0; k < 3; ++k)
        y[mass_at(i) + static_cast<Eigen::Index>(k)] +=
            scale_[v] * static_cast<double>(x_[kMassLanes * i + 3 * v + k]);
    system.follow_ends(y);
    if (!keep_sums) continue;
    const Eigen::Vector3d lost = (sums[v] - sum_of(y)) / model.mass();
    for (size_t i = 0; i < nodes; ++i) y.segment<3>(mass_at(i)) += lost;
  }
  return steps;
}

size_t MassProjection::bytes() const {
  return (masses_.size() + inverse_.size() + 4 * x_.size()) * sizeof(float) +
         linear_.capacity() * sizeof(std::uint32_t) +
         static_cast<size_t>(rest_.size() + weight_.size()) * sizeof(double);
}

}  // namespace tremolo
