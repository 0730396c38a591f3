// The class tremolo.NodalBody: a body that moves by its points, as Python has it.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "runtime/apps/python/module/convert.h"
#include "runtime/apps/python/module/nodal_source.h"

namespace tremolo::python {

// owner: the world or scene with the body, which it keeps alive. source: null: the body, of the
// name `ended`, was removed from its world.
struct NodalHandle {
  std::shared_ptr<void> owner;
  std::atomic<bool>* used;
  NodalSource* source;
  std::string ended = {};
};
using NodalPointer = std::shared_ptr<NodalHandle>;

// The bodies of an owner, each with one handle at a time.
class NodalBodies {
 public:
  explicit NodalBodies(NodalSources sources = {})
      : sources_(std::move(sources)), handles_(sources_.size()) {}

  // A body that was added, and one that was removed: its object is of no body from then on.
  void put(std::size_t i, std::unique_ptr<NodalSource> source);
  void end(std::size_t i);

  std::size_t size() const { return sources_.size(); }
  bool has(std::size_t i) const { return sources_[i] != nullptr; }  // false: it was removed
  NodalSource& source(std::size_t i) const { return *sources_[i]; }
  std::optional<std::size_t> find(const std::string& name) const;
  // owner: has the flag and this list.
  NodalPointer handle(std::size_t i, const std::shared_ptr<void>& owner, std::atomic<bool>& used);

 private:
  NodalSources sources_;
  std::vector<std::weak_ptr<NodalHandle>> handles_;
};

// The number of a body by its name or number, of `size` bodies; find(text): the number or none,
// name_of(i): its name. Raises.
template <class Find, class NameOf>
std::size_t number_of_body(py::handle name, std::size_t size, const Find& find,
                           const NameOf& name_of, const char* owner) {
  if (PyLong_Check(name.ptr())) {
    const auto i = name.cast<std::int64_t>();
    if (i < 0 || std::cmp_greater_equal(i, size))
      raise(usage_error("there is no body " + std::to_string(i) + ": the " + owner + " has " +
                        std::to_string(size)));
    return static_cast<std::size_t>(i);
  }
  if (!PyUnicode_Check(name.ptr())) raise_type("expected the name or the number of a body");
  const auto text = name.cast<std::string>();
  if (const std::optional<std::size_t> found = find(text)) return *found;
  std::string known;
  for (std::size_t i = 0; i < size && i < 20; ++i) known += " " + name_of(i);
  raise(usage_error("there is no body '" + text + "'; known:" + known));
}

void add_nodal(py::module_& module);
void add_nodal_scene(py::module_& module);

}  // namespace tremolo::python
