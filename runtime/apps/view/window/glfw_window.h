// A window with OpenGL 3.3 and Dear ImGui.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"

struct GLFWwindow;

namespace tremolo {

// Callbacks for input events, except those that the panel handles. Positions as fractions of the
// window from its upper left corner.
struct WindowEvents {
  std::function<void(int button, bool down, bool shift)> button;
  std::function<void(double x, double y)> move;
  std::function<void(double turns)> wheel;
  // key: of GLFW. again: the key is held down and repeats.
  std::function<void(int key, bool again)> key;
};

class GlfwWindow {
 public:
  // Its context is current. Errors (kSystem): no display, no OpenGL 3.3.
  static Result<std::unique_ptr<GlfwWindow>> create(const std::string& title,
                                                    const PictureSize& size);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  void listen(WindowEvents events) { events_ = std::move(events); }
  bool closed() const;
  void close();
  // Waits `seconds` for an event at most.
  void poll(double seconds);
  // In pixels; one side is 0 if the window shows nothing.
  PictureSize pixels() const;
  void begin_panel();
  void draw_panel();
  void show();

 private:
  GlfwWindow() = default;
  void tell_move(double x, double y);

  GLFWwindow* window_ = nullptr;
  WindowEvents events_;
};

}  // namespace tremolo
