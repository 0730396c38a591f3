#include "runtime/bodies/tets/contact/tet_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/LU>

#include "common/mesh/median_split.h"

namespace tremolo {
namespace {

constexpr int kMostInverseSteps = 12;
// Newton's error squares: it is below rounding after a step of this size.
constexpr double kLastInverseStep = 1e-8;
constexpr double kNearInverse = 0.25;

Eigen::Vector3d node_place(const TetModelElement& element, std::size_t node,
                           const Eigen::VectorXd& x) {
  return x.segment<3>(3 * Eigen::Index{element.nodes[node]});
}

// sum_I B_I x_I and the deformation gradient at w.
void place_of(const TetModelElement& element, const Eigen::Matrix<double, 3, kMostNodes>& x,
              const Eigen::Vector4d& w, Eigen::Vector3d& place, Eigen::Matrix3d& gradient) {
  Eigen::Matrix<double, 3, 4> slopes;
  for (int b = 0; b < 4; ++b) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int a = 0; a < 4; ++a) sum += w[a] * x.col(kNodeAt[a][b]);
    slopes.col(b) = sum;
  }
  place = slopes * w;
  gradient = 2.0 * slopes * element.element.geometry.gradients.transpose();
}

}  // namespace

TetTree::TetTree(TetModelPointer model) : model_(std::move(model)) {
  const std::size_t count = model_->elements().size();
  for (const TetModelElement& element : model_->elements()) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t a = 0; a < 4; ++a) middle += 0.25 * node_place(element, a, model_->rest());
    middles_.push_back(middle);
  }
  std::vector<std::uint32_t> elements(count);
  std::iota(elements.begin(), elements.end(), 0U);
  items_.reserve(2 * count);
  split(elements);
  middles_.clear();
  middles_.shrink_to_fit();
  find_around();
}

void TetTree::find_around() {
  firsts_.assign(model_->vertices() + 1, 0);
  for (const TetModelElement& element : model_->elements())
    for (std::size_t a = 0; a < 4; ++a) ++firsts_[element.nodes[a] + 1];
  std::partial_sum(firsts_.begin(), firsts_.end(), firsts_.begin());
  around_.resize(firsts_.back());
  std::vector<std::uint32_t> next(firsts_.begin(), firsts_.end() - 1);
  for (std::uint32_t e = 0; e < model_->elements().size(); ++e)
    for (std::size_t a = 0; a < 4; ++a) around_[next[model_->elements()[e].nodes[a]]++] = e;
}

void TetTree::split(std::span<std::uint32_t> elements) {
  const std::size_t at = items_.size();
  items_.push_back({0, elements.front(), elements.size() == 1});
  if (elements.size() == 1) return;
  const std::size_t half =
      split_at_median(elements, [this](std::uint32_t element) { return middles_[element]; });
  split(elements.first(half));
  items_[at].second = static_cast<std::uint32_t>(items_.size());
  split(elements.subspan(half));
}

void TetTree::fit(const Eigen::VectorXd& x, std::vector<Box>& boxes) const {
  for (std::size_t i = items_.size(); i-- > 0;) {
    if (!items_[i].leaf) {
      boxes[i] = boxes[i + 1].merged(boxes[items_[i].second]);
      continue;
    }
    const TetModelElement& element = model_->elements()[items_[i].element];
    Box box;
    for (std::size_t node = 0; node < kMostNodes; ++node) box.extend(node_place(element, node, x));
    const Eigen::Vector3d margin = kOutsideShare * box.sizes();
    boxes[i] = Box(box.min() - margin, box.max() + margin);
  }
}

std::optional<TetPlace> TetTree::solve(std::uint32_t index, const Eigen::VectorXd& x,
                                       const Eigen::Vector3d& place, double least) const {
  const TetModelElement& element = model_->elements()[index];
  Eigen::Matrix<double, 3, kMostNodes> nodes;
  for (std::size_t i = 0; i < kMostNodes; ++i) nodes.col(i) = node_place(element, i, x);
  TetPlace found;
  found.element = index;
  found.weights.setConstant(0.25);
  Eigen::Vector3d reached;
  for (int step = 0; step < kMostInverseSteps; ++step) {
    place_of(element, nodes, found.weights, reached, found.gradient);
    const double determinant = found.gradient.determinant();
    if (!(determinant > 0.0)) return std::nullopt;
    const Eigen::Vector4d change = element.element.geometry.gradients.transpose() *
                                   (found.gradient.inverse() * (place - reached));
    found.weights += change;
    const double length = change.cwiseAbs().maxCoeff();
    // The curvature of an element moves the solution by less than the element's size.
    if (!(length < 1e3) || (step > 1 && found.weights.minCoeff() < -1.0)) return std::nullopt;
    // Newton's error squares: the remaining change is less than this one.
    if (step > 0 && length < kNearInverse && found.weights.minCoeff() < least - 2.0 * length)
      return std::nullopt;
    if (length > kLastInverseStep) continue;
    place_of(element, nodes, found.weights, reached, found.gradient);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b <= a; ++b)
        found.values[kNodeAt[a][b]] = (a == b ? 1.0 : 2.0) * found.weights[a] * found.weights[b];
    return found;
  }
  return std::nullopt;
}

std::optional<TetPlace> TetTree::find(const Eigen::VectorXd& x, const std::vector<Box>& boxes,
                                      const Eigen::Vector3d& place) const {
  std::optional<TetPlace> best;
  double depth = -kOutsideShare;
  std::array<std::uint32_t, 64> waiting;
  std::size_t count = 1;
  waiting[0] = 0;
  while (count > 0) {
    const std::uint32_t i = waiting[--count];
    if (!boxes[i].contains(place)) continue;
    if (!items_[i].leaf) {
      waiting[count++] = items_[i].second;
      waiting[count++] = i + 1;
      continue;
    }
    const std::optional<TetPlace> found = solve(items_[i].element, x, place, depth);
    if (!found || !(found->weights.minCoeff() > depth)) continue;
    depth = found->weights.minCoeff();
    best = found;
    if (depth >= 0.0) break;
  }
  return best;
}

Eigen::Matrix3d TetTree::vertex_gradient(std::uint32_t vertex, const Eigen::VectorXd& x) const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double volume = 0.0;
  for (std::uint32_t k = firsts_[vertex]; k < firsts_[vertex + 1]; ++k) {
    const TetModelElement& element = model_->elements()[around_[k]];
    std::size_t a = 0;
    while (element.nodes[a] != vertex) ++a;
    Eigen::Matrix<double, 3, 4> slopes;
    for (std::size_t b = 0; b < 4; ++b)
      slopes.col(static_cast<Eigen::Index>(b)) = node_place(element, kNodeAt[a][b], x);
    const double part = element.element.geometry.volume;
    sum.noalias() += (2.0 * part) * (slopes * element.element.geometry.gradients.transpose());
    volume += part;
  }
  return sum / volume;
}

Eigen::Matrix3d TetTree::smooth_gradient(const TetPlace& place, const Eigen::VectorXd& x) const {
  const TetModelElement& element = model_->elements()[place.element];
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t a = 0; a < 4; ++a)
    sum += place.weights[static_cast<Eigen::Index>(a)] * vertex_gradient(element.nodes[a], x);
  return sum;
}

Eigen::Vector3d TetTree::rest_place(const TetPlace& place) const {
  const TetModelElement& element = model_->elements()[place.element];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t a = 0; a < 4; ++a)
    sum += place.weights[a] * node_place(element, a, model_->rest());
  return sum;
}

}  // namespace tremolo
