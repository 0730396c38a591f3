// Keeps refinement from going on for ever, and tells how far it is.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace tremolo {

// most_steps: questions about facets that refinement may ask in all; most_vertices: that it may
// set; 0: no bound on their number.
// expected: vertices that the mesh is likely to get, 0: not known. seconds: by the clock, until
// the first line on stderr; the next comes after twice as long. It has no say in what comes out.
struct WatchLimits {
  std::size_t most_steps = 0;
  std::size_t most_vertices = 0;
  std::size_t expected = 0;
  double seconds = 5;
};

// Mesh_3 (CGAL 5.5) may ask about the same facets again and again without a new vertex, or set
// vertices ever nearer to a corner whose neighbours grow in number; both end here after the same
// count of questions on every machine.
class RefinementWatch {
 public:
  explicit RefinementWatch(const WatchLimits& limits);

  // One question, while there are so many vertices. Throws std::runtime_error behind the bounds.
  void step(std::size_t vertices) {
    ++steps_;
    if (vertices != vertices_) {
      vertices_ = vertices;
      still_since_ = steps_;
    }
    if ((steps_ & kLook) == 0) look();
  }

  std::uint64_t steps() const { return steps_; }

 private:
  // Questions between two looks at the bounds, less one; a power of two, less one.
  static constexpr std::uint64_t kLook = 1023;
  void look();

  WatchLimits limits_;
  std::uint64_t steps_ = 0;
  std::uint64_t still_since_ = 0;
  std::size_t vertices_ = 0;
  std::chrono::steady_clock::time_point start_;
  double tell_at_;  // s behind start_
};

// "meshing: 1200 of about 4000 vertices, 5 s, about 12 s more"
std::string progress_text(std::size_t vertices, std::size_t expected, double seconds);

}  // namespace tremolo
