// What pictures cost.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace tremolo {

// Medians over pictures, ms by the clock: of posing (the engine's positions and normals, the boxes
// around them) and of drawing until the pixels are there, the upload included. The first picture,
// which makes what is made once, does not count where there are more.
class FrameTimes {
 public:
  using Clock = std::chrono::steady_clock;

  void begin() { begun_ = Clock::now(); }
  void prepared() {
    prepared_ = Clock::now();
    prepare_.push_back(ms(prepared_ - begun_));
  }
  void drawn() { draw_.push_back(ms(Clock::now() - prepared_)); }

  double prepare_ms() const { return median(prepare_); }
  double draw_ms() const { return median(draw_); }

  static double ms(Clock::duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
  }
  // Without the first; 0 of none.
  static double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    if (values.size() > 1) values.erase(values.begin());
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  }

 private:
  Clock::time_point begun_, prepared_;
  std::vector<double> prepare_, draw_;
};

}  // namespace tremolo
