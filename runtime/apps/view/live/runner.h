// The world on its own thread, kept at the pace of the clock.
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

#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/live/hand_record.h"
#include "runtime/apps/view/live/live_world.h"

namespace tremolo {

// Sums over the bodies, J. high: of the high band, as Energy::high_band.
struct EnergySample {
  double time = 0.0;  // s
  double kinetic = 0.0, potential = 0.0, high = 0.0;
};

// Statistics of the thread.
struct RunnerReport {
  double time = 0.0;  // s, simulated
  std::int64_t steps = 0;
  double step_ms = 0.0;  // mean elapsed time of the last steps
  double pace = 0.0;     // simulated over real time of the last second
  double wanted = 1.0;   // the requested pace; the world lags where `pace` is below it
  double lost = 0.0;  // s of real time by which the world has fallen behind and does not catch up
  bool paused = false;
  std::int64_t contacts = 0;
  int active_contacts = 0;
  std::vector<EnergySample> energies;  // the last kEnergySamples
  std::vector<double> latencies;     // ms from a mouse event to a state that includes it, the last
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

  // Runs `work` between two steps, in the order of the calls. Its effect is shown at once, also
  // while the world is paused.
  void post(Work work);
  // Waits until all posted work is done.
  void settle();
  void set_rate(double rate);
  void set_paused(bool paused);
  void step_once();

  // Grabs the point that the ray hits; pressed() then returns whether it did, until the next press.
  // It fails if the ray hits nothing, or a body that cannot be grabbed; the report's trouble gives
  // the reason.
  void press(const CameraRay& ray, double firmness);
  std::optional<bool> pressed() const;  // empty: it is not yet known
  Eigen::Vector3d grabbed_at() const;   // m, world
  // way: displacement of the hand since the grab, m, world; event: time of the mouse event.
  void pull(const Eigen::Vector3d& way, Clock::time_point event);
  void let_go();

  // Gets the world now, interpolated between its last two steps.
  void look(WorldMoment& moment) const;
  RunnerReport report() const;
  // Shown as the report's trouble.
  void complain(const std::string& trouble);
  std::string method_of(std::size_t body) const;
  // Ends the thread and returns the world.
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
  // Members that only the thread uses.
  std::optional<Clock::time_point> answers_;  // the event that the step includes
  double next_sample_ = 0.0;
  Clock::time_point second_began_;
  double second_time_ = 0.0;
  std::thread thread_;
};

}  // namespace tremolo
