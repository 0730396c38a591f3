#include "runtime/apps/tremolo/export/motion_source.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/mesh/selector.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/io/exchange/recording.h"

namespace tremolo {

MotionSource bodies_motion(std::vector<BodyScene> bodies) {
  MotionSource source;
  std::vector<std::string> methods;
  for (const BodyScene& one : bodies) {
    source.names.push_back(one.body().name);
    for (NamedFile& file : inputs_of(one)) source.inputs.push_back(std::move(file));
    const std::string& method = one.body().integrator;
    if (std::find(methods.begin(), methods.end(), method) == methods.end())
      methods.push_back(method);
  }
  const Scene& first = bodies.front().file.scene;
  source.description = fmt::format("{:.4g} s by `{}` in steps of {:.4g} ms", first.duration,
                                   fmt::join(methods, "`, `"), 1e3 * first.step);
  source.record = [bodies = std::move(bodies)](const FrameRange& range, bool) {
    return animate_bodies(bodies, range);
  };
  return source;
}

namespace {

double plane_size(const Animation& animation) {
  double size = 0.0;
  for (const AnimatedShape& shape : animation.shapes)
    for (const Eigen::Vector3d& x : shape.surface.vertices)
      size = std::max(size, x.cwiseAbs().maxCoeff());
  return std::max(2.0 * size, 1.0);
}

}  // namespace

void add_scenery(AnimatedShape shape, std::string name, std::set<std::string>& taken,
                 Animation& animation) {
  while (!taken.insert(name).second) name += "-collider";
  AnimatedBody body;
  body.name = std::move(name);
  body.shape = animation.shapes.size();
  body.collider = true;
  animation.shapes.push_back(std::move(shape));
  animation.bodies.push_back(std::move(body));
}

Scenery add_colliders(std::span<const SceneCollider> colliders, bool planes,
                      std::set<std::string>& taken, Animation& animation) {
  Scenery scenery;
  const double plane = plane_size(animation);
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    const SceneCollider& known = colliders[k];
    if (!planes && std::holds_alternative<PlaneShape>(known.shape)) continue;
    std::optional<AnimatedShape> shape;
    if (known.file.empty()) shape = collider_shape(known.shape, known.name, plane);
    if (!shape) {
      scenery.left_out.push_back(known.name);
      continue;
    }
    add_scenery(std::move(*shape), known.name, taken, animation);
    scenery.colliders.push_back(k);
  }
  return scenery;
}

}  // namespace tremolo
