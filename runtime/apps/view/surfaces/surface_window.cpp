#include "runtime/apps/view/surfaces/surface_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <imgui.h>
#include <numbers>
#include <utility>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/view/surfaces/surface_stage.h"
#include "runtime/apps/view/window/glfw_window.h"

namespace tremolo {
namespace {

using SurfaceClock = std::chrono::steady_clock;
using Eigen::Vector3d;

constexpr LightCounts kSurfaceCard{8, 24, 1024}, kSurfaceSoftware{2, 6, 512};
constexpr int kLeftButton = 0, kRightButton = 1, kMiddleButton = 2;  // as GLFW counts
constexpr double kTurnOver = std::numbers::pi;                       // rad per width of the window
constexpr double kNearer = 0.88;  // of the distance, per notch of the wheel
constexpr double kSteep = 0.495 * std::numbers::pi;
constexpr double kBudget = 0.05;    // s of real time that the steps before a picture may take
constexpr double kHiddenNap = 0.1;  // s between checks of a hidden window

double since(SurfaceClock::time_point then) {
  return std::chrono::duration<double>(SurfaceClock::now() - then).count();
}

class SurfaceViewer {
 public:
  SurfaceViewer(const ViewerOptions& options, const ViewSetup& setup, MovingSurfaces& scenes)
      : options_(options), setup_(setup), scenes_(scenes), paused_(options.paused) {}

  Status open() {
    const std::string name = std::filesystem::path(options_.file).filename().string();
    if (Status s = take(window_, GlfwWindow::create("tremolo view: " + name, setup_.size)); !s)
      return s;
    if (Status s = take(renderer_, Renderer::create()); !s) return s;
    if (Status s = take(stage_, SurfaceStage::create(scenes_, setup_, options_)); !s) return s;
    camera_ = camera_of_points(setup_, stage_->points());
    wire_ = options_.wire;
    window_->listen(
        {.button = [this](int button, bool down, bool shift) { press(button, down, shift); },
         .move = [this](double x, double y) { move(x, y); },
         .wheel = [this](double turns) { camera_.distance *= std::pow(kNearer, turns); },
         .key = [this](int key, bool again) { press_key(key, again); }});
    return Success{};
  }

  Status run() {
    const Interruption interruption;
    const SurfaceClock::time_point begun = SurfaceClock::now();
    set_clock();
    while (!window_->closed() && interruption.signal() == 0) {
      if (options_.duration > 0.0 && since(begun) >= options_.duration) break;
      const PictureSize size = window_->pixels();
      const bool shows = size.width > 0 && size.height > 0;
      window_->poll(shows ? 0.0 : kHiddenNap);
      if (std::exchange(wants_reset_, false)) {
        if (Status s = scenes_.begin_again(); !s) return s;
        trouble_.clear();
        set_clock();
      }
      follow_clock();
      if (!shows) continue;
      if (Status s = show_picture(size); !s) return s;
    }
    signal_ = interruption.signal();
    return Success{};
  }

  int code() const { return signal_ != 0 ? 128 + signal_ : trouble_code_; }
  nlohmann::ordered_json json() const {
    const std::optional<double> work = scenes_.hand_work();
    return {{"file", options_.file},
            {"pictures", pictures_},
            {"software", renderer_->is_software()},
            {"time", scenes_.time()},
            {"steps", scenes_.steps()},
            {"pulls", pulls_},
            {"longest_pull", longest_pull_},
            {"methods", scenes_.chosen()},
            {"step", scenes_.step_size()},
            {"hand_work", work ? nlohmann::ordered_json(*work) : nlohmann::ordered_json()},
            {"refused", refused_},
            {"trouble", trouble_},
            {"exit_code", code()}};
  }

 private:
  enum class Drag { kNone, kPull, kOrbit, kPan };

  double aspect() const {
    const PictureSize size = window_->pixels();
    return size.height > 0 ? size.aspect() : 1.0;
  }

  void set_clock() {
    clock_began_ = SurfaceClock::now();
    clock_time_ = scenes_.time();
  }

  void press(int button, bool down, bool shift) {
    if (!down) {
      if (drag_ == Drag::kPull) scenes_.let_go();
      drag_ = Drag::kNone;
      return;
    }
    if (drag_ != Drag::kNone) return;
    if (button == kMiddleButton || shift) {
      drag_ = Drag::kPan;
    } else if (button == kRightButton) {
      drag_ = Drag::kOrbit;
    } else if (button == kLeftButton) {
      drag_ = scenes_.take(ray_through(camera_, aspect(), x_, y_)) ? Drag::kPull : Drag::kOrbit;
      if (drag_ != Drag::kPull) return;
      taken_ = *scenes_.hand();
      ++pulls_;
    }
  }

  void move(double x, double y) {
    const double dx = x - std::exchange(x_, x), dy = y - std::exchange(y_, y);
    const CameraAxes axes = axes_of(camera_);
    if (drag_ == Drag::kOrbit) {
      camera_.azimuth -= kTurnOver * dx * aspect();
      camera_.elevation = std::clamp(camera_.elevation + kTurnOver * dy, -kSteep, kSteep);
    } else if (drag_ == Drag::kPan) {
      const double height = 2.0 * camera_.distance * std::tan(0.5 * camera_.view_angle);
      camera_.target += height * (-dx * aspect() * axes.right + dy * axes.up);
    } else if (drag_ == Drag::kPull) {
      // In the plane through where it was taken that faces the camera.
      const CameraRay ray = ray_through(camera_, aspect(), x_, y_);
      const double along = axes.back.dot(taken_ - ray.origin) / axes.back.dot(ray.direction);
      const Vector3d point = ray.origin + along * ray.direction;
      longest_pull_ = std::max(longest_pull_, (point - taken_).norm());
      scenes_.move_to(point);
    }
  }

  // A held key repeats steps and no other command.
  void press_key(int key, bool again) {
    if (again && key != GLFW_KEY_PERIOD) return;
    if (key == GLFW_KEY_ESCAPE) window_->close();
    if (key == GLFW_KEY_R) wants_reset_ = true;
    if (key == GLFW_KEY_F) frame_points(stage_->points(), aspect(), camera_);
    if (key == GLFW_KEY_W) wire_ = !wire_;
    if (key == GLFW_KEY_SPACE) paused_ = !paused_;
    if (key == GLFW_KEY_PERIOD) {
      paused_ = true;
      make_step();
    }
    if (key == GLFW_KEY_M && !scenes_.methods().empty()) choose_next();
    if (key == GLFW_KEY_LEFT_BRACKET) set_step(0.5 * scenes_.step_size());
    if (key == GLFW_KEY_RIGHT_BRACKET) set_step(2.0 * scenes_.step_size());
    set_clock();
  }

  // The panel shows the reason of a refusal until the next request.
  void tell_if_refused(const Status& status) {
    refused_ = status ? std::string() : status.error().message;
    set_clock();
  }

  void set_step(double step) { tell_if_refused(scenes_.set_step_size(step)); }

  // Selects the next method of the first scene, skipping methods that are refused.
  void choose_next() {
    const auto names = scenes_.methods();
    if (wanted_.empty()) wanted_ = scenes_.chosen().front();
    const auto at = std::find(names.begin(), names.end(), wanted_);
    wanted_ = names[static_cast<std::size_t>(at + 1 - names.begin()) % names.size()];
    tell_if_refused(scenes_.choose(0, wanted_));
  }

  void make_step() {
    if (!trouble_.empty()) return;
    const Status made = scenes_.step();
    if (made) return;
    trouble_ = made.error().message;
    trouble_code_ = exit_code(made.error().kind);
    tell("tremolo: {}\n", trouble_);
  }

  // Steps up to the clock's time; time beyond the budget is dropped.
  void follow_clock() {
    if (paused_ || !trouble_.empty()) {
      set_clock();
      return;
    }
    const SurfaceClock::time_point begun = SurfaceClock::now();
    const auto due = [this] { return clock_time_ + options_.slow * since(clock_began_); };
    while (scenes_.time() + scenes_.step_size() <= due() && trouble_.empty()) {
      make_step();
      if (since(begun) < kBudget) continue;
      set_clock();
      break;
    }
  }

  void build_methods() {
    const std::vector<std::string> chosen = scenes_.chosen();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const std::string label = i == 0 ? "method" : "method of " + std::to_string(i + 1);
      if (!ImGui::BeginCombo(label.c_str(), chosen[i].c_str())) continue;
      for (const std::string_view name : scenes_.methods())
        if (ImGui::Selectable(std::string(name).c_str(), name == chosen[i])) {
          if (i == 0) wanted_ = name;
          tell_if_refused(scenes_.choose(i, name));
        }
      ImGui::EndCombo();
    }
    if (chosen.empty()) return;
    auto step_ms = static_cast<float>(1e3 * scenes_.step_size());
    if (ImGui::InputFloat("step, ms", &step_ms, 0.5f, 2.0f, "%.3f",
                          ImGuiInputTextFlags_EnterReturnsTrue))
      set_step(1e-3 * static_cast<double>(step_ms));
    if (!refused_.empty()) ImGui::TextWrapped("%s", refused_.c_str());
  }

  void build_panel() {
    ImGui::Begin("scene");
    for (const std::string& line : scenes_.panel_lines()) ImGui::TextUnformatted(line.c_str());
    ImGui::Text("%.2f s%s", scenes_.time(), paused_ ? ", paused" : "");
    build_methods();
    ImGui::Text("left: pull; right: turn; space, . , R, F, W%s",
                scenes_.methods().empty() ? "" : ", M, [, ]");
    if (!trouble_.empty()) ImGui::TextWrapped("%s", trouble_.c_str());
    ImGui::End();
  }

  Status show_picture(const PictureSize& size) {
    stage_->pose(scenes_);
    window_->begin_panel();
    build_panel();
    ImGui::Render();
    stage_->upload();
    const bool software = renderer_->is_software();
    PictureLook look =
        look_of(options_, setup_, *stage_, software ? kSurfaceSoftware : kSurfaceCard);
    look.wire = wire_;
    look.full = stage_->full();
    look.coarser = software ? 2 : 1;
    if (Status s = renderer_->draw(stage_->things(), stage_->ball(), camera_, size, look, 0); !s)
      return s;
    window_->draw_panel();
    window_->show();
    ++pictures_;
    return Success{};
  }

  const ViewerOptions& options_;
  const ViewSetup& setup_;
  MovingSurfaces& scenes_;
  std::unique_ptr<GlfwWindow> window_;  // first: its context is destroyed last
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<SurfaceStage> stage_;
  Camera camera_;
  Drag drag_ = Drag::kNone;
  double x_ = 0.5, y_ = 0.5;
  Vector3d taken_ = Vector3d::Zero();
  bool paused_ = false, wire_ = false, wants_reset_ = false;
  SurfaceClock::time_point clock_began_;
  double clock_time_ = 0.0, longest_pull_ = 0.0;  // s; m
  std::int64_t pictures_ = 0, pulls_ = 0;
  std::string trouble_;
  std::string refused_, wanted_;
  int trouble_code_ = 0, signal_ = 0;
};

}  // namespace

Result<int> show_surfaces(const ViewerOptions& options, MovingSurfaces& scenes) {
  const Result<ViewSetup> setup = make_setup(options, names_of(scenes), has_materials(scenes));
  if (!setup) return setup.error();
  if (!options.record_hand.empty())
    if (Status s = scenes.record_hand(); !s) return s.error();
  SurfaceViewer viewer(options, *setup, scenes);
  if (Status s = viewer.open(); !s) return s.error();
  if (Status s = viewer.run(); !s) return s.error();
  if (!options.record_hand.empty())
    if (Status s = scenes.write_hand(options.record_hand); !s) return s.error();
  if (options.json) print_json(viewer.json());
  return viewer.code();
}

Status refuse_body_flags(const ViewerOptions& options, const std::string& kind) {
  if (!options.offscreen && !(options.out.empty() && options.video.empty()))
    return usage_error("a window of " + kind +
                       " is not recorded: --offscreen writes --out and --video");
  return Success{};
}

Result<int> view_surfaces(const ViewerOptions& options, const std::vector<NamedFile>& inputs,
                          MovingSurfaces& scenes) {
  if (Status s = check_view_outputs(options, inputs_of_view(options, inputs)); !s) return s.error();
  const GuardedInputs guard(inputs_of_view(options, inputs));
  return options.offscreen ? photograph_surfaces(options, scenes) : show_surfaces(options, scenes);
}

}  // namespace tremolo
