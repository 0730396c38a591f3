// Scenes of `tremolo run`.
#include "runtime/apps/tremolo/run/run_options.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<std::vector<RunOptions>> bodies = parse_scene(bytes, "folder/input.toml");
  check_error(bodies);
  if (!bodies) return;
  if (bodies->empty()) finding("a scene without a body");
  for (const RunOptions& body : *bodies)
    if (body.name.empty() || body.model.empty() || body.name.find('/') != std::string::npos)
      finding("a body without a name or a model");
    else if (body.model.find('\0') != std::string::npos)
      finding("a path that continues beyond its end");
}
