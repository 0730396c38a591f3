#include "runtime/bodies/tets/motion/degree_choice.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace tremolo {
namespace {

// An edge becomes linear below this fraction of the energy above which it becomes quadratic, that
// is at 0.4 of the distance.
constexpr double kCalmer = 0.16;

Eigen::Index degree_at(std::size_t node) {
  return static_cast<Eigen::Index>(3 * node);
}

// Displacement of an edge's control point from the mean of its ends.
Eigen::Vector3d off_mean(const MeshEdge& edge, const Eigen::VectorXd& x) {
  return x.segment<3>(degree_at(edge.point)) -
         0.5 * (x.segment<3>(degree_at(edge.a)) + x.segment<3>(degree_at(edge.b)));
}

}  // namespace

Result<DegreeKind> parse_degree(std::string_view name) {
  if (name == "linear") return DegreeKind::kLinear;
  if (name == "quadratic") return DegreeKind::kQuadratic;
  if (name == "adaptive") return DegreeKind::kAdaptive;
  return usage_error("unknown degree '" + std::string(name) + "': linear, quadratic or adaptive");
}

Status check(const DegreeOptions& options) {
  if (!(options.error >= 0.0 && options.error <= 1.0))
    return content_error("degree: error is " + std::to_string(options.error) +
                         ", expected 0 to 1, of the energy");
  if (!(options.lower >= 0.0 && options.lower <= options.upper && std::isfinite(options.upper)))
    return content_error("degree thresholds: lower is " + std::to_string(options.lower) +
                         ", upper " + std::to_string(options.upper) +
                         "; expected 0 <= lower <= upper, of an edge's length");
  if (options.kind == DegreeKind::kAdaptive && options.error == 0.0 && !(options.lower > 0.0))
    return content_error("degree: without an error, upper and lower must be above 0");
  if (options.least_steps < 1 || options.every < 1)
    return content_error("degree: least steps and look-every must be at least 1");
  return Success{};
}

DegreeChoice::DegreeChoice(const TetModel& model, const DegreeOptions& options)
    : options_(options),
      stiffness_(model.edges(), 0.0),
      mass_(model.edges(), 0.0),
      age_(model.edges(), options.least_steps),  // edges that never changed need not wait
      wanted_(model.edges(), 2) {
  for (const TetModelElement& element : model.elements())
    for (std::size_t i = 4; i < kMostNodes; ++i)
      stiffness_[element.nodes[i] - model.vertices()] +=
          element.stiffness[node_block(i, i)].trace() / 3.0;
  for (std::size_t e = 0; e < model.edges(); ++e)
    mass_[e] = model.masses()[model.pattern()->diagonal(model.vertices() + e)];
}

std::vector<std::uint8_t> DegreeChoice::first_degrees() const {
  return std::vector<std::uint8_t>(wanted_.size(), options_.kind == DegreeKind::kQuadratic ? 2 : 1);
}

std::span<const std::uint8_t> DegreeChoice::choose(const TetSystem& system, const TetMotion& motion,
                                                   const DegreeMeasure& measure) {
  const TetModel& model = system.model();
  const double bound = options_.error * measure.energy /
                       static_cast<double>(std::max<std::size_t>(1, wanted_.size()));
  changed_ = 0;
  for (std::size_t e = 0; e < wanted_.size(); ++e) {
    const std::uint8_t now = system.degrees()[e];
    wanted_[e] = now;
    if (++age_[e] < options_.least_steps || model.held()[model.vertices() + e] != 0) continue;
    const MeshEdge& edge = model.edge(e);
    const double length = model.edge_length(e);
    const double stiffness = measure.rate * mass_[e] + stiffness_[e];
    if (now < 2) {
      const double pull = measure.residual.segment<3>(degree_at(edge.point)).norm();
      if (pull > measure.noise && pull > options_.upper * length * stiffness &&
          pull * pull > 2.0 * stiffness * bound)
        wanted_[e] = 2;
    } else if (measure.calm) {
      const Eigen::Vector3d off = off_mean(edge, motion.x);
      const Eigen::Vector3d later = off + measure.h * off_mean(edge, motion.v);
      const double distance = std::max(off.norm(), later.norm());
      if (distance < options_.lower * length || distance * stiffness < 0.4 * measure.noise ||
          stiffness * distance * distance < 2.0 * kCalmer * bound)
        wanted_[e] = 1;
    }
    if (wanted_[e] == now) continue;
    age_[e] = 0;
    ++changed_;
  }
  return wanted_;
}

}  // namespace tremolo
