#include "runtime/apps/view/live/runner.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremolo {
namespace {

constexpr double kMostBehind = 0.1;          // s of real time; more delay is dropped
constexpr double kSampleEvery = 1.0 / 60.0;  // s of simulated time
constexpr double kForget = 0.05;             // of the mean of step times, a step
constexpr std::chrono::milliseconds kNap{2};

double seconds(Runner::Clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

Runner::Runner(LiveWorld world, double rate, bool paused, bool record)
    : world_(std::move(world)), records_(record), rate_(rate) {
  before_ = world_.before();
  now_ = world_.now();
  report_.paused = paused;
  report_.wanted = rate;
  set_clock(now_.time, Clock::now());
  second_began_ = Clock::now();
  take_sample();
  tell_methods();
  thread_ = std::thread([this] { run(); });
}

Runner::~Runner() {
  if (thread_.joinable()) (void)stop();
}

LiveWorld Runner::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.notify_all();
  thread_.join();
  record_.end(world_.world().time());
  return std::move(world_);
}

void Runner::post(Work work) {
  {
    const std::lock_guard lock(mutex_);
    work_.push_back(std::move(work));
  }
  wake_.notify_all();
}

void Runner::settle() {
  std::unique_lock lock(mutex_);
  while (!work_.empty() || busy_) wake_.wait_for(lock, kNap);
}

double Runner::clock_time(Clock::time_point now) const {
  return report_.paused ? anchor_time_ : anchor_time_ + rate_ * seconds(now - anchor_);
}

void Runner::set_clock(double time, Clock::time_point now) {
  anchor_time_ = time;
  anchor_ = now;
}

void Runner::set_rate(double rate) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  set_clock(clock_time(now), now);
  rate_ = report_.wanted = rate;
}

void Runner::set_paused(bool paused) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  set_clock(std::min(clock_time(now), now_.time), now);
  report_.paused = paused;
}

void Runner::step_once() {
  set_paused(true);
  const std::lock_guard lock(mutex_);
  single_ = true;
}

void Runner::press(const CameraRay& ray, double firmness) {
  {
    const std::lock_guard lock(mutex_);
    pressed_.reset();
    pull_.reset();
  }
  post([this, ray, firmness](LiveWorld& live) {
    const auto taken = live.take(ray, firmness);
    const std::lock_guard lock(mutex_);
    pressed_ = taken && taken->has_value();
    if (*pressed_) grabbed_at_ = **taken;
    if (!taken) report_.trouble = taken.error().message;
  });
}

std::optional<bool> Runner::pressed() const {
  const std::lock_guard lock(mutex_);
  return pressed_;
}

Eigen::Vector3d Runner::grabbed_at() const {
  const std::lock_guard lock(mutex_);
  return grabbed_at_;
}

void Runner::pull(const Eigen::Vector3d& way, Clock::time_point event) {
  const std::lock_guard lock(mutex_);
  pull_ = {way, event};
}

void Runner::let_go() {
  post([](LiveWorld& live) { live.hand().let_go(live.world()); });
}

void Runner::look(WorldMoment& moment) const {
  const std::lock_guard lock(mutex_);
  const double step = now_.time - before_.time;
  const double late = clock_time(Clock::now()) - before_.time;
  between(before_, now_, step > 0.0 ? std::clamp(late / step, 0.0, 1.0) : 1.0, moment);
}

RunnerReport Runner::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

void Runner::complain(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  report_.trouble = trouble;
}

std::string Runner::method_of(std::size_t body) const {
  const std::lock_guard lock(mutex_);
  return report_.methods[body];
}

// True if something was done.
bool Runner::do_work() {
  std::deque<Work> work;
  {
    const std::lock_guard lock(mutex_);
    work.swap(work_);
    busy_ = !work.empty();
  }
  for (const Work& piece : work) piece(world_);
  if (work.empty()) return false;
  // An error is impossible here: the same query has succeeded before.
  (void)world_.refresh();
  if (records_ && world_.world().steps() == 0) record_.clear();
  publish(false);
  const std::lock_guard lock(mutex_);
  busy_ = false;
  return true;
}

void Runner::run() {
  while (true) {
    {
      const std::lock_guard lock(mutex_);
      if (stopped_) return;
    }
    if (!do_work()) follow_clock();
  }
}

void Runner::follow_clock() {
  {
    std::unique_lock lock(mutex_);
    const Clock::time_point now = Clock::now();
    const double behind = clock_time(now) - now_.time;
    const bool steps = single_ || (!report_.paused && behind > 0.0);
    if (!steps) {
      if (work_.empty() && !stopped_) {
        const double wait = report_.paused ? 1.0 : -behind / rate_;
        wake_.wait_for(lock, std::min<std::chrono::duration<double>>(
                                 kNap, std::chrono::duration<double>(std::max(wait, 0.0))));
      }
      return;
    }
    if (single_)
      anchor_time_ = now_.time + world_.world().step_size();
    else if (behind > kMostBehind * rate_ + world_.world().step_size()) {
      report_.lost += (behind - world_.world().step_size()) / rate_;
      set_clock(now_.time + world_.world().step_size(), now);
    }
    single_ = false;
    if (pull_) {
      world_.hand().move(pull_->first);
      answers_ = pull_->second;
      pull_.reset();
    }
  }
  make_step();
}

void Runner::make_step() {
  const Clock::time_point begun = Clock::now();
  if (records_) record_.before_step(world_);
  const Status stepped = world_.step();
  const double ms = 1e3 * seconds(Clock::now() - begun);
  {
    const std::lock_guard lock(mutex_);
    report_.step_ms += (report_.steps == 0 ? 1.0 : kForget) * (ms - report_.step_ms);
    if (!stepped) {
      report_.trouble = stepped.error().message;
      report_.paused = true;
    }
  }
  publish(true);
}

void Runner::publish(bool stepped) {
  if (!stepped || now_.time + 1e-12 >= next_sample_ || world_.now().time < now_.time) take_sample();
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  // After a restart or a change of step size the clock continues from the world's time.
  if (!stepped && world_.now().time != now_.time) set_clock(world_.now().time, now);
  before_ = world_.before();
  now_ = world_.now();
  const SceneWorld& world = world_.world();
  report_.time = world.time();
  report_.steps = world.steps();
  report_.holds = world_.hand().holds();
  if (!stepped) tell_methods();
  report_.contacts = world_.guests().contacts();
  report_.active_contacts = world_.guests().active_contacts();
  for (std::size_t i = 0; i < world.size(); ++i) {
    report_.contacts += world.contacts(i);
    report_.active_contacts += world.body(i).contact_account().active;
  }
  if (!world_.trouble().empty()) report_.trouble = world_.trouble();
  if (answers_ && stepped) {
    if (report_.latencies.size() >= kLatencies) report_.latencies.erase(report_.latencies.begin());
    report_.latencies.push_back(1e3 * seconds(now - *answers_));
    answers_.reset();
  }
  if (const double passed = seconds(now - second_began_); passed >= 1.0) {
    report_.pace = std::max(0.0, world.time() - second_time_) / passed;
    second_began_ = now;
    second_time_ = world.time();
  }
}

void Runner::tell_methods() {
  report_.methods.clear();
  for (std::size_t i = 0; i < world_.world().size(); ++i)
    report_.methods.emplace_back(world_.world().body(i).integrator().name());
}

void Runner::take_sample() {
  EnergySample sample{world_.world().time()};
  sample.kinetic = world_.guests().kinetic_energy();
  sample.potential = world_.guests().elastic_energy();
  for (std::size_t i = 0; i < world_.world().size(); ++i) {
    const Energy energy = world_.world().body(i).energy();
    sample.kinetic += energy.kinetic;
    sample.potential += energy.potential;
    sample.high += energy.high_band;
  }
  const std::lock_guard lock(mutex_);
  next_sample_ = sample.time + kSampleEvery * std::min(1.0, rate_);
  std::vector<EnergySample>& energies = report_.energies;
  // After a restart.
  if (!energies.empty() && energies.back().time > sample.time + 1.0 * world_.world().step_size())
    energies.clear();
  if (energies.size() >= kEnergySamples) energies.erase(energies.begin());
  energies.push_back(sample);
}

}  // namespace tremolo
