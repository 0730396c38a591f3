#include "runtime/apps/view/offscreen/egl_context.h"

// X11 would make macros of Status and Success.
#define EGL_NO_X11
#include <epoxy/egl.h>
#include <string>

namespace tremolo {
namespace {

// EGL's platform without surfaces; EGL_NO_DISPLAY if it is missing.
EGLDisplay surfaceless_display() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless") ||
      !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base"))
    return EGL_NO_DISPLAY;
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

EGLDisplay working_display() {
  for (const EGLDisplay display : {surfaceless_display(), eglGetDisplay(EGL_DEFAULT_DISPLAY)}) {
    if (display == EGL_NO_DISPLAY) continue;
    if (eglInitialize(display, nullptr, nullptr) == EGL_TRUE) return display;
  }
  return EGL_NO_DISPLAY;
}

constexpr const char* kAdvice =
    "; on Debian libegl1, libegl-mesa0 and libgl1-mesa-dri bring one that needs no graphics card";

}  // namespace

Result<std::unique_ptr<EglContext>> EglContext::create() {
  if (!epoxy_has_egl())
    return system_error(std::string("there is no EGL here (libEGL.so.1), which pictures without a "
                                    "display need") +
                        kAdvice);
  std::unique_ptr<EglContext> made(new EglContext());
  made->display_ = working_display();
  if (made->display_ == EGL_NO_DISPLAY)
    return system_error(std::string("EGL has no driver that works without a display") + kAdvice);
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  const bool has_config =
      eglChooseConfig(made->display_, wanted, &config, 1, &count) == EGL_TRUE && count > 0;
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE || !has_config)
    return system_error(std::string("EGL's driver has no OpenGL") + kAdvice);
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            3,
                            EGL_CONTEXT_MINOR_VERSION,
                            3,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  made->context_ = eglCreateContext(made->display_, config, EGL_NO_CONTEXT, version);
  if (made->context_ == EGL_NO_CONTEXT)
    return system_error(std::string("EGL's driver has no OpenGL 3.3") + kAdvice);
  if (!epoxy_has_egl_extension(made->display_, "EGL_KHR_surfaceless_context")) {
    const EGLint pixel[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    made->surface_ = eglCreatePbufferSurface(made->display_, config, pixel);
  }
  if (eglMakeCurrent(made->display_, made->surface_, made->surface_, made->context_) != EGL_TRUE)
    return system_error("EGL's driver gives no context without a window");
  return made;
}

EglContext::~EglContext() {
  if (display_ == EGL_NO_DISPLAY) return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

}  // namespace tremolo
