// The C++ library as a game would use it: load, push, step, fetch positions.
#include <cmath>
#include <cstdio>
#include <tremolo/runtime/body.h>
#include <vector>

int main(int count, char** words) {
  if (count != 2) return 2;
  const auto model = tremolo::Model::load(words[1]);
  if (!model) {
    std::fprintf(stderr, "%s\n", model.error().message.c_str());
    return tremolo::exit_code(model.error());
  }
  auto body = tremolo::Body::create(*model, "imexv", {});
  if (!body) return tremolo::exit_code(body.error());
  const auto vertex = (*model)->surface().vertex_ids.back();
  if (!body->apply_force(vertex, {0.0, 0.0, 1.0}, 10)) return 1;
  for (int step = 0; step < 100; ++step)
    if (!body->step().converged) return 4;
  std::vector<float> positions(3 * (*model)->drawn().rest.size());
  if (!body->surface(std::span<float>(positions))) return 1;
  std::printf("energy %g J after %g s, last vertex at %g %g %g m\n", body->energy().total(),
              body->time(), positions[positions.size() - 3], positions[positions.size() - 2],
              positions.back());
  return std::isfinite(body->energy().total()) ? 0 : 5;
}
