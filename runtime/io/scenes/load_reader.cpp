// The keys of a load in time on a body.
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "runtime/io/scenes/csv_rows.h"
#include "runtime/io/scenes/part_readers.h"

namespace tremolo {
namespace {

SignalShape read_shape(TomlKeys& keys) {
  SignalShape shape;
  const auto read = [&keys](const char* key, std::optional<double>& target) {
    double value = 0.0;
    keys.read(key, value);
    if (keys.has(key)) target = value;
  };
  read("frequency", shape.frequency);
  read("load-duration", shape.duration);
  const toml::node* sweep = keys.find("sweep");
  if (sweep == nullptr) return shape;
  const auto text = sweep_text(*sweep);
  if (!text) keys.fail("sweep", "'sweep' must be two frequencies in Hz, as in [1, 20]");
  shape.sweep = text.value_or("");
  return shape;
}

}  // namespace

Result<std::vector<SceneLoad>> read_load(TomlKeys& keys, const std::string& usual,
                                         std::vector<std::string>& files) {
  std::string name = usual, csv;
  SceneLoad load;
  keys.read("load", name);
  keys.read_path("signal", csv);
  SignalShape shape = read_shape(keys);
  keys.read_text_or_number("at", load.at);
  keys.read("scale", load.scale);
  const toml::node* force = keys.find("force");
  if (force != nullptr && force->is_string())
    keys.fail("force", "'force' must be a list of 3 finite numbers, N");
  else
    keys.read("force", load.force);
  if (keys.has("signal") && keys.has("load"))
    keys.fail("signal", "`signal` and `load` are two courses of one load: leave one out");
  if (keys.has("at") != keys.has("force")) keys.fail("at", "`at` and `force` belong together");
  if (!keys.good()) return std::vector<SceneLoad>{};
  if (!csv.empty()) {
    files.push_back(csv);
    Result<SignalTable> table = read_signal(csv);
    if (!table) return table.error();
    load.table = std::make_shared<const SignalTable>(std::move(*table));
    load.signal = {.kind = SignalKind::kTable};
  } else {
    const Result<Signal> signal = parse_signal(name);
    if (!signal) {
      keys.fail("load", signal.error().message);
      return std::vector<SceneLoad>{};
    }
    load.signal = *signal;
  }
  if (const Status shaped = shape_signal(shape, load.signal); !shaped) {
    keys.fail(keys.has("load") ? "load" : "signal", shaped.error().message);
    return std::vector<SceneLoad>{};
  }
  if (load.signal.kind == SignalKind::kNone) {
    if (keys.has("at")) keys.fail("at", "a force needs a course in time: say `load` or `signal`");
    if (keys.has("scale"))
      keys.fail("scale", "it multiplies a load, and there is none: say `load` or `signal`");
    return std::vector<SceneLoad>{};
  }
  return std::vector<SceneLoad>{std::move(load)};
}

Result<std::vector<SceneLoad>> read_loads(TomlKeys& keys, const std::string& path,
                                          const std::string& what,
                                          std::vector<std::string>& files) {
  Result<std::vector<SceneLoad>> loads = read_load(keys, "none", files);
  if (!loads) return loads;
  for (const toml::table* entry : keys.read_tables("loads")) {
    TomlKeys load_keys(*entry, path, what + ", loads");
    Result<std::vector<SceneLoad>> more = read_load(load_keys, "square", files);
    if (!more) return more;
    if (Status s = load_keys.finish(); !s) return s.error();
    std::move(more->begin(), more->end(), std::back_inserter(*loads));
  }
  return loads;
}

}  // namespace tremolo
