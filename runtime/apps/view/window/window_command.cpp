#include "runtime/apps/view/setup/viewer_options.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <cmath>
#include <filesystem>
#include <imgui.h>
#include <numbers>
#include <optional>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/view/live/runner.h"
#include "runtime/apps/view/picture/picture_series.h"
#include "runtime/apps/view/picture/png_file.h"
#include "runtime/apps/view/setup/frame_times.h"
#include "runtime/apps/view/setup/view_setup.h"
#include "runtime/apps/view/window/glfw_window.h"
#include "runtime/apps/view/window/panel.h"

namespace tremolo {
namespace {

using Clock = Runner::Clock;

constexpr LightCounts kCardLights{8, 24, 1024}, kSoftwareLights{2, 6, 512};
constexpr double kSwingHz = 0.8;     // of a mode that is shown
constexpr double kHiddenWait = 0.1;  // s between checks of a hidden window

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

// Records the window as a film or a folder of pictures at constant rate: a slow picture is
// repeated.
class WindowRecording {
 public:
  Status begin(const std::string& folder, const std::string& film, double rate,
               const PictureSize& size) {
    Result<PictureSeries> series =
        PictureSeries::create(folder, film, rate, size.width, size.height);
    if (!series) return series.error();
    series_.emplace(std::move(*series));
    rate_ = rate;
    size_ = size;
    count_ = 0;
    begun_ = Clock::now();
    return Success{};
  }
  bool goes() const { return series_.has_value(); }
  Status add(const PictureSize& size) {
    if (size.width != size_.width || size.height != size_.height)
      return content_error("the window has changed its size: the recording ends");
    const auto due = static_cast<std::int64_t>(rate_ * seconds_since(begun_)) + 1;
    if (due <= count_) return Success{};
    read_pixels(0, size, picture_);
    for (; count_ < due; ++count_)
      if (Status s = series_->add(picture_); !s) return s;
    return Success{};
  }
  Status end() {
    if (!series_) return Success{};
    const Status s = series_->finish();
    if (s && !series_->files().empty()) tell("tremolo: recorded {}\n", series_->files().back());
    series_.reset();
    return s;
  }

 private:
  std::optional<PictureSeries> series_;
  Picture picture_;
  PictureSize size_;
  double rate_ = 60.0;
  std::int64_t count_ = 0;
  Clock::time_point begun_;
};

class Viewer {
 public:
  Viewer(const ViewerOptions& options, const ViewSetup& setup, ModelCache& models)
      : options_(options), setup_(setup), models_(models) {}

  Status open(LiveWorld live) {
    const std::string name = std::filesystem::path(options_.file).filename().string();
    if (Status s = take(window_, GlfwWindow::create("tremolo view: " + name, setup_.size)); !s)
      return s;
    if (Status s = take(renderer_, Renderer::create()); !s) return s;
    if (Status s = take(
            stage_, Stage::create(live, setup_.up, setup_.paints, setup_.images, setup_.solids));
        !s)
      return s;
    if (Status s = check_stage(options_, *stage_); !s) return s;
    camera_ = first_camera(setup_, *stage_);
    leave_room();
    frame_points(stage_->points(), aspect(), camera_);
    camera_.distance /= setup_.camera.zoom;
    modes_ = mode_facts(live.world());
    panel_ = first_panel(live, options_.slow);
    panel_.wire = options_.wire;
    panel_.colour = colour_by(options_.colour);
    panel_.knows_stress = stage_->knows_stress();
    panel_.knows_degrees = stage_->knows_degrees();
    panel_.colliders = !options_.no_colliders;
    panel_.records_hand = !options_.record_hand.empty();
    const LightCounts usual = renderer_->is_software() ? kSoftwareLights : kCardLights;
    panel_.lights = options_.lights > 0 ? options_.lights : usual.all();
    side_ = usual.side;
    panel_.coarser = renderer_->is_software() ? 2 : 1;
    panel_.shown_by = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    runner_.emplace(std::move(live), options_.slow, options_.paused, panel_.records_hand);
    mouse_.emplace(*runner_, camera_);
    listen();
    if (Status s = begin_orbit(); !s) return s;
    if (options_.out.empty() && options_.video.empty()) return Success{};
    return recording_.begin(options_.out, options_.video, options_.rate, window_->pixels());
  }

  Status run() {
    const Interruption interruption;
    const Clock::time_point begun = Clock::now();
    while (!window_->closed() && interruption.signal() == 0) {
      if (options_.duration > 0.0 && seconds_since(begun) >= options_.duration) break;
      const PictureSize size = window_->pixels();
      const bool shows = size.width > 0 && size.height > 0;
      window_->poll(shows ? 0.0 : kHiddenWait);
      if (!shows) continue;
      if (Status s = show_picture(size); !s) return s;
    }
    seconds_ = seconds_since(begun);
    signal_ = interruption.signal();
    return recording_.end();
  }

  // Writes the recording and prints the measurements.
  Status finish() {
    const RunnerReport report = runner_->report();
    const LiveWorld live = runner_->stop();
    if (!options_.record_hand.empty()) {
      const std::vector<SceneHand>& hands = runner_->hand_record().hands();
      if (hands.empty()) {
        tell("tremolo: nothing was pulled: {} is not written\n", options_.record_hand);
      } else {
        if (Status s = write_recorded_scene(options_.record_hand, live, hands); !s) return s;
        tell("tremolo: recorded {} pulls: {}\n", hands.size(), options_.record_hand);
      }
    }
    if (options_.measure) tell_costs(report);
    if (options_.json) print_json(json_of(report, live));
    trouble_code_ = live.trouble_code();
    return Success{};
  }
  // That of a signal that closed the window, else of a step that failed.
  int code() const { return signal_ != 0 ? 128 + signal_ : trouble_code_; }

 private:
  double aspect() const {
    const PictureSize size = window_->pixels();
    return size.height > 0 ? size.aspect() : 1.0;
  }

  // Shows the motion of --orbit from the start.
  Status begin_orbit() {
    if (options_.orbit.empty()) return Success{};
    const Result<OrbitRequest> request = parse_orbit_request(options_.orbit);
    if (!request) return request.error();
    const ModeFacts& facts = modes_.front();
    if (request->mode >= facts.model->modes())
      return content_error("--orbit " + options_.orbit + ": the model has modes 1 to " +
                           std::to_string(facts.model->modes()));
    panel_.orbit.mode = static_cast<int>(request->mode) + 1;
    panel_.orbit.percent = static_cast<float>(100.0 * request->share);
    panel_.orbit.plays = panel_.orbit.opens = true;
    runner_->set_paused(true);
    finder_.find(*facts.model, request->mode);
    return Success{};
  }

  // The panel hides the left of the window.
  void leave_room() {
    const double width = std::max(1, window_->pixels().width), hidden = kPanelWidth;
    camera_.shift = panel_.panel && width > 2.0 * hidden ? hidden / width : 0.0;
  }

  void listen() {
    window_->listen(
        {.button = [this](int button, bool down,
                          bool shift) { mouse_->button(button, down, shift, aspect()); },
         .move = [this](double x, double y) { mouse_->move(x, y, aspect()); },
         .wheel = [this](double turns) { mouse_->wheel(turns); },
         .key = [this](int key, bool again) { press_key(key, again); }});
  }

  // A held key repeats steps and no other command.
  void press_key(int key, bool again) {
    if (again && key != GLFW_KEY_PERIOD) return;
    if (key == GLFW_KEY_ESCAPE) window_->close();
    if (key == GLFW_KEY_R) panel_.wants_reset = true;
    if (key == GLFW_KEY_F) panel_.wants_frame = true;
    if (key == GLFW_KEY_W) panel_.wire = !panel_.wire;
    if (key == GLFW_KEY_H) {
      panel_.panel = !panel_.panel;
      leave_room();
    }
    if (key != GLFW_KEY_SPACE && key != GLFW_KEY_PERIOD) return;
    panel_.swing.reset();
    panel_.orbit.plays = false;
    if (key == GLFW_KEY_SPACE)
      runner_->set_paused(!runner_->report().paused);
    else
      runner_->step_once();
  }

  void grant_wishes() {
    mouse_->firmness = static_cast<double>(panel_.firmness);
    if (std::exchange(panel_.wants_frame, false)) {
      leave_room();
      frame_points(stage_->points(), aspect(), camera_);
    }
    if (std::exchange(panel_.wants_reset, false)) {
      panel_.swing.reset();
      runner_->post([this](LiveWorld& live) {
        const Status s = live.begin_again(models_);
        runner_->complain(s ? "" : s.error().message);
      });
    }
    if (std::exchange(panel_.wants_record, false)) switch_recording();
    panel_.recording = recording_.goes();
  }

  void switch_recording() {
    Status s = Success{};
    if (recording_.goes()) {
      s = recording_.end();
    } else {
      const std::string to = panel_.record_to.data();
      const std::string ending = std::filesystem::path(to).extension().string();
      const bool film = ending == ".mp4" || ending == ".webm";
      s = recording_.begin(film ? "" : to, film ? to : "", options_.rate, window_->pixels());
    }
    panel_.record_trouble = s ? "" : s.error().message;
  }

  // Shows an oscillating mode or an orbit instead of the body's state.
  void apply_swing() {
    if (std::optional<Eigen::VectorXd> orbit = shown_orbit(panel_.orbit))
      moment_.bodies[panel_.orbit.body].q = std::move(*orbit);
    if (!panel_.swing) return;
    const Swing& swing = *panel_.swing;
    const double now = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
    Eigen::VectorXd& q = moment_.bodies[swing.body].q;
    q.setZero();
    q[swing.mode] = swing.share * modes_[swing.body].full[swing.mode] *
                    std::sin(2.0 * std::numbers::pi * kSwingHz * (now - swing.began));
  }

  PictureLook look_now() {
    PictureLook look = look_of(options_, setup_, *stage_, light_counts(panel_.lights, side_));
    look.lights = light_counts(panel_.lights, side_);
    look.wire = panel_.wire;
    look.coarser = panel_.coarser;
    most_moved_ = std::max(most_moved_, stage_->most_moved());
    most_stressed_ = std::max(most_stressed_, stage_->most_stressed());
    const bool stress = panel_.colour == ColourBy::kStress;
    const double asked = stress ? options_.stress_full : options_.moved_full;
    look.full = asked > 0.0 ? static_cast<float>(asked) : stress ? most_stressed_ : most_moved_;
    if (panel_.colour == ColourBy::kDegree) look.full = 1.0f;
    costs_.full = look.full;
    return look;
  }

  Status show_picture(const PictureSize& size) {
    mouse_->update(aspect());
    grant_wishes();
    receive_orbits(finder_, panel_.orbit);
    times_.begin();
    runner_->look(moment_);
    apply_swing();
    stage_->pose(moment_);
    const double posed = times_.so_far();
    window_->begin_panel();
    build_panel(panel_, *runner_, finder_, modes_, moment_, costs_);
    ImGui::Render();
    costs_.panel_ms += 0.1 * (times_.so_far() - posed - costs_.panel_ms);
    times_.prepared();
    const StageLook seen{panel_.colour, panel_.colliders};
    stage_->upload(seen);
    const PictureLook look = look_now();
    if (Status s = renderer_->draw(stage_->things(seen, eye_of(camera_)), stage_->ball(), camera_,
                                   size, look, 0);
        !s)
      return s;
    if (recording_.goes())
      if (Status s = recording_.add(size); !s) {
        panel_.record_trouble = s.error().message;
        tell("tremolo: {}\n", s.error().message);
        (void)recording_.end();
      }
    window_->draw_panel();
    window_->show();
    times_.drawn();
    costs_.prepare_ms = times_.prepare_ms();
    costs_.draw_ms = times_.draw_ms();
    if (const double passed = seconds_since(counted_from_); passed > 0.5) {
      costs_.pictures_per_s = counted_ / passed;
      counted_from_ = Clock::now();
      counted_ = 0;
    }
    ++counted_;
    ++pictures_;
    return Success{};
  }

  void tell_costs(const RunnerReport& report) const {
    const std::vector<double>& waits = report.latencies;
    tell(
        "tremolo: {} pictures in {:.1f} s; a picture takes {:.2f} ms of the processor to pose it "
        "and build the panel, {:.1f} ms by the clock to draw it{}; a step {:.3f} ms, pace {:.3f}\n",
        pictures_, seconds_, times_.prepare_ms(), times_.draw_ms(),
        renderer_->is_software() ? " (by software)" : "", report.step_ms, report.pace);
    if (!waits.empty())
      tell(
          "tremolo: from a mouse's event to a state that knows of it {:.2f} ms (median of {}), at "
          "most {:.2f} ms\n",
          FrameTimes::median(waits), waits.size(), *std::max_element(waits.begin(), waits.end()));
  }

  nlohmann::ordered_json json_of(const RunnerReport& report, const LiveWorld& live) const {
    nlohmann::ordered_json json;
    json["file"] = options_.file;
    json["pictures"] = pictures_;
    json["seconds"] = seconds_;
    json["prepare_ms"] = times_.prepare_ms();
    json["panel_ms"] = costs_.panel_ms;
    json["draw_ms"] = times_.draw_ms();
    json["software"] = renderer_->is_software();
    json["step_ms"] = report.step_ms;
    json["pace"] = report.pace;
    json["given_up_s"] = report.lost;
    json["mouse_to_state_ms"] = report.latencies.empty()
                                    ? nlohmann::ordered_json(nullptr)
                                    : nlohmann::ordered_json(FrameTimes::median(report.latencies));
    json["mouse_moves"] = report.latencies.size();
    json["time"] = live.world().time();
    json["steps"] = live.world().steps();
    json["largest_displacement"] = most_moved_;
    double hand = live.guests().hand_work();
    for (std::size_t i = 0; i < live.world().size(); ++i)
      hand += live.world().body(i).contact_sums().hand;
    json["hand_work"] = hand;
    json["integrators"] = report.methods;
    json["trouble"] = report.trouble;
    return json;
  }

  const ViewerOptions& options_;
  const ViewSetup& setup_;
  ModelCache& models_;
  std::unique_ptr<GlfwWindow> window_;  // first: its context is destroyed last
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<Stage> stage_;
  std::optional<Runner> runner_;
  std::optional<Mouse> mouse_;
  OrbitFinder finder_;
  Camera camera_;
  WorldMoment moment_;
  std::vector<ModeFacts> modes_;
  PanelState panel_;
  PictureCosts costs_;
  FrameTimes times_;
  WindowRecording recording_;
  int side_ = 1024;
  float most_moved_ = 0.0f, most_stressed_ = 0.0f;
  int counted_ = 0;
  std::int64_t pictures_ = 0;
  Clock::time_point counted_from_ = Clock::now();
  double seconds_ = 0.0;
  int trouble_code_ = 0, signal_ = 0;
};

Result<int> show(const ViewerOptions& options, const ViewedScene& viewed) {
  const Result<ViewSetup> setup = make_setup(options, shown_scene(viewed), !viewed.tets.empty());
  if (!setup) return setup.error();
  ModelCache models;
  Result<LiveWorld> live = LiveWorld::create(viewed, models);
  if (!live) return live.error();
  if (!options.orbit.empty())
    if (Status s = check_orbit_world(live->world()); !s) return s.error();
  Viewer viewer(options, *setup, models);
  if (Status s = viewer.open(std::move(*live)); !s) return s.error();
  if (Status s = viewer.run(); !s) return s.error();
  if (Status s = viewer.finish(); !s) return s.error();
  return viewer.code();
}

}  // namespace

int window_command(const ViewerOptions& options, const ViewedScene& viewed) {
  const Result<int> code = show(options, viewed);
  if (!code) return report_error(code.error());
  return flushed(*code);
}

}  // namespace tremolo
