// Bounds the work of refinement, and reports its progress.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace tremolo {

// most_steps: queries about facets that refinement may make in all; most_vertices: those that it
// may insert; 0: no bound. expected: vertices that the mesh is likely to get, 0 if unknown.
// seconds: of wall-clock time until the first line on stderr; each further one comes after twice as
// long. Time has no influence on the mesh.
struct WatchLimits {
  std::size_t most_steps = 0;
  std::size_t most_vertices = 0;
  std::size_t expected = 0;
  double seconds = 5;
};

// Mesh_3 (CGAL 5.5) may query the same facets again and again without a new vertex, or insert
// vertices ever nearer to a corner whose neighbours grow in number; the watch ends both after a
// count of queries that is the same on every machine.
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
