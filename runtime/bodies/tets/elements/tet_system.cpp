#include "runtime/bodies/tets/elements/tet_system.h"

#include <algorithm>
#include <array>
#include <utility>

#include "runtime/bodies/tets/elements/element_turn.h"
#include "runtime/bodies/tets/elements/tet_element.h"

namespace tremolo {
namespace {

Eigen::Index at_node(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

// Adds a block of row r and column c.
void add_to(NodeBlocks& blocks, std::size_t r, std::size_t c, const Eigen::Matrix3d& block) {
  if (r >= c)
    blocks[node_block(r, c)] += block;
  else
    blocks[node_block(c, r)] += block.transpose();
}

// B <- E^T B E for one quadratic element: rows and columns of linear edges' control points are
// added half and half to their ends. linear: one bit per edge. Condensed entries are undefined
// afterwards.
void fold_blocks(unsigned linear, NodeBlocks& b) {
  for (std::size_t e = 0; e < 6; ++e) {
    if ((linear >> e & 1U) == 0) continue;
    const std::size_t i = 4 + e;
    const std::array<std::size_t, 2> ends = {static_cast<std::size_t>(kTetEdges[e][0]),
                                             static_cast<std::size_t>(kTetEdges[e][1])};
    for (std::size_t j = 0; j < kMostNodes; ++j) {
      if (j == i || (j >= 4 && j < i && (linear >> (j - 4) & 1U) != 0)) continue;
      Eigen::Matrix3d half = 0.5 * b[j < i ? node_block(i, j) : node_block(j, i)];
      if (j > i) half.transposeInPlace();
      for (const std::size_t end : ends) {
        if (j == end)
          b[node_block(end, end)] += half + half.transpose();
        else
          add_to(b, end, j, half);
      }
    }
    const Eigen::Matrix3d quarter = 0.25 * b[node_block(i, i)];
    for (const std::size_t end : ends) b[node_block(end, end)] += quarter;
    add_to(b, ends[0], ends[1], quarter);
  }
}

}  // namespace

TetSystem::TetSystem(TetModelPointer model, RotationLaw law)
    : model_(std::move(model)),
      law_(law),
      degrees_(model_->edges(), 2),
      active_(model_->nodes()),
      linear_(model_->elements().size(), 0),
      shapes_(model_->elements().size()),
      evaluated_(Eigen::VectorXd::Zero(3 * model_->nodes())),
      sum_(static_cast<Eigen::Index>(3 * model_->nodes())) {
  set_degrees(std::vector<std::uint8_t>(model_->edges(), 2));
}

void TetSystem::set_degrees(std::span<const std::uint8_t> degrees) {
  has_shapes_ = false;
  std::copy(degrees.begin(), degrees.end(), degrees_.begin());
  const auto held = model_->held();
  for (std::size_t i = 0; i < active_.size(); ++i) active_[i] = held[i] == 0 ? 1 : 0;
  for (std::size_t e = 0; e < degrees_.size(); ++e)
    if (degrees_[e] < 2) active_[model_->vertices() + e] = 0;
  const auto elements = model_->elements();
  for (std::size_t e = 0; e < elements.size(); ++e) {
    linear_[e] = 0;
    for (std::size_t i = 4; i < kMostNodes; ++i)
      if (degrees_[elements[e].nodes[i] - model_->vertices()] < 2)
        linear_[e] = static_cast<std::uint8_t>(linear_[e] | 1U << (i - 4));
  }
}

double TetSystem::quadratic_share() const {
  const auto count = std::count(degrees_.begin(), degrees_.end(), std::uint8_t{2});
  return static_cast<double>(count) /
         static_cast<double>(std::max<std::size_t>(1, degrees_.size()));
}

void TetSystem::follow_ends(Eigen::VectorXd& x) const {
  for (std::size_t e = 0; e < degrees_.size(); ++e)
    if (degrees_[e] < 2) {
      const MeshEdge& edge = model_->edge(e);
      x.segment<3>(at_node(edge.point)) =
          0.5 * (x.segment<3>(at_node(edge.a)) + x.segment<3>(at_node(edge.b)));
    }
}

void TetSystem::fold(Eigen::VectorXd& y) const {
  for (std::size_t e = 0; e < degrees_.size(); ++e)
    if (degrees_[e] < 2) {
      const MeshEdge& edge = model_->edge(e);
      const Eigen::Vector3d half = 0.5 * y.segment<3>(at_node(edge.point));
      y.segment<3>(at_node(edge.a)) += half;
      y.segment<3>(at_node(edge.b)) += half;
      y.segment<3>(at_node(edge.point)).setZero();
    }
}

NodeVectors TetSystem::gather(const TetModelElement& element, const Eigen::VectorXd& x,
                              int nodes) const {
  NodeVectors local(3, nodes);
  for (int i = 0; i < nodes; ++i) local.col(i) = x.segment<3>(at_node(element.nodes[i]));
  return local;
}

void TetSystem::find_shape(std::size_t e, const Eigen::VectorXd& x) {
  const TetModelElement& element = model_->elements()[e];
  shapes_[e] = tet_shape(element.element, model_->elasticity(element), law_,
                         gather(element, x, straight(e) ? 4 : kMostNodes));
}

std::size_t TetSystem::evaluate(const Eigen::VectorXd& x) {
  if (has_shapes_ && x == evaluated_) return lost_;
  const auto elements = model_->elements();
  evaluated_ = x;
  has_shapes_ = true;
  lost_ = 0;
  std::array<LaneElement, kElementLanes> group;
  std::array<std::size_t, kElementLanes> members{};
  std::size_t count = 0;
  const auto flush = [&] {
    if (count == 0) return;
    const unsigned left = shapes_in_lanes(group.data(), count);
    for (std::size_t k = 0; k < count; ++k)
      if ((left >> k & 1U) != 0) find_shape(members[k], x);
    count = 0;
  };
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const TetModelElement& element = elements[e];
    const Elasticity& elasticity = model_->elasticity(element);
    if (straight(e) || law_ != RotationLaw::kLeastEnergy || !elasticity.isotropic) {
      find_shape(e, x);
      continue;
    }
    LaneElement& lane = group[count];
    lane = {&element.element, &elasticity, {}, &shapes_[e]};
    for (std::size_t i = 0; i < kMostNodes; ++i)
      lane.nodes[i] = x.data() + at_node(element.nodes[i]);
    members[count++] = e;
    if (count == kElementLanes) flush();
  }
  flush();
  for (const TetShape& shape : shapes_)
    if (!shape.converged) ++lost_;
  return lost_;
}

Eigen::Matrix3d TetSystem::mean_rotation() const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t e = 0; e < shapes_.size(); ++e)
    sum += model_->elements()[e].element.geometry.volume * shapes_[e].rotation;
  return nearest_rotation(sum);
}

std::size_t TetSystem::inverted() const {
  // Gradients are linear in the position: each corner's is its sample's less `far` times their sum,
  // up to a positive factor.
  const auto points = sample_points(2, 2);
  const double far = std::min(points[0].lambda[0], points[0].lambda[1]);
  std::size_t count = 0;
  for (const TetShape& shape : shapes_) {
    Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
    if (shape.samples > 1)
      for (const Eigen::Matrix3d& seen : shape.seen) all += far * seen;
    bool flat = false;
    for (std::size_t s = 0; s < static_cast<std::size_t>(shape.samples); ++s)
      flat = flat || !((shape.seen[s] - all).determinant() > 0.0);
    count += flat ? 1 : 0;
  }
  return count;
}

double TetSystem::energy() const {
  double sum = 0.0;
  for (std::size_t e = 0; e < shapes_.size(); ++e)
    sum += tet_energy(model_->elements()[e].element, shapes_[e]);
  return sum;
}

// Converts a linear element's forces to those of the equivalent quadratic one, which condense back
// to them.
void TetSystem::scatter(const TetModelElement& element, const NodeVectors& force,
                        Eigen::VectorXd& f) const {
  const auto at = [&](std::size_t i) { return f.segment<3>(at_node(element.nodes[i])); };
  if (force.cols() == kMostNodes) {
    for (std::size_t i = 0; i < kMostNodes; ++i) at(i) += force.col(i);
    return;
  }
  for (std::size_t a = 0; a < 4; ++a) at(a) += 0.5 * force.col(a);
  for (std::size_t e = 0; e < 6; ++e)
    at(4 + e) += 0.5 * (force.col(kTetEdges[e][0]) + force.col(kTetEdges[e][1]));
}

void TetSystem::add_force(Eigen::VectorXd& f) const {
  for (std::size_t e = 0; e < shapes_.size(); ++e) {
    const TetModelElement& element = model_->elements()[e];
    scatter(element, -tet_force(element.element, shapes_[e]), f);
  }
}

void TetSystem::add_damping_force(const Eigen::VectorXd& v, double beta, Eigen::VectorXd& f) const {
  for (std::size_t e = 0; e < shapes_.size(); ++e) {
    const TetModelElement& element = model_->elements()[e];
    const NodeVectors local = gather(element, v, straight(e) ? 4 : kMostNodes);
    scatter(element,
            -beta * tet_damping_force(element.element, model_->elasticity(element), law_,
                                      shapes_[e], local),
            f);
  }
}

void TetSystem::assemble(const TetMatrixFactors& factors, BlockMatrix& a) const {
  std::array<std::array<double, kMostBlocks>, 2> shares;  // of the mass, by order
  for (const int order : {1, 2})
    for (int i = 0; i < nodes_of_order(order); ++i)
      for (int j = 0; j <= i; ++j) shares[order - 1][node_block(i, j)] = mass_share(order, i, j);
  a.set_zero();
  const bool of_mass_alone = factors.tangent.position == 0.0 && factors.tangent.velocity == 0.0;
  NodeBlocks blocks;
  for (std::size_t e = 0; e < shapes_.size(); ++e) {
    const TetModelElement& element = model_->elements()[e];
    const int order = straight(e) ? 1 : 2;
    const std::span<const Eigen::Matrix3d> stiffness =
        order == 1 ? std::span<const Eigen::Matrix3d>(element.linear_stiffness)
                   : std::span<const Eigen::Matrix3d>(element.stiffness);
    if (of_mass_alone)
      blocks.fill(Eigen::Matrix3d::Zero());
    else
      tet_tangent(element.element, model_->elasticity(element), law_, shapes_[e], stiffness,
                  factors.tangent, blocks);
    const std::size_t nodes = nodes_of_order(order);
    const auto& share = shares[order - 1];
    for (std::size_t k = 0; k < node_block(nodes, 0); ++k)
      blocks[k].diagonal().array() += factors.mass * element.element.mass * share[k];
    const unsigned folded = order == 1 ? 0U : linear_[e];
    if (folded != 0) fold_blocks(folded, blocks);
    for (std::size_t i = 0; i < nodes; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        if (((folded << 4U >> i | folded << 4U >> j) & 1U) != 0) continue;
        const BlockPlace place = element.places[node_block(i, j)];
        if (place.turned)
          a.block(place.place) += blocks[node_block(i, j)].transpose();
        else
          a.block(place.place) += blocks[node_block(i, j)];
      }
  }
}

void TetSystem::assemble(const TetMatrixFactors& factors, const FloatTarget& target) const {
  const bool turned =
      factors.tangent.kind == TangentKind::kFrozen || law_ != RotationLaw::kLeastEnergy;
  const double both = factors.tangent.position + factors.tangent.velocity;
  FloatParts parts;
  for (std::size_t e = 0; e < shapes_.size(); ++e) {
    const TetModelElement& element = model_->elements()[e];
    const TetShape& shape = shapes_[e];
    const FloatElement adding{element.places.data(), linear_[e]};
    const double mass = factors.mass * element.element.mass;
    const float* stiffness = model_->float_stiffness(e);
    if (turned) add_turned(adding, stiffness, shape.rotation, both, mass, target);
    if (turned) continue;
    find_float_parts(element.element, model_->elasticity(element), shape, factors.tangent, parts);
    add_exact(adding, stiffness, shape.rotation, both, mass, parts, target);
  }
}

void TetSystem::fold_point(std::span<const std::uint32_t> nodes, std::span<double> shares) const {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < model_->vertices() || degrees_[nodes[i] - model_->vertices()] > 1) continue;
    const MeshEdge& edge = model_->edge(nodes[i] - model_->vertices());
    for (const VertexId end : {edge.a, edge.b}) {
      const auto found = std::find(nodes.begin(), nodes.end(), static_cast<std::uint32_t>(end));
      shares[found - nodes.begin()] += 0.5 * shares[i];
    }
    shares[i] = 0.0;
  }
}

void TetSystem::mass_times_folded(Eigen::VectorXd& y) const {
  model_->mass_times(y, sum_);
  fold(sum_);
  y = sum_;
}

Eigen::Vector3d TetSystem::momentum(const Eigen::VectorXd& v) const {
  model_->mass_times(v, sum_);
  return sum_.reshaped<Eigen::ColMajor>(3, sum_.size() / 3).rowwise().sum();
}

Eigen::Vector3d TetSystem::angular_momentum(const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& v) const {
  model_->mass_times(v, sum_);
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < model_->nodes(); ++i)
    total += x.segment<3>(at_node(i)).cross(sum_.segment<3>(at_node(i)));
  return total;
}

double TetSystem::kinetic_energy(const Eigen::VectorXd& v) const {
  model_->mass_times(v, sum_);
  return 0.5 * v.dot(sum_);
}

void TetSystem::carry(StateStream& stream) {
  std::vector<std::uint8_t> degrees = degrees_;
  bool has_shapes = has_shapes_;
  stream(degrees, has_shapes);
  for (const std::uint8_t degree : degrees) stream.require(degree == 1 || degree == 2);
  if (!stream.good()) return;
  if (stream.reads()) set_degrees(degrees);
  stream(evaluated_);
  for (std::size_t e = 0; e < shapes_.size() && stream.good(); ++e) {
    TetShape& shape = shapes_[e];
    if (has_shapes)
      stream(shape);
    else
      stream(shape.rotation);
    if (!stream.reads()) continue;
    stream.require(shape.rotation.allFinite());
    if (has_shapes)
      stream.require(straight(e) ? shape.order == 1 && shape.samples == 1
                                 : shape.order == 2 && shape.samples == 4);
  }
  if (!stream.reads()) return;
  has_shapes_ = has_shapes && stream.good();
  lost_ = static_cast<std::size_t>(std::count_if(
      shapes_.begin(), shapes_.end(), [](const TetShape& shape) { return !shape.converged; }));
}

std::size_t TetSystem::bytes() const {
  return shapes_.size() * sizeof(TetShape) + static_cast<std::size_t>(sum_.size()) * 16 +
         3 * active_.size();
}

}  // namespace tremolo
