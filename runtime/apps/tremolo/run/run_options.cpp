#include "runtime/apps/tremolo/run/run_options.h"

#include <optional>
#include <type_traits>
#include <utility>

#include <toml++/toml.h>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {
namespace {

// One key of a scene: how to store its value; false if the type is wrong.
using Store = bool (*)(const toml::node&, RunOptions&);

template <class T>
std::optional<T> value_of(const toml::node& node) {
  // toml++ converts between numbers and bools.
  if constexpr (std::is_same_v<T, int>)
    return whole_number(node);
  else if constexpr (std::is_same_v<T, double>)
    return node.is_boolean() ? std::nullopt : node.value<double>();
  else
    return node.value_exact<T>();
}

template <class T>
bool store(const toml::node& node, T& target) {
  const auto value = value_of<T>(node);
  if (value) target = *value;
  return value.has_value();
}

bool store_frequency(const toml::node& node, SignalShape& shape) {
  shape.frequency = node.value<double>();
  return shape.frequency.has_value();
}

bool store_duration(const toml::node& node, SignalShape& shape) {
  shape.duration = node.value<double>();
  return shape.duration.has_value();
}

// "F1,F2" or [F1, F2].
bool store_sweep(const toml::node& node, SignalShape& shape) {
  const auto text = sweep_text(node);
  if (text) shape.sweep = *text;
  return text.has_value();
}

bool store_list(const toml::node& node, std::vector<std::string>& target) {
  auto list = list_of_texts(node);
  if (list) target = std::move(*list);
  return list.has_value();
}

// A vertex or a selector.
bool store_at(const toml::node& node, std::string& target) {
  if (const auto vertex = node.value_exact<std::int64_t>()) {
    target = std::to_string(*vertex);
    return true;
  }
  const auto selector = node.value_exact<std::string>();
  if (selector) target = *selector;
  return selector.has_value();
}

struct Key {
  std::string_view name;
  Store store;
};

template <auto Member,
          auto Take = store<std::remove_reference_t<decltype(std::declval<RunOptions&>().*Member)>>>
bool keep(const toml::node& node, RunOptions& options) {
  return Take(node, options.*Member);
}

constexpr Key kKeys[] = {
    {"model", keep<&RunOptions::model>},
    {"integrator", keep<&RunOptions::integrator>},
    {"step", keep<&RunOptions::step>},
    {"duration", keep<&RunOptions::duration>},
    {"modes", keep<&RunOptions::modes>},
    {"rescale", keep<&RunOptions::rescale>},
    {"linear", keep<&RunOptions::linear>},
    {"load", keep<&RunOptions::load>},
    {"at", keep<&RunOptions::at, store_at>},
    {"force", keep<&RunOptions::force>},
    {"frequency", keep<&RunOptions::shape, store_frequency>},
    {"sweep", keep<&RunOptions::shape, store_sweep>},
    {"load-duration", keep<&RunOptions::shape, store_duration>},
    {"signal", keep<&RunOptions::signal>},
    {"scale", keep<&RunOptions::scale>},
    {"alpha", keep<&RunOptions::alpha>},
    {"beta", keep<&RunOptions::beta>},
    {"damping-ratio", keep<&RunOptions::damping_ratio>},
    {"newmark-beta", keep<&RunOptions::newmark_beta>},
    {"newmark-gamma", keep<&RunOptions::newmark_gamma>},
    {"split", keep<&RunOptions::split>},
    {"safety", keep<&RunOptions::safety>},
    {"tolerance", keep<&RunOptions::tolerance>},
    {"max-iterations", keep<&RunOptions::max_iterations>},
    {"probe", keep<&RunOptions::probes, store_list>},
    {"coordinate", keep<&RunOptions::coordinates, store_list>},
    {"velocities", keep<&RunOptions::velocities>},
    {"deflect", keep<&RunOptions::deflect>},
    {"start", keep<&RunOptions::start>},
    {"out", keep<&RunOptions::out>},
    {"every", keep<&RunOptions::every>},
    {"plot", keep<&RunOptions::plot>},
    {"surfaces", keep<&RunOptions::surfaces>},
    {"surface-format", keep<&RunOptions::surface_format>},
    {"hull", keep<&RunOptions::hull>},
};

Status read_body(const std::string& path, const toml::table& table, RunOptions& body) {
  for (const auto& [key, node] : table) {
    const Key* known = nullptr;
    for (const Key& candidate : kKeys)
      if (candidate.name == key.str()) known = &candidate;
    if (known == nullptr)
      return error_at(path, key.source(), "unknown key '" + std::string(key.str()) + "'");
    if (!known->store(node, body))
      return error_at(path, node.source(),
                      "the value of '" + std::string(key.str()) + "' has the wrong type");
    // A NUL would end the path for the system.
    const auto text = node.value_exact<std::string_view>();
    if (text && text->find('\0') != std::string_view::npos)
      return error_at(path, node.source(),
                      "the value of '" + std::string(key.str()) + "' holds a NUL");
  }
  if (body.model.empty())
    return error_at(path, table.source(), "body '" + body.name + "' has no key 'model'");
  if (table.contains("signal") && table.contains("load"))
    return error_at(path, table.source(),
                    "body '" + body.name +
                        "': `signal` and `load` are two "
                        "courses of one load: leave one out");
  if (table.contains("damping-ratio") && (table.contains("alpha") || table.contains("beta")))
    return error_at(
        path, table.source(),
        "body '" + body.name + "': `damping-ratio` gives `alpha` and `beta`: leave those out");
  body.scene = path;
  body.model = beside(path, body.model);
  if (!body.signal.empty()) body.signal = beside(path, body.signal);
  if (!file_of_start(body.start).empty()) body.start = beside(path, body.start);
  return Success{};
}

}  // namespace

Result<std::vector<RunOptions>> read_scene(const std::string& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return parse_scene(*text, path);
}

Result<std::vector<RunOptions>> parse_scene(std::string_view text, const std::string& path) {
  const Result<toml::table> scene = parse_toml(text, path);
  if (!scene) return scene.error();
  std::vector<RunOptions> bodies;
  for (const auto& [name, node] : *scene) {
    const toml::table* table = node.as_table();
    if (table == nullptr)
      return error_at(path, name.source(),
                      "'" + std::string(name.str()) + "' stands outside a table: one table a body");
    RunOptions body;
    body.name = std::string(name.str());
    // It becomes the name of a folder.
    if (body.name.empty() || body.name.front() == '.' ||
        body.name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                    "._-") != std::string::npos)
      return error_at(path, name.source(),
                      "body '" + body.name + "': a name has letters, digits, '.', '_', '-' only");
    if (Status status = read_body(path, *table, body); !status) return status.error();
    bodies.push_back(std::move(body));
  }
  if (bodies.empty()) return content_error(path + ": the scene has no body");
  return bodies;
}

}  // namespace tremolo
