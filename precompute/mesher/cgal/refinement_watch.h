// Bounds the work of refinement, and reports its progress.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace tremolo {

// Limits of refinement. Time has no influence on the mesh.
struct WatchLimits {
  std::size_t most_steps = 0;     // queries about facets in all; 0: no limit
  std::size_t most_vertices = 0;  // inserted vertices; 0: no limit
  std::size_t expected = 0;       // number of vertices that the mesh is likely to get; 0: unknown
  double seconds =
      5;  // elapsed time until the first line on stderr; it doubles for each further one
};

// Mesh_3 (CGAL 5.5) may query the same facets repeatedly without a new vertex, or insert vertices
// ever closer to a corner whose neighbours increase in number; the watch ends both after a count of
// queries that is the same on every machine.
class RefinementWatch {
 public:
  explicit RefinementWatch(const WatchLimits& limits);

  // Counts one query while the mesh has so many vertices. Throws std::runtime_error beyond the
  // bounds.
  void step(std::size_t vertices) {
    ++steps_;
    if (vertices != vertices_) {
      vertices_ = vertices;
      still_since_ = steps_;
    }
    if ((steps_ & kCheckMask) == 0) check();
  }

  std::uint64_t steps() const { return steps_; }

 private:
  // A mask: the bounds are checked at every 1024th query.
  static constexpr std::uint64_t kCheckMask = 1023;
  void check();

  WatchLimits limits_;
  std::uint64_t steps_ = 0;
  std::uint64_t still_since_ = 0;
  std::size_t vertices_ = 0;
  std::chrono::steady_clock::time_point start_;
  double next_report_;  // s after start_
};

// "meshing: 1200 of about 4000 vertices, 5 s, about 12 s more"
std::string progress_text(std::size_t vertices, std::size_t expected, double seconds);

}  // namespace tremolo
