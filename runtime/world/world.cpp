#include "runtime/world/world.h"

#include <algorithm>
#include <set>

#include "common/text.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

std::vector<Eigen::Index> drawn_particles(const ClothParts& parts) {
  std::vector<Eigen::Index> particles(parts.drawn ? parts.drawn->vertices.size()
                                                  : parts.particles());
  for (std::size_t v = 0; v < particles.size(); ++v) {
    const bool renumbered = parts.drawn && !parts.drawn->sources.empty();
    const std::size_t vertex = renumbered ? static_cast<std::size_t>(parts.drawn->sources[v]) : v;
    particles[v] = static_cast<Eigen::Index>(parts.particle_of_vertex(vertex));
  }
  return particles;
}

Status check_names(const WorldScene& scene) {
  std::set<std::string> names;
  std::vector<std::string> all;
  for (const SceneBody& body : scene.scene.bodies) all.push_back(body.name);
  for (const TetSceneBody& body : scene.tets) all.push_back(body.name);
  for (const ClothSceneBody& body : scene.cloths) all.push_back(body.name());
  for (const std::string& name : all)
    if (!names.insert(name).second) return content_error("two bodies are called '" + name + "'");
  return Success{};
}

// With the step and the gravity of the world.
TetSceneBody in_world(TetSceneBody body, const SceneWorld& world) {
  body.options.step = world.step_size();
  body.options.gravity = world.scene().gravity.at(world.time());
  return body;
}

std::string message_of(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& exception) {
    return exception.what();
  } catch (...) {
    return "an unknown exception";
  }
}

// True while the world steps, whatever ends the step.
struct Stepping {
  explicit Stepping(bool& flag) : flag_(flag) { flag_ = true; }
  ~Stepping() { flag_ = false; }
  Stepping(const Stepping&) = delete;
  Stepping& operator=(const Stepping&) = delete;

 private:
  bool& flag_;
};

}  // namespace

World::World(SceneWorld own, const WorldScene& scene) : own_(std::move(own)), path_(scene.path) {}

Result<std::unique_ptr<World>> World::create(const WorldScene& given, unsigned threads) {
  if (Status s = check_names(given); !s) return s.error();
  const bool guests = !given.tets.empty() || !given.cloths.empty();
  Scene scene = given.scene;
  for (const TetSceneBody& body : given.tets) scene.guests.insert(body.name);
  for (const ClothSceneBody& body : given.cloths) scene.guests.insert(body.name());
  Result<SceneWorld> made = SceneWorld::create(scene, given.source, guests);
  if (!made) return made.error();
  std::unique_ptr<World> world(new World(std::move(*made), given));
  if (Status s = world->set_threads(threads); !s) return s.error();
  for (std::size_t i = 0; i < world->own_.size(); ++i)
    world->own_slots_.push_back(world->take_slot(false, i).slot);
  if (!guests) return world;
  std::vector<TetSceneBody> tets;
  for (const TetSceneBody& body : given.tets) tets.push_back(in_world(body, world->own_));
  Result<WorldGuests> added = add_guests(tets, given.cloths, given.path, world->own_);
  if (!added) return added.error();
  for (std::size_t i = 0; i < world->all_guests().size(); ++i)
    (void)world->begin_guest(i, i < added->tets() ? std::optional(added->kind(i)) : std::nullopt);
  return world;
}

// A slot for a body, the one that has been free for longest.
WorldBody World::take_slot(bool guest, std::size_t index) {
  std::size_t slot = slots_.size();
  if (free_.empty()) {
    slots_.emplace_back();
  } else {
    slot = free_.front();
    free_.erase(free_.begin());
  }
  Slot& taken = slots_[slot];
  taken = {true, guest, taken.generation + 1, index, nullptr};
  return {static_cast<std::uint32_t>(slot), taken.generation};
}

WorldBody World::begin_guest(std::size_t number, std::optional<TetsKind> kind) {
  if (number >= guests_.size()) guests_.resize(number + 1);
  const WorldBody body = take_slot(true, number);
  Guest& guest = guests_[number];
  guest = {.kind = std::move(kind), .slot = body.slot};
  const MixedGuests& all = all_guests();
  guest.at_start = energy_of(all, number);
  if (const ClothStep* step = all.cloth(number)) {
    const SceneCloth& cloth = step->body().cloth();
    guest.driven = cloth.drag > 0.0 || !cloth.pins.empty();
    guest.particles = drawn_particles(step->body().model().parts());
  }
  (void)look_at(number);
  return body;
}

// True while the energy of a guest is compatible with what was put into it.
bool World::look_at(std::size_t number) {
  const GuestEnergy now = energy_of(all_guests(), number);
  const ContactSums& sums = all_guests().sums(number);
  const double contact = all_guests().account(number).energy;
  return guests_[number].bound.look(
      now.kinetic + now.elastic + contact, now.gravity,
      sums.work + sums.hand + sums.joint + all_guests().load_work(number) + contact);
}

Result<WorldBody> World::add(const SceneBody& body, const ModelSource& source) {
  const Result<std::size_t> added = own_.add_body(body, source);
  if (!added) return added.error();
  const WorldBody made = take_slot(false, *added);
  if (*added >= own_slots_.size()) own_slots_.resize(*added + 1);
  own_slots_[*added] = made.slot;
  return made;
}

Result<WorldBody> World::add(TetSceneBody body) {
  const bool first = guests() == nullptr;
  Result<AddedGuest> added = add_guest(in_world(std::move(body), own_), path_, own_);
  if (first) pass_filter();
  if (!added) return added.error();
  return begin_guest(added->number, std::move(added->kind));
}

Result<WorldBody> World::add(const ClothSceneBody& body) {
  const bool first = guests() == nullptr;
  Result<AddedGuest> added = add_guest(body, path_, own_);
  if (first) pass_filter();
  if (!added) return added.error();
  return begin_guest(added->number, std::nullopt);
}

Status World::remove(WorldBody body) {
  if (Status s = check(body); !s) return s;
  const std::size_t number = number_of(body);
  if (is_guest(body)) {
    own_.forget_guest(index(body), name(body));
    all_guests().remove(index(body));
    guests_[index(body)].kind.reset();
  } else {
    own_.remove_body(index(body));
  }
  std::erase_if(touches_, [number](const Touch& touch) {
    return touch.first == number || touch.second == number;
  });
  std::erase_if(events_, [body](const WorldEvent& event) {
    return event.body == body || event.other == body;
  });
  slots_[body.slot].used = false;
  free_.push_back(body.slot);
  return Success{};
}

Result<std::size_t> World::add_collider(const SceneCollider& wanted) {
  if (const MixedGuests* all = guests(); all != nullptr && !own_.replaying()) {
    Result<Collider> shape = load_scene_collider(wanted);
    if (!shape) return shape.error();
    const PlacedCollider placed{std::move(*shape), wanted.pose, wanted.pose};
    for (std::size_t g = 0; g < all->size(); ++g)
      if (!all->removed(g) && all->deepest_in(g, std::span(&placed, 1)) > all->margin(g))
        return content_error("collider '" + wanted.name + "': body '" + all->name(g) +
                             "' is inside it by more than its margin");
  }
  return own_.add_collider(wanted);
}

Status World::check_collider(std::size_t collider) const {
  if (collider < own_.scene().colliders.size()) {
    if (!own_.collider_removed(collider)) return Success{};
    return usage_error("collider " + std::to_string(collider) + " has been removed");
  }
  return usage_error("there are " + std::to_string(own_.scene().colliders.size()) +
                     " colliders, no collider " + std::to_string(collider));
}

Status World::move_collider(std::size_t collider, const Pose& next) {
  if (Status s = check_collider(collider); !s) return s;
  return own_.move_collider(collider, next);
}

Status World::remove_collider(std::size_t collider) {
  if (Status s = check_collider(collider); !s) return s;
  own_.remove_collider(collider);
  std::erase_if(touches_, [collider](const Touch& touch) {
    return touch.second == kFirstCollider + collider;
  });
  std::erase_if(events_, [collider](const WorldEvent& event) {
    return !event.other && event.collider == collider;
  });
  return Success{};
}

Status World::remove_joint(std::size_t joint) {
  if (joint >= own_.scene().joints.size())
    return usage_error("there is no joint " + std::to_string(joint));
  own_.remove_joint(joint);
  return Success{};
}

const Joint* World::joint(std::size_t joint) const {
  return joint < own_.scene().joints.size() ? own_.joint(joint) : nullptr;
}

std::optional<std::size_t> World::find_collider(const std::string& name) const {
  for (std::size_t c = 0; c < own_.scene().colliders.size(); ++c)
    if (!own_.collider_removed(c) && own_.scene().colliders[c].name == name) return c;
  return std::nullopt;
}

// An error names all bodies that failed in the step.
Status World::take_step() {
  std::string failed;
  ErrorKind kind = ErrorKind::kSolver;
  const auto add = [&](const std::string& name, ErrorKind why, const std::string& reason) {
    kind = why;
    failed += (failed.empty() ? "" : "; ") + name + ": " + reason;
  };
  for (const SceneWorld::Failure& failure : own_.step())
    add(own_.name(failure.body), error_kind(failure.report.failure),
        failure_message(failure.report, own_.time()));
  for (std::size_t i = 0; i < guests_.size(); ++i) {
    Guest& guest = guests_[i];
    if (guest.over || all_guests().removed(i)) continue;
    const std::string& name = all_guests().name(i);
    guest.over = true;
    if (all_guests().failed(i))
      add(name, ErrorKind::kSolver,
          "the step to t = " + number_text(own_.time()) + " s could not be solved");
    else if (!guest.driven && !look_at(i))
      add(name, ErrorKind::kBound,
          "at t = " + number_text(own_.time()) + " s the energy is more than " +
              number_text(kEnergyBound) + " times all that was put in");
    else
      guest.over = false;
  }
  note_events();
  if (failed.empty()) return Success{};
  return Error{kind, failed};
}

Status World::step(std::int64_t count, std::int64_t* done) {
  if (done != nullptr) *done = 0;
  if (count < 0) return usage_error("the number of steps is " + std::to_string(count));
  const Stepping stepping(stepping_);
  events_.clear();
  thrown_ = nullptr;
  if (jobs_) jobs_->forget_problem();
  for (std::int64_t k = 0; k < count; ++k) {
    const Status made = take_step();
    if (done != nullptr) *done = k + 1;
    if (thrown_) return usage_error("the filter threw: " + message_of(thrown_));
    const std::string broken = jobs_ ? jobs_->problem() : std::string();
    if (!made)
      return Error{made.error().kind, made.error().message + (broken.empty() ? "" : "; " + broken)};
    if (!broken.empty()) return usage_error(broken);
  }
  return Success{};
}

void World::set_jobs(std::optional<BodyGroup::Jobs> jobs) {
  own_.set_jobs(std::nullopt);
  jobs_ = jobs ? std::make_unique<WatchedJobs>(std::move(*jobs)) : nullptr;
  if (jobs_) own_.set_jobs(jobs_->watched());
}

void World::set_filter(Filter filter) {
  filter_ = std::move(filter);
  pass_filter();
}

// Gives the filter to the bodies of both kinds, each with the numbers that it knows.
void World::pass_filter() {
  const auto ask = [this](std::size_t a, std::size_t b) {
    if (a == static_cast<std::size_t>(-1) || b == static_cast<std::size_t>(-1)) return true;
    try {
      return filter_(body_of(a), body_of(b));
    } catch (...) {
      if (!thrown_) thrown_ = std::current_exception();
      return true;
    }
  };
  own_.set_filter(filter_ ? PairFilter(ask) : PairFilter());
  if (guests() == nullptr) return;
  const auto ask_guests = [this, ask](std::size_t a, std::size_t b) {
    const auto known = [this](std::size_t number) {
      return number < kFirstGuest ? own_.body_of_number(number) : number;
    };
    return ask(known(a), known(b));
  };
  all_guests().set_filter(filter_ ? PairFilter(ask_guests) : PairFilter());
}

void World::replay_step() {
  own_.replay_step();
  if (guests() != nullptr) all_guests().replay_step();
}

Status World::restore(std::span<const std::byte> bytes) {
  if (Status s = own_.restore(bytes); !s) return s;
  events_.clear();
  for (std::size_t i = 0; i < guests_.size(); ++i) {
    if (all_guests().removed(i)) continue;
    guests_[i].bound = {};
    guests_[i].over = all_guests().failed(i);
    (void)look_at(i);
  }
  touches_.clear();
  note_guests();
  events_.clear();
  return Success{};
}

}  // namespace tremolo
