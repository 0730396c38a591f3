#include "runtime/io/exchange/creased_animation.h"

#include <algorithm>
#include <utility>

#include "common/mesh/creases.h"

namespace tremolo {
namespace {

using Eigen::Index;

bool deforms(const Animation& animation, std::size_t shape) {
  if (animation.shapes[shape].modes.cols() > 0) return true;
  return std::any_of(animation.bodies.begin(), animation.bodies.end(),
                     [shape](const AnimatedBody& body) {
                       return body.shape == shape && !body.displacements.empty();
                     });
}

// Appends what the vertices behind the first `before` ones are copies of.
template <class Value>
void repeat(const CreasedSurface& made, std::size_t before, std::vector<Value>& values) {
  if (values.empty()) return;
  for (std::size_t v = before; v < made.vertex_of.size(); ++v)
    values.push_back(values[static_cast<std::size_t>(made.vertex_of[v])]);
}

void split_shape(const CreasedSurface& made, AnimatedShape& shape) {
  RenderSurface& surface = shape.surface;
  const std::size_t before = surface.vertices.size(), after = made.vertex_of.size();
  repeat(made, before, surface.vertices);
  repeat(made, before, surface.uvs);
  repeat(made, before, surface.colours);
  repeat(made, before, surface.sources);
  surface.triangles = made.triangles;
  shape.smooth_groups = made.side_of;
  if (shape.modes.size() == 0) return;
  shape.modes.conservativeResize(3 * static_cast<Index>(after), Eigen::NoChange);
  for (std::size_t v = before; v < after; ++v)
    shape.modes.middleRows<3>(3 * static_cast<Index>(v)) =
        shape.modes.middleRows<3>(3 * Index{made.vertex_of[v]});
}

void split_body(const CreasedSurface& made, std::size_t before, AnimatedBody& body) {
  const std::size_t after = made.vertex_of.size();
  if (body.weights.cols() > 0) {
    body.weights.conservativeResize(static_cast<Index>(after), Eigen::NoChange);
    for (std::size_t v = before; v < after; ++v)
      body.weights.row(static_cast<Index>(v)) = body.weights.row(made.vertex_of[v]);
  }
  if (body.displacements.empty()) return;
  std::vector<double> all;
  all.reserve(body.displacements.size() / before * after);
  for (std::size_t first = 0; first < body.displacements.size(); first += 3 * before)
    for (const VertexId v : made.vertex_of)
      for (std::size_t k = 0; k < 3; ++k)
        all.push_back(body.displacements[first + 3 * static_cast<std::size_t>(v) + k]);
  body.displacements = std::move(all);
}

}  // namespace

std::optional<Animation> split_creases(const Animation& animation) {
  std::optional<Animation> split;
  for (std::size_t k = 0; k < animation.shapes.size(); ++k) {
    const AnimatedShape& shape = animation.shapes[k];
    const std::size_t before = shape.surface.vertices.size();
    if (!shape.surface.normals.empty() || !deforms(animation, k)) continue;
    const CreasedSurface made =
        split_at_creases(shape.surface.vertices, shape.surface.triangles, shape.smooth_groups);
    const bool any = std::any_of(made.sharp.begin(), made.sharp.end(),
                                 [](std::uint8_t flag) { return flag != 0; });
    if (!any) continue;
    if (!split) split = animation;
    split_shape(made, split->shapes[k]);
    for (AnimatedBody& body : split->bodies)
      if (body.shape == k) split_body(made, before, body);
  }
  return split;
}

}  // namespace tremolo
