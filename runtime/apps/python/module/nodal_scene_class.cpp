// The class tremolo.NodalScene: a scene of tetrahedra or of cloths alone.
#include <memory>
#include <utility>

#include "common/text.h"
#include "runtime/apps/python/module/nodal_handle.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/bodies/tets/motion/tet_group.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace tremolo::python {
namespace {

// The common part of the two kinds of scene.
class Scene {
 public:
  virtual ~Scene() = default;
  virtual const char* kind() const = 0;
  virtual double step_size() const = 0;
  virtual double duration() const = 0;
  virtual std::int64_t steps() const = 0;
  virtual py::dict energy() = 0;
  virtual Momenta momenta() const = 0;
  virtual const std::vector<SceneCollider>& colliders() const = 0;
  virtual Pose collider_pose(std::size_t i) const = 0;
  virtual std::span<const ClothWorld::Ball> balls() const { return {}; }
  virtual const std::vector<SceneBall>& scene_balls() const {
    static const std::vector<SceneBall> none;
    return none;
  }
  // One step, without the interpreter's lock.
  Status step() {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (Status s = bodies.source(i).begin_step(); !s) return s;
    return take_step();
  }

  NodalBodies bodies;
  std::atomic<bool> used = false;

 private:
  virtual Status take_step() = 0;
};

class TetsScene final : public Scene {
 public:
  TetsScene(TetScene scene, TetsBodies made) : scene_(std::move(scene)), made_(std::move(made)) {
    std::vector<std::string> names;
    for (const TetSceneBody& body : scene_.bodies) names.push_back(body.name);
    bodies = NodalBodies(sources_of(
        *made_.group, names, [this](std::size_t i) -> const TetsKind& { return made_.kind(i); }));
    reports_.resize(bodies.size());
    made_.group->find_touches();
    (void)bound_.look(*made_.group);
  }

  const char* kind() const override { return "tets"; }
  double step_size() const override { return scene_.step; }
  double duration() const override { return scene_.duration; }
  std::int64_t steps() const override { return steps_; }
  const std::vector<SceneCollider>& colliders() const override { return scene_.colliders; }
  Pose collider_pose(std::size_t i) const override { return scene_.colliders[i].pose; }

  py::dict energy() override {
    double kinetic = 0.0, potential = 0.0, gravity = 0.0, contact = 0.0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const NodalEnergy now = bodies.source(i).energy();
      kinetic += now.kinetic;
      potential += now.potential;
      gravity += now.gravity;
      contact += made_.group->contact(i).look().energy;
    }
    py::dict dict;
    dict["kinetic"] = kinetic;
    dict["potential"] = potential;
    dict["gravity"] = gravity;
    dict["contact"] = contact;
    dict["total"] = kinetic + potential + gravity + contact;
    dict["sleep"] = -made_.group->energy_of_sleep();
    return dict;
  }
  Momenta momenta() const override {
    Momenta sum;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Momenta one = bodies.source(i).momenta();
      sum.linear += one.linear;
      sum.angular += one.angular;
    }
    return sum;
  }

 private:
  Status take_step() override {
    TetGroup& group = *made_.group;
    if (!group.step(reports_)) return failure();
    ++steps_;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies.source(i).driven) return Success{};
    if (bound_.look(group)) return Success{};
    return Error{ErrorKind::kBound,
                 "at t = " + number_text(static_cast<double>(steps_) * scene_.step) +
                     " s the energy of the bodies, " + number_text(bound_.energy()) +
                     " J, is more than " + number_text(kEnergyBound) +
                     " times all that was put in"};
  }
  Error failure() const {
    std::string text;
    for (std::size_t i = 0; i < reports_.size(); ++i) {
      if (reports_[i].converged) continue;
      text += (text.empty() ? "" : "; ") + scene_.bodies[i].name +
              ": the step from t = " + number_text(made_.group->body(i).time()) +
              " s could not be solved";
    }
    return {ErrorKind::kSolver, text};
  }

  TetScene scene_;
  TetsBodies made_;
  std::vector<TetStepReport> reports_;
  TetBound bound_;
  std::int64_t steps_ = 0;
};

class ClothsScene final : public Scene {
 public:
  explicit ClothsScene(ClothWorld world) : world_(std::move(world)) {
    bodies = NodalBodies(sources_of(world_));
  }

  const char* kind() const override { return "cloth"; }
  double step_size() const override { return world_.scene().options.step; }
  double duration() const override { return world_.scene().duration; }
  std::int64_t steps() const override { return world_.steps(); }
  const std::vector<SceneCollider>& colliders() const override { return world_.scene().colliders; }
  Pose collider_pose(std::size_t i) const override { return world_.collider_pose(i); }
  std::span<const ClothWorld::Ball> balls() const override { return world_.balls(); }
  const std::vector<SceneBall>& scene_balls() const override { return world_.scene().balls; }

  py::dict energy() override {
    const ClothEnergy e = world_.energy();
    py::dict dict;
    dict["kinetic"] = e.kinetic;
    dict["potential"] = e.elastic;
    dict["gravity"] = e.gravity;
    dict["total"] = e.total();
    dict["damping"] = -e.damped;
    dict["wind"] = e.wind;
    dict["pins"] = e.pins;
    dict["contact_given"] = e.contact;
    dict["method"] = e.numerical;
    return dict;
  }
  Momenta momenta() const override { return {world_.linear_momentum(), world_.angular_momentum()}; }

 private:
  Status take_step() override { return world_.step(); }
  ClothWorld world_;
};

struct NodalScene {
  std::shared_ptr<Scene> scene;
};

NodalScene scene_of_text(const std::string& text, py::handle path_object) {
  const std::string path = path_text(path_object);
  const SceneKind kind = unwrap(scene_kind(text, path));
  if (kind == SceneKind::kCloth) {
    const ClothFile file = unwrap(parse_cloths(text, path));
    Result<ClothWorld> world = [&] {
      const py::gil_scoped_release unlocked;
      return ClothWorld::create(file.scene);
    }();
    if (!world) raise(error_of_file(path, world.error()));
    return {std::make_shared<ClothsScene>(std::move(*world))};
  }
  if (kind != SceneKind::kTets)
    raise(usage_error(path + ": it is no scene of tetrahedra or of cloths alone"));
  TetScene scene = unwrap(parse_tets_scene(text, path));
  Result<TetsBodies> made = [&] {
    const py::gil_scoped_release unlocked;
    return make_tets_bodies(scene);
  }();
  TetsBodies bodies = unwrap(std::move(made));
  return {std::make_shared<TetsScene>(std::move(scene), std::move(bodies))};
}

const char* kind_of_text(const std::string& text, py::handle path) {
  switch (unwrap(scene_kind(text, path_text(path)))) {
    case SceneKind::kBodies:
      return "body";
    case SceneKind::kWorld:
      return "world";
    case SceneKind::kTets:
      return "tets";
    case SceneKind::kCloth:
      return "cloth";
  }
  return "";
}

// The scene for one call.
class Call {
 public:
  explicit Call(const NodalScene& self) : used_(self.scene->used, "world") {}

 private:
  InUse used_;
};

NodalPointer body_of(const NodalScene& self, py::handle name) {
  Scene& scene = *self.scene;
  const std::size_t i = number_of_body(
      name, scene.bodies.size(), [&](const std::string& text) { return scene.bodies.find(text); },
      [&](std::size_t k) { return scene.bodies.source(k).name(); }, "scene");
  return scene.bodies.handle(i, self.scene, scene.used);
}

void step(const NodalScene& self, std::int64_t count) {
  if (count < 0) raise(usage_error("n: " + std::to_string(count) + ", must not be negative"));
  const Call call(self);
  Status status = Success{};
  run_unlocked(count, [&](std::int64_t) {
    status = self.scene->step();
    return static_cast<bool>(status);
  });
  check(status);
}

py::list names(const NodalScene& self) {
  py::list list;
  for (std::size_t i = 0; i < self.scene->bodies.size(); ++i)
    list.append(self.scene->bodies.source(i).name());
  return list;
}

py::list colliders(const NodalScene& self) {
  const Call call(self);
  py::list list;
  const std::vector<SceneCollider>& all = self.scene->colliders();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const py::tuple pose = tuple_of(self.scene->collider_pose(i));
    py::dict dict;
    dict["name"] = all[i].name;
    dict["shape"] = shape_name(all[i].shape);
    dict["position"] = pose[0];
    dict["rotation"] = pose[1];
    list.append(dict);
  }
  return list;
}

py::list balls(const NodalScene& self) {
  const Call call(self);
  py::list list;
  const auto now = self.scene->balls();
  for (std::size_t i = 0; i < now.size(); ++i) {
    const py::tuple pose = tuple_of(Pose{now[i].position, now[i].rotation});
    py::dict dict;
    dict["name"] = self.scene->scene_balls()[i].name;
    dict["radius"] = self.scene->scene_balls()[i].radius;
    dict["position"] = pose[0];
    dict["rotation"] = pose[1];
    dict["velocity"] = array_of<3>(now[i].velocity);
    dict["spin"] = array_of<3>(now[i].spin);
    list.append(dict);
  }
  return list;
}

using SceneClass = py::class_<NodalScene>;

template <class Get>
void property(SceneClass& c, const char* name, const char* doc, const Get& get) {
  c.def_property_readonly(
      name,
      [get](const NodalScene& self) {
        const Call call(self);
        return get(*self.scene);
      },
      doc);
}

void add_values(SceneClass& c) {
  property(c, "kind", "\"tets\" or \"cloth\".", [](Scene& s) { return s.kind(); });
  property(c, "steps", "Number of steps taken.", [](Scene& s) { return s.steps(); });
  property(c, "step_size", "h, s.", [](Scene& s) { return s.step_size(); });
  property(c, "time", "s.",
           [](Scene& s) { return static_cast<double>(s.steps()) * s.step_size(); });
  property(c, "duration", "Of the scene, s.", [](Scene& s) { return s.duration(); });
  property(
      c, "energy",
      "Energies, J, a dict. Now: kinetic, potential (elastic), gravity, total, and of "
      "tetrahedra contact. Since the start, never positive: sleep, of bodies that fell asleep, "
      "of tetrahedra; damping, of cloth. Given to cloths since the start: wind, pins, "
      "contact_given, method.",
      [](Scene& s) { return s.energy(); });
  property(c, "linear_momentum", "Of all that moves, (3,), kg m/s.",
           [](Scene& s) { return array_of<3>(s.momenta().linear); });
  property(c, "angular_momentum", "The same about the origin, (3,), N m s.",
           [](Scene& s) { return array_of<3>(s.momenta().angular); });
}

}  // namespace

void add_nodal_scene(py::module_& module) {
  SceneClass c(module, "NodalScene",
               "A scene of tetrahedra or of cloths alone. tremolo.load_scene() makes it of a dict "
               "or a file.");
  module.def("nodal_scene_of_text", &scene_of_text, py::arg("text"), py::arg("path"),
             "A scene of tetrahedra or cloths of the text of a file (TOML). path: where it would "
             "be, for the paths inside.");
  module.def("kind_of_text", &kind_of_text, py::arg("text"), py::arg("path"),
             "The kind of a scene's text: \"world\", \"tets\", \"cloth\", or \"body\" for one of "
             "tables without a list.");
  add_values(c);
  c.def_property_readonly("names", &names, "Names of the bodies, a list of str.");
  c.def("body", &body_of, py::arg("name"),
        "A body by its name or number: a tremolo.NodalBody, which keeps the scene alive.");
  c.def("__getitem__", &body_of, py::arg("name"));
  c.def("__len__", [](const NodalScene& self) { return self.scene->bodies.size(); });
  c.def("step", &step, py::arg("n") = 1,
        "Takes n steps without the interpreter's lock. A step that cannot be solved raises "
        "SolverError with the bodies' names; the other bodies have moved. Ctrl-C ends the call "
        "between two steps.");
  c.def_property_readonly("colliders", &colliders,
                          "A list of dicts: name, shape, position (3,), rotation (4,).");
  c.def_property_readonly("balls", &balls,
                          "The rigid balls of a scene of cloths, a list of dicts: name, radius, "
                          "position (3,), rotation (4,), velocity (3,), spin (3,).");
  refuse_construction(c, "tremolo.load_scene() makes one");
  c.def("__reduce__", [](const NodalScene&) -> py::object {
    raise_type("a scene of tetrahedra or cloths is neither copied nor pickled: load it again");
  });
  c.def("__repr__", [](const NodalScene& self) {
    return std::string("<tremolo.NodalScene: ") + self.scene->kind() + ", " +
           std::to_string(self.scene->bodies.size()) + " bodies>";
  });
}

}  // namespace tremolo::python
