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
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/io/exchange/recording.h"

namespace tremolo {
namespace {

class BodiesMotion : public MotionSource {
 public:
  explicit BodiesMotion(std::vector<RunOptions> bodies) : bodies_(std::move(bodies)) {}

  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const RunOptions& body : bodies_) names.push_back(body.name);
    return names;
  }

  std::vector<NamedFile> inputs() const override {
    std::vector<NamedFile> files;
    for (const RunOptions& body : bodies_)
      for (NamedFile& file : inputs_of(body)) files.push_back(std::move(file));
    return files;
  }

  std::string told() const override {
    std::vector<std::string> methods;
    for (const RunOptions& body : bodies_)
      if (std::find(methods.begin(), methods.end(), body.integrator) == methods.end())
        methods.push_back(body.integrator);
    return fmt::format("{:.4g} s by `{}` in steps of {:.4g} ms", bodies_.front().duration,
                       fmt::join(methods, "`, `"), 1e3 * bodies_.front().step);
  }

  Status check(const MotionOutputs&) const override { return Success{}; }

  Result<RecordedMotion> record(const FrameRange& range, bool) const override {
    return animate_bodies(bodies_, range);
  }

 private:
  std::vector<RunOptions> bodies_;
};

class WorldMotion : public MotionSource {
 public:
  explicit WorldMotion(SceneFile file) : file_(std::move(file)) {}

  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const SceneBody& body : file_.scene.bodies) names.push_back(body.name);
    return names;
  }

  std::vector<std::string> scenery() const override {
    std::vector<std::string> names;
    for (const SceneCollider& collider : file_.scene.colliders) names.push_back(collider.name);
    return names;
  }

  std::vector<NamedFile> inputs() const override { return inputs_of(file_); }

  std::string told() const override {
    return fmt::format("{:.4g} s in steps of {:.4g} ms", file_.scene.duration,
                       1e3 * file_.scene.step);
  }

  Status check(const MotionOutputs&) const override { return Success{}; }

  Result<RecordedMotion> record(const FrameRange& range, bool colliders) const override {
    return animate_world(file_, range, colliders);
  }

 private:
  SceneFile file_;
};

}  // namespace

std::unique_ptr<MotionSource> bodies_motion(std::vector<RunOptions> bodies) {
  return std::make_unique<BodiesMotion>(std::move(bodies));
}

std::unique_ptr<MotionSource> world_motion(SceneFile file) {
  return std::make_unique<WorldMotion>(std::move(file));
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
