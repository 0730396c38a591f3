// The peak rates of one core of this machine, measured in loops that do nothing else.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/processor.h"
#include "tests/lab/speed/speed.h"

namespace tremolo::bench {
namespace {

template <class Real>
[[gnu::always_inline]] inline Real multiply_add_chains(Real factor, int rounds) {
  typedef Real Vector __attribute__((vector_size(64)));
  constexpr std::size_t kChains = 12;  // enough to hide the latency of a multiply-add
  Vector chains[kChains];
  for (std::size_t i = 0; i < kChains; ++i) chains[i] = Vector{} + Real(i);
  const Vector a = Vector{} + factor;
  const Vector b = Vector{} + Real(1e-9);
  for (int round = 0; round < rounds; ++round)
    for (Vector& chain : chains) chain = chain * a + b;
  Vector sum = chains[0];
  for (std::size_t i = 1; i < kChains; ++i) sum += chains[i];
  Real total = 0;
  for (std::size_t i = 0; i < 64 / sizeof(Real); ++i) total += sum[i];
  return total;
}

TREMOLO_CLONES double chains_f64(double factor, int rounds) {
  return multiply_add_chains<double>(factor, rounds);
}
TREMOLO_CLONES float chains_f32(float factor, int rounds) {
  return multiply_add_chains<float>(factor, rounds);
}

TREMOLO_CLONES double sum_all(const double* x, std::size_t count) {
  typedef double Vector __attribute__((vector_size(64)));
  Vector s[8] = {};
  for (std::size_t i = 0; i + 64 <= count; i += 64)
    for (std::size_t lane = 0; lane < 8; ++lane)
      s[lane] += *reinterpret_cast<const Vector*>(x + i + 8 * lane);
  double total = 0.0;
  for (const Vector& v : s)
    for (int i = 0; i < 8; ++i) total += v[i];
  return total;
}

volatile double sink = 0.0;

double best_seconds(int windows, const auto& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int window = 0; window < windows; ++window) {
    const double before = processor_time();
    work();
    best = std::min(best, processor_time() - before);
  }
  return best;
}

double read_bandwidth(std::size_t bytes) {
  std::vector<double> storage(bytes / sizeof(double) + 8, 1.0);
  double* first = storage.data();
  while (reinterpret_cast<std::uintptr_t>(first) % 64 != 0) ++first;
  const std::size_t count = bytes / sizeof(double);
  const int repeats = static_cast<int>(std::max<std::size_t>(1, (std::size_t{64} << 20) / bytes));
  const double seconds = best_seconds(12, [&] {
    for (int k = 0; k < repeats; ++k) sink = sum_all(first, count);
  });
  return 1e-9 * static_cast<double>(bytes) * repeats / seconds;
}

}  // namespace

std::vector<double> by_turns(const std::vector<Work>& works, int calls, int windows) {
  std::vector<double> best(works.size(), std::numeric_limits<double>::infinity());
  for (int window = 0; window < windows; ++window)
    for (std::size_t w = 0; w < works.size(); ++w) {
      const double before = processor_time();
      for (int call = 0; call < calls; ++call) works[w]();
      best[w] = std::min(best[w], (processor_time() - before) / calls);
    }
  return best;
}

MachineProbe probe_machine() {
  constexpr int kRounds = 100000;
  constexpr double kOperations = 2.0 * 12.0 * kRounds;  // a lane
  MachineProbe probe;
  probe.gflops =
      1e-9 * 8 * kOperations / best_seconds(12, [] { sink = chains_f64(0.999999, kRounds); });
  probe.gflops_f32 = 1e-9 * 16 * kOperations / best_seconds(12, [] {
                       sink = static_cast<double>(chains_f32(0.9999f, kRounds));
                     });
  probe.l2_bandwidth = read_bandwidth(std::size_t{512} << 10);
  probe.l3_bandwidth = read_bandwidth(std::size_t{6} << 20);
  probe.memory_bandwidth = read_bandwidth(std::size_t{256} << 20);
  probe.vectors = "plain";
#if defined(__x86_64__) && defined(__GNUC__) && !defined(TREMOLO_SANITIZED)
  if (__builtin_cpu_supports("x86-64-v4"))
    probe.vectors = "AVX-512";
  else if (__builtin_cpu_supports("x86-64-v3"))
    probe.vectors = "AVX2";
#endif
  return probe;
}

}  // namespace tremolo::bench
