#include "runtime/apps/python/module/world_parts.h"

#include <utility>

#include "runtime/io/scenes/added_tables.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace tremolo::python {

WorldParts::WorldParts(std::string scene_text, std::string scene_path, ClothScene surroundings,
                       std::unique_ptr<World> made)
    : text(std::move(scene_text)),
      path(std::move(scene_path)),
      around(std::move(surroundings)),
      all(std::move(made)),
      world(all->own()) {
  for (const BodyNumber body : bodies()) begin(body);
}

std::vector<BodyNumber> WorldParts::bodies() const {
  std::vector<BodyNumber> list;
  for (std::size_t i = 0; i < world.size(); ++i)
    if (!world.removed(i)) list.push_back({false, i});
  if (const MixedGuests* known = all->guests())
    for (std::size_t i = 0; i < known->size(); ++i)
      if (!known->removed(i)) list.push_back({true, i});
  return list;
}

std::string WorldParts::name(BodyNumber body) const {
  return body.guest ? all->guests()->name(body.index) : world.name(body.index);
}

std::optional<BodyNumber> WorldParts::find(const std::string& wanted) const {
  if (const auto found = world.find(wanted)) return BodyNumber{false, *found};
  const MixedGuests* known = all->guests();
  for (std::size_t i = 0; known != nullptr && i < known->size(); ++i)
    if (!known->removed(i) && known->name(i) == wanted) return BodyNumber{true, i};
  return std::nullopt;
}

std::size_t WorldParts::own_body(BodyNumber body, const char* what) {
  if (body.guest)
    raise(usage_error("body '" + name(body) + "' is of kind \"" + guest(body).kind() +
                      "\": " + what));
  return body.index;
}

void WorldParts::begin(BodyNumber body) {
  const std::size_t i = body.index;
  if (body.guest) {
    MixedGuests& known = *guests_of(world);
    guests.put(
        i, source_of(known, i, known.cloth(i) != nullptr ? nullptr : &all->tets_kind(id(body))));
    return;
  }
  auto model = std::make_shared<PyModel>();
  model->model = world.body(i).model().shared_from_this();
  model->options = world.scene().bodies[i].model_options;
  model->path = world.scene().bodies[i].model;
  models.resize(world.size());
  handles.resize(world.size());
  models[i] = std::move(model);
  handles[i].reset();
}

void WorldParts::end(BodyNumber body) {
  if (body.guest) {
    guests.end(body.index);
    return;
  }
  if (const BodyPointer known = handles[body.index].lock()) known->end(name(body));
  handles[body.index].reset();
  models[body.index].reset();
}

void WorldParts::push_states() {
  for (const std::weak_ptr<BodyHandle>& body : handles)
    if (const BodyPointer known = body.lock()) known->push_state();
}

void WorldParts::pull_states() {
  for (const std::weak_ptr<BodyHandle>& body : handles)
    if (const BodyPointer known = body.lock()) known->pull_state();
}

PyWorld make_world(std::string text, std::string path) {
  const MixedFile mixed = unwrap(parse_mixed(text, path));
  Result<std::unique_ptr<World>> made = [&] {
    const py::gil_scoped_release unlocked;
    return World::create({path, mixed.file.scene, mixed.tets, mixed.cloths});
  }();
  if (!made) raise(error_of_file(path, made.error()));
  return {std::make_shared<WorldParts>(std::move(text), std::move(path), surroundings_of(mixed),
                                       std::move(*made))};
}

namespace {

// Raises, since it is of no body of the world.
[[noreturn]] void refuse_object(const std::string& ended) {
  if (!ended.empty()) refuse_removed(ended);
  raise(usage_error("the body is not one of this world"));
}

BodyNumber number_of_object(WorldParts& parts, const BodyPointer& body) {
  for (std::size_t i = 0; i < parts.handles.size(); ++i)
    if (parts.handles[i].lock() == body) return {false, i};
  refuse_object(body->ended());
}

BodyNumber number_of_object(WorldParts& parts, const NodalPointer& body) {
  for (std::size_t i = 0; i < parts.guests.size() && body->source != nullptr; ++i)
    if (parts.guests.has(i) && &parts.guests.source(i) == body->source) return {true, i};
  refuse_object(body->ended);
}

}  // namespace

BodyNumber number_of(const PyWorld& self, py::handle body) {
  WorldParts& parts = *self.parts;
  if (py::isinstance<BodyHandle>(body)) return number_of_object(parts, body.cast<BodyPointer>());
  if (py::isinstance<NodalHandle>(body)) return number_of_object(parts, body.cast<NodalPointer>());
  if (PyUnicode_Check(body.ptr()))
    if (const auto found = parts.find(body.cast<std::string>())) return *found;
  const std::vector<BodyNumber> bodies = parts.bodies();
  return bodies[number_of_body(
      body, bodies.size(), [](const std::string&) { return std::optional<std::size_t>(); },
      [&](std::size_t i) { return parts.name(bodies[i]); }, "world")];
}

py::object object_of(const PyWorld& self, BodyNumber body) {
  WorldParts& parts = *self.parts;
  const std::size_t i = body.index;
  if (body.guest) return py::cast(parts.guests.handle(i, self.parts, parts.used));
  if (BodyPointer known = parts.handles[i].lock()) return py::cast(known);
  const WorldCall call(self);
  auto made =
      std::make_shared<BodyHandle>(parts.models[i], self.parts, parts.world.body(i), parts.used);
  parts.handles[i] = made;
  return py::cast(made);
}

py::bytes save_world(const PyWorld& self) {
  const WorldCall call(self);
  const std::vector<std::byte> bytes = self.parts->world.save();
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void restore_world(const PyWorld& self, const std::string& bytes) {
  const WorldCall call(self);
  check(self.parts->all->restore(std::as_bytes(std::span(bytes.data(), bytes.size()))));
  self.parts->events.clear();
  self.parts->pull_states();
}

}  // namespace tremolo::python
