// Time per picture.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <vector>

namespace tremolo {

// Medians over the last pictures, ms. Posing (the engine's positions and normals, their boxes, the
// panel) is measured in processor time of this thread; drawing, from the upload to the finished
// pixels, in elapsed time. The first picture, which also creates the resources, is left out if
// there are more.
class FrameTimes {
 public:
  using Clock = std::chrono::steady_clock;

  void begin() { begun_ = processor_ms(); }
  // Since begin(), processor time.
  double so_far() const { return processor_ms() - begun_; }
  void prepared() {
    keep(prepare_, so_far());
    prepared_ = Clock::now();
  }
  void drawn() {
    keep(draw_, std::chrono::duration<double, std::milli>(Clock::now() - prepared_).count());
  }

  double prepare_ms() const { return median(prepare_); }
  double draw_ms() const { return median(draw_); }

  // Without the first; 0 of none.
  static double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    if (values.size() > 1) values.erase(values.begin());
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  }

 private:
  static constexpr std::size_t kKept = 300;

  static double processor_ms() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
  }
  static void keep(std::vector<double>& values, double value) {
    if (values.size() >= kKept) values.erase(values.begin());
    values.push_back(value);
  }

  double begun_ = 0.0;
  Clock::time_point prepared_;
  std::vector<double> prepare_, draw_;
};

}  // namespace tremolo
