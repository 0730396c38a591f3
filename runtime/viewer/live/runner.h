// The world on a thread of its own, kept at the pace of the clock.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "runtime/viewer/camera/camera.h"
#include "runtime/viewer/live/hand_record.h"
#include "runtime/viewer/live/live_world.h"

namespace tremolo {

// Sums over the bodies, J. high: of the high band, as Energy::high_band.
struct EnergySample {
  double time = 0.0;  // s
  double kinetic = 0.0, potential = 0.0, high = 0.0;
};

// What the thread tells. step_ms: of the last steps, by the clock, their mean. pace: simulated over
// real time of the last second, wanted what was asked for; below it the world lags. lost: real
// time, s, that could not be kept and was given up. energies: the last kEnergySamples looks.
// latencies: ms from a mouse's event to a state that knows of it, the last ones.
struct RunnerReport {
  double time = 0.0;
  std::int64_t steps = 0;
  double step_ms = 0.0, pace = 0.0, wanted = 1.0, lost = 0.0;
  bool paused = false;
  std::int64_t contacts = 0;
  int active_contacts = 0;
  std::vector<EnergySample> energies;
  std::vector<double> latencies;
  std::vector<std::string> methods;  // of the bodies
  std::string trouble;
  bool holds = false;
};
inline constexpr std::size_t kEnergySamples = 400, kLatencies = 1000;

class Runner {
 public:
  using Clock = std::chrono::steady_clock;
  using Work = std::function<void(LiveWorld&)>;

  // The world belongs to the thread from now on. record: whether hands are recorded.
  Runner(LiveWorld world, double rate, bool paused, bool record);
  ~Runner();
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  // Done between two steps, in the order of the calls; what it changes is seen at once, also while
  // the world is paused.
  void post(Work work);
  // Waits until what was posted is done.
  void settle();
  void set_rate(double rate);
  void set_paused(bool paused);
  void step_once();

  // Takes hold of what the ray meets; pressed() then says whether it did, until the next press. It
  // did not where the ray passes by, or meets what cannot be held, which the report's trouble
  // tells.
  void press(const CameraRay& ray, double firmness);
  std::optional<bool> pressed() const;  // empty: it is not yet known
  Eigen::Vector3d grabbed_at() const;   // m, world
  // Where the hand shall be, from where it began; event: when the mouse said so.
  void pull(const Eigen::Vector3d& way, Clock::time_point event);
  void let_go();

  // The world now, between its last two steps.
  void look(WorldMoment& moment) const;
  RunnerReport report() const;
  // Shown as the report's trouble.
  void complain(const std::string& trouble);
  std::string method_of(std::size_t body) const;
  // Ends the thread and gives the world back.
  LiveWorld stop();
  const HandRecord& hand_record() const { return record_; }  // after stop()

 private:
  void run();
  bool do_work();
  void follow_clock();
  void make_step();
  void publish(bool stepped);
  void take_sample();
  void tell_methods();
  double clock_time(Clock::time_point now) const;
  void set_clock(double time, Clock::time_point now);

  LiveWorld world_;
  HandRecord record_;
  bool records_ = false;
  mutable std::mutex mutex_;  // of all below
  std::condition_variable wake_;
  std::deque<Work> work_;
  bool stopped_ = false, busy_ = false, single_ = false;
  double rate_ = 1.0, anchor_time_ = 0.0;
  Clock::time_point anchor_;
  WorldMoment before_, now_;
  RunnerReport report_;
  std::optional<bool> pressed_;
  Eigen::Vector3d grabbed_at_ = Eigen::Vector3d::Zero();
  std::optional<std::pair<Eigen::Vector3d, Clock::time_point>> pull_;
  // These belong to the thread alone.
  std::optional<Clock::time_point> answers_;  // the event that the step knows of
  double next_sample_ = 0.0;
  Clock::time_point second_began_;
  double second_time_ = 0.0;
  std::thread thread_;
};

}  // namespace tremolo
