#include "runtime/apps/tremolo/run/run_options.h"

#include <optional>
#include <type_traits>
#include <utility>

#include <toml++/toml.h>

#include "runtime/apps/tremolo/output/sound.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {
namespace {

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

bool store_number(const toml::node& node, std::optional<double>& target) {
  target = node.value<double>();
  return target.has_value();
}

// "F1,F2" or [F1, F2].
bool store_sweep(const toml::node& node, std::string& target) {
  const auto text = sweep_text(node);
  if (text) target = *text;
  return text.has_value();
}

bool store_damping(const toml::node& node, std::string& target) {
  const auto text = damping_text(node);
  if (text) target = *text;
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

// An option by the name of its flag and key. store: keeps the key's value and returns false if the
// type is wrong; null: only a flag. copy: from one body's options to another's.
struct Option {
  std::string_view name;
  bool (*store)(const toml::node&, RunOptions&);
  void (*copy)(const RunOptions&, RunOptions&);
};

template <auto Member,
          auto Take = store<std::remove_reference_t<decltype(std::declval<RunOptions&>().*Member)>>>
constexpr Option option(std::string_view name) {
  return {name,
          [](const toml::node& node, RunOptions& options) { return Take(node, options.*Member); },
          [](const RunOptions& from, RunOptions& to) { to.*Member = from.*Member; }};
}

// Of the load's shape.
template <auto Part, auto Take>
constexpr Option shape_option(std::string_view name) {
  return {
      name,
      [](const toml::node& node, RunOptions& options) { return Take(node, options.shape.*Part); },
      [](const RunOptions& from, RunOptions& to) { to.shape.*Part = from.shape.*Part; }};
}

template <auto Member>
constexpr Option flag_only(std::string_view name) {
  return {name, nullptr, [](const RunOptions& from, RunOptions& to) { to.*Member = from.*Member; }};
}

constexpr Option kOptions[] = {
    option<&RunOptions::model>("model"),
    option<&RunOptions::integrator>("integrator"),
    option<&RunOptions::step>("step"),
    option<&RunOptions::duration>("duration"),
    option<&RunOptions::modes>("modes"),
    option<&RunOptions::rescale>("rescale"),
    option<&RunOptions::linear>("linear"),
    option<&RunOptions::load>("load"),
    option<&RunOptions::at, store_at>("at"),
    option<&RunOptions::force>("force"),
    shape_option<&SignalShape::frequency, store_number>("frequency"),
    shape_option<&SignalShape::sweep, store_sweep>("sweep"),
    shape_option<&SignalShape::duration, store_number>("load-duration"),
    option<&RunOptions::signal>("signal"),
    option<&RunOptions::scale>("scale"),
    option<&RunOptions::alpha>("alpha"),
    option<&RunOptions::beta>("beta"),
    option<&RunOptions::damping_ratio, store_damping>("damping-ratio"),
    option<&RunOptions::newmark_beta>("newmark-beta"),
    option<&RunOptions::newmark_gamma>("newmark-gamma"),
    option<&RunOptions::split>("split"),
    option<&RunOptions::safety>("safety"),
    option<&RunOptions::tolerance>("tolerance"),
    option<&RunOptions::max_iterations>("max-iterations"),
    option<&RunOptions::probes, store_list>("probe"),
    option<&RunOptions::coordinates, store_list>("coordinate"),
    option<&RunOptions::velocities>("velocities"),
    option<&RunOptions::deflect>("deflect"),
    option<&RunOptions::start>("start"),
    option<&RunOptions::out>("out"),
    option<&RunOptions::every>("every"),
    option<&RunOptions::plot>("plot"),
    option<&RunOptions::surfaces>("surfaces"),
    option<&RunOptions::surface_format>("surface-format"),
    option<&RunOptions::hull>("hull"),
    flag_only<&RunOptions::wav>("wav"),
    flag_only<&RunOptions::listen>("listen"),
    flag_only<&RunOptions::save>("save"),
    flag_only<&RunOptions::restore>("restore"),
};

Status read_body(const std::string& path, const toml::table& table, RunOptions& body) {
  for (const auto& [key, node] : table) {
    const Option* known = nullptr;
    for (const Option& candidate : kOptions)
      if (candidate.name == key.str() && candidate.store != nullptr) known = &candidate;
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
    return error_at(path, table.source(),
                    "body '" + body.name +
                        "': `damping-ratio` gives the damping: leave `alpha` and `beta` out");
  body.scene = path;
  body.model = beside(path, body.model);
  if (!body.signal.empty()) body.signal = beside(path, body.signal);
  if (!file_of_start(body.start).empty()) body.start = beside(path, body.start);
  return Success{};
}

}  // namespace

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
    if (!is_folder_name(body.name))
      return error_at(path, name.source(),
                      "body '" + body.name + "': a name has letters, digits, '.', '_', '-' only");
    if (Status status = read_body(path, *table, body); !status) return status.error();
    bodies.push_back(std::move(body));
  }
  if (bodies.empty()) return content_error(path + ": the scene has no body");
  return bodies;
}

void put_over(const GivenFlags& flags, RunOptions& options) {
  for (const Option& option : kOptions)
    if (flags.given(("--" + std::string(option.name)).c_str())) option.copy(flags.values, options);
  if (flags.given("--load")) {
    options.signal.clear();
    if (!flags.given("--frequency")) options.shape.frequency.reset();
    if (!flags.given("--sweep")) options.shape.sweep.clear();
  }
  if (flags.given("--alpha") || flags.given("--beta")) options.damping_ratio.clear();
  if (flags.given("--scale")) options.deflect.clear();
  if (flags.given("--deflect")) options.scale = 1.0;
  if (options.wav.empty() || flags.given("--step")) return;
  options.step = kSoundStep;
  options.sound_steps = 0;
}

}  // namespace tremolo
