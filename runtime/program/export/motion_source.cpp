#include "runtime/program/export/motion_source.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/mesh/selector.h"
#include "runtime/program/run/run_body.h"
#include "runtime/program/run/run_files.h"
#include "runtime/program/world/run_world.h"

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

}  // namespace tremolo
