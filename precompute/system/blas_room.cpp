#include "precompute/system/blas_room.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sched.h>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

extern "C" {
void* blas_memory_alloc(int) __attribute__((weak));
void blas_memory_free(void*) __attribute__((weak));
int openblas_get_num_threads() __attribute__((weak));
// The entry point behind `#pragma omp parallel num_threads(threads)`.
void GOMP_parallel(void (*work)(void*), void* data, unsigned threads, unsigned flags)
    __attribute__((weak));
}

namespace tremolo {
namespace {

constexpr std::size_t kBuffer =
    (std::size_t{128} << 20) + 4096;  // size of one of OpenBLAS's buffers, 64-bit
// OpenBLAS has buffers for at most twice this number of threads.
constexpr unsigned kMostThreads = 64;
// A thread's stack, and its malloc arena in the C library.
constexpr std::size_t kStack = std::size_t{8} << 20;
constexpr std::size_t kArena = std::size_t{64} << 20;
// CHOLMOD uses this number of OpenMP threads for a factor, whatever the settings; the caller is
// one.
constexpr unsigned kFactorThreads = 4;
// Room for the libraries and a small mesh.
constexpr std::size_t kRest = std::size_t{64} << 20;

bool can_map(std::size_t bytes) {
  void* region = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (region == MAP_FAILED) return false;
  ::munmap(region, bytes);
  return true;
}

// Grows this thread's stack to the size it may need. Stacks grow on demand, and if no address space
// is left then, the program dies by SIGSEGV.
void grow_stack() {
  constexpr std::size_t kDepth = std::size_t{4} << 20;
  struct rlimit most = {};
  if (::getrlimit(RLIMIT_STACK, &most) != 0 || most.rlim_cur < kDepth + kDepth / 2) return;
  [[maybe_unused]] volatile char deep[kDepth];
  deep[0] = 0;
}

// Starts OpenMP's threads now. If they could not be started during a factorisation, OpenMP would
// end the program.
void start_factor_threads() {
  if (GOMP_parallel != nullptr) GOMP_parallel([](void*) {}, nullptr, kFactorThreads, 0);
}

// Returns the mapped address space, bytes. It does not use the C++ library, which may not be
// initialised yet.
std::size_t mapped_bytes() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  unsigned long pages = 0;
  if (file != nullptr) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

// Returns the first variable read by OpenBLAS that is a number, else the number of processors that
// this process may use.
int blas_threads_at_start(char** environment) {
  for (const char* name : {"OPENBLAS_NUM_THREADS=", "GOTO_NUM_THREADS=", "OMP_NUM_THREADS="})
    for (char** entry = environment; entry != nullptr && *entry != nullptr; ++entry)
      if (std::strncmp(*entry, name, std::strlen(name)) == 0)
        if (const int count = std::atoi(*entry + std::strlen(name)); count > 0) return count;
  cpu_set_t processors;
  if (::sched_getaffinity(0, sizeof(processors), &processors) != 0) return 1;
  return std::max(1, CPU_COUNT(&processors));
}

// Writes "..., N MB of address space" with a remedy. needed: bytes beyond what is mapped; least:
// the same with one thread.
void describe(char* text, std::size_t size, std::size_t needed, std::size_t least) {
  const auto megabytes = [](std::size_t bytes) { return (bytes + 999'999) / 1'000'000; };
  const std::size_t mapped = mapped_bytes();
  char limit[80] = "";
  struct rlimit most = {};
  if (::getrlimit(RLIMIT_AS, &most) == 0 && most.rlim_cur != RLIM_INFINITY)
    std::snprintf(limit, sizeof(limit), ", the limit (ulimit -v) is %zu MB",
                  megabytes(most.rlim_cur));
  std::snprintf(text, size,
                "out of memory: OpenBLAS keeps %zu MB for each thread; %zu MB of address space "
                "would do for the start%s. Raise the limit, or take fewer threads: with "
                "OPENBLAS_NUM_THREADS=1 and --threads 1 it is %zu MB",
                megabytes(kBuffer), megabytes(mapped + needed), limit, megabytes(mapped + least));
}

}  // namespace

void require_room_for_blas(char** environment) {
  if (openblas_get_num_threads == nullptr) return;
  const std::size_t threads =
      std::min(static_cast<unsigned>(blas_threads_at_start(environment)), kMostThreads);
  const std::size_t needed = threads * (kBuffer + kStack) + kRest;
  if (can_map(needed)) return;
  // An estimate of what take_room_for_blas() will need with as many threads of our own.
  const std::size_t later_bytes = (2 * threads - 1) * (kBuffer + kStack) + (threads - 1) * kArena +
                                  (kFactorThreads - 1) * kStack + kRest;
  char reason[400];
  describe(reason, sizeof(reason), later_bytes, kBuffer + kStack + kRest);
  char line[450];
  const int length = std::snprintf(line, sizeof(line), "tremolo-precompute: %s\n", reason);
  // A failure to write is ignored: there is no other way to report it.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line, length);
  ::_exit(static_cast<int>(ErrorKind::kSystem));
}

void take_room_for_blas(unsigned threads) {
  grow_stack();
  if (openblas_get_num_threads == nullptr) return;
  threads = std::min(threads, kMostThreads);
  // Each OpenBLAS thread keeps one buffer from its first call on; there is one thread less than
  // requested, since the caller works too.
  const auto own = std::max(static_cast<int>(threads), openblas_get_num_threads()) - 1;
  const std::size_t count = threads + own;
  const std::size_t other_bytes =
      static_cast<std::size_t>(own) * kArena + (kFactorThreads - 1) * kStack + kRest;
  const auto require_room = [&](std::size_t buffers) {
    const std::size_t needed = buffers * (kBuffer + kStack) + other_bytes;
    if (can_map(needed)) return;
    char reason[400];
    describe(reason, sizeof(reason), needed, kBuffer + kStack + kRest);
    throw Failure(system_error(reason));
  };
  require_room(count);
  const BlasThreads all(static_cast<int>(threads));
  if (blas_memory_alloc == nullptr || blas_memory_free == nullptr) return start_factor_threads();
  std::vector<void*> buffers;
  for (std::size_t i = 0; i < count; ++i) {
    // Threads that OpenBLAS has started meanwhile use address space as well.
    require_room(count - i);
    buffers.push_back(blas_memory_alloc(0));
  }
  // The buffers return to OpenBLAS, which keeps them mapped.
  for (void* buffer : buffers) blas_memory_free(buffer);
  // This comes last, since the threads' own memory counts as well.
  start_factor_threads();
}

}  // namespace tremolo
