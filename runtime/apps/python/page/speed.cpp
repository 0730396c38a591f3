// The time of the engine's own call for the positions of a surface, for speed.py.
//
// usage: tremolo_python_speed MODEL.tremolo CALLS; prints microseconds a call of float and of
// double.
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "common/processor.h"
#include "runtime/contact_body.h"

namespace {

using namespace tremolo;

template <class Call>
double microseconds(int calls, const Call& call) {
  const double begin = processor_time();
  for (int k = 0; k < calls; ++k)
    if (!call()) std::exit(4);
  return 1e6 * (processor_time() - begin) / calls;
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) return 2;
  const int calls = std::atoi(words[2]);
  const auto model = Model::load(words[1]);
  if (!model || calls < 1) return 3;
  IntegratorOptions options;
  options.step = 1e-4;
  const auto body = ContactBody::create(*model, "verlet", options, FrameKind::kFixed);
  if (!body) return 3;
  const std::size_t size = 3 * (*model)->drawn().rest.size();
  std::vector<float> small(size);
  std::vector<double> large(size);
  const double of_float =
      microseconds(calls, [&] { return static_cast<bool>(body->surface(std::span(small))); });
  const double of_double = microseconds(
      calls, [&] { return static_cast<bool>(body->surface_positions(std::span(large))); });
  std::printf("%.4f %.4f\n", of_float, of_double);
}
