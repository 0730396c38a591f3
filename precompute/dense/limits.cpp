#include "precompute/dense/limits.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <unistd.h>
#include <vector>

#include "common/parallel.h"
#include "precompute/dense/blas.h"
#include "precompute/dense/lanes.h"
#include "precompute/system/blas_threads.h"

namespace tremolo {
namespace {

// Returns the shortest time of five runs of `body` on all threads at once, s.
template <class Body>
double shortest(unsigned threads, const Body& body) {
  double best = 1e30;
  for (int run = 0; run < 5; ++run) {
    const auto start = std::chrono::steady_clock::now();
    parallel_for(threads, threads, body);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    best = std::min(best, elapsed.count());
  }
  return best;
}

TREMOLO_CLONES double sum_of(const LaneBlock* blocks, std::size_t count) {
  Lanes sums[8] = {};
  for (std::size_t i = 0; i + 8 <= count; i += 8)
    for (std::size_t k = 0; k < 8; ++k) sums[k] += blocks[i + k].at;
  double total = 0;
  for (const Lanes& sum : sums)
    for (std::size_t lane = 0; lane < kLanes; ++lane) total += sum[lane];
  return total;
}

}  // namespace

MachineLimits measure_machine(unsigned threads) {
  MachineLimits machine;
  const BlasThreads single(1);
  constexpr Eigen::Index kSize = 512;
  constexpr int kProducts = 4;
  std::vector<Eigen::MatrixXd> results(threads, Eigen::MatrixXd::Zero(kSize, kSize));
  const Eigen::MatrixXd factor = Eigen::MatrixXd::Constant(kSize, kSize, 1e-3);
  const double product_seconds = shortest(threads, [&](std::size_t i) {
    for (int k = 0; k < kProducts; ++k) add_product(1.0, factor, factor, 0.0, results[i]);
  });
  machine.flops = threads * kProducts * 2.0 * kSize * kSize * kSize / product_seconds;

  machine.last_level_bytes = static_cast<double>(std::max(0L, ::sysconf(_SC_LEVEL3_CACHE_SIZE)));
  constexpr std::size_t kBlocks = std::size_t{1} << 21;  // 128 MiB a thread: larger than the caches
  std::vector<std::vector<LaneBlock>> memory(threads, std::vector<LaneBlock>(kBlocks));
  std::vector<double> sums(threads, 0.0);
  const double read_seconds =
      shortest(threads, [&](std::size_t i) { sums[i] += sum_of(memory[i].data(), kBlocks); });
  // The sums must be used, or the compiler could remove the reads.
  machine.bytes = threads * static_cast<double>(kBlocks * sizeof(LaneBlock)) / read_seconds +
                  std::accumulate(sums.begin(), sums.end(), 0.0);
  return machine;
}

StageLimit stage_limit(const MachineLimits& machine, const StageWork& work) {
  if (machine.flops == 0) return {};
  const double arithmetic = work.flops / machine.flops;
  const double before = work.added_flops / machine.flops;
  const bool from_memory = work.factor_bytes > machine.last_level_bytes;
  const double reading = from_memory ? work.passes * work.factor_bytes / machine.bytes : 0.0;
  StageLimit limit;
  limit.seconds = before + std::max(arithmetic, reading);
  char text[200];
  if (work.passes > 0)
    std::snprintf(text, sizeof(text),
                  "%.3g GFLOP to factorise; solves %.3g GFLOP, %.3g passes over %.3g GB%s",
                  1e-9 * work.added_flops, 1e-9 * work.flops, work.passes, 1e-9 * work.factor_bytes,
                  from_memory ? "" : " (in cache: not counted)");
  else
    std::snprintf(text, sizeof(text), "%.3g GFLOP at %.3g GFLOP/s", 1e-9 * work.flops,
                  1e-9 * machine.flops);
  limit.reason = text;
  return limit;
}

void set_limit(const MachineLimits& machine, const StageWork& work, StageLog& log) {
  const StageLimit limit = stage_limit(machine, work);
  if (limit.seconds > 0) log.limit(limit.seconds, limit.reason);
}

}  // namespace tremolo
