#include "precompute/mesher/cgal/refinement_watch.h"

#include <cstdio>
#include <stdexcept>

#include "common/format_text.h"

namespace tremolo {
namespace {

// Queries without a new vertex before refinement counts as stuck. Of 300 surfaces none that could
// be meshed made more than 3 700 in a row, or seven for each vertex.
constexpr std::uint64_t kStillAtLeast = 20'000;
constexpr std::uint64_t kStillPerVertex = 60;

}  // namespace

RefinementWatch::RefinementWatch(const WatchLimits& limits)
    : limits_(limits), start_(std::chrono::steady_clock::now()), next_report_(limits.seconds) {}

void RefinementWatch::check() {
  if (steps_ - still_since_ > kStillAtLeast + kStillPerVertex * vertices_)
    throw std::runtime_error("refinement makes no progress");
  if ((limits_.most_steps > 0 && steps_ > limits_.most_steps) ||
      (limits_.most_vertices > 0 && vertices_ > limits_.most_vertices))
    throw std::runtime_error("refinement does not come to an end");
  const auto passed = std::chrono::steady_clock::now() - start_;
  const double seconds = std::chrono::duration<double>(passed).count();
  if (seconds < next_report_) return;
  next_report_ = 2 * seconds;
  std::fprintf(stderr, "  %s\n", progress_text(vertices_, limits_.expected, seconds).c_str());
}

std::string progress_text(std::size_t vertices, std::size_t expected, double seconds) {
  if (expected == 0) return text("meshing: %zu vertices, %.0f s", vertices, seconds);
  const std::string so_far =
      text("meshing: %zu of about %zu vertices, %.0f s", vertices, expected, seconds);
  if (vertices == 0 || vertices >= expected) return so_far + ", more of them than usual";
  const double left = seconds * static_cast<double>(expected - vertices);
  return so_far + text(", about %.0f s more", left / static_cast<double>(vertices));
}

}  // namespace tremolo
