#include "runtime/apps/view/window/glfw_window.h"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <utility>

namespace tremolo {
namespace {

std::string glfw_trouble() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text == nullptr ? "GLFW gives no reason" : text;
}

GlfwWindow* window_of(GLFWwindow* window) {
  return static_cast<GlfwWindow*>(glfwGetWindowUserPointer(window));
}

}  // namespace

Result<std::unique_ptr<GlfwWindow>> GlfwWindow::create(const std::string& title,
                                                       const PictureSize& size) {
  const std::string instead = "; `--offscreen --out DIR` makes pictures without one";
  if (glfwInit() != GLFW_TRUE)
    return system_error("there is no display for a window (" + glfw_trouble() + ")" + instead);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  std::unique_ptr<GlfwWindow> made(new GlfwWindow());
  made->window_ = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (made->window_ == nullptr)
    return system_error("the display gives no window with OpenGL 3.3 (" + glfw_trouble() + ")" +
                        instead);
  GLFWwindow* window = made->window_;
  glfwMakeContextCurrent(window);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window, made.get());
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    const auto& tell = window_of(w)->events_.button;
    const bool ours = action == GLFW_RELEASE || !ImGui::GetIO().WantCaptureMouse;
    if (tell && ours) tell(button, action == GLFW_PRESS, (mods & GLFW_MOD_SHIFT) != 0);
  });
  glfwSetCursorPosCallback(
      window, [](GLFWwindow* w, double x, double y) { window_of(w)->tell_move(x, y); });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double turns) {
    const auto& tell = window_of(w)->events_.wheel;
    if (tell && !ImGui::GetIO().WantCaptureMouse) tell(turns);
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    const auto& tell = window_of(w)->events_.key;
    if (tell && action != GLFW_RELEASE && !ImGui::GetIO().WantTextInput)
      tell(key, action == GLFW_REPEAT);
  });
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::StyleColorsDark();
  ImGui::GetStyle().WindowRounding = 4.0f;
  // It calls those above first.
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
  return made;
}

GlfwWindow::~GlfwWindow() {
  if (window_ != nullptr) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
  }
  glfwTerminate();
}

void GlfwWindow::tell_move(double x, double y) {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  if (events_.move && width > 0 && height > 0) events_.move(x / width, y / height);
}

bool GlfwWindow::closed() const {
  return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void GlfwWindow::close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void GlfwWindow::poll(double seconds) {
  if (seconds > 0.0)
    glfwWaitEventsTimeout(seconds);
  else
    glfwPollEvents();
}

PictureSize GlfwWindow::pixels() const {
  PictureSize size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  return size;
}

void GlfwWindow::begin_panel() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void GlfwWindow::draw_panel() {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void GlfwWindow::show() {
  glfwSwapBuffers(window_);
}

}  // namespace tremolo
