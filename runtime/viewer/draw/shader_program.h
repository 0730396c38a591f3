// Shaders: text -> program.
#pragma once

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/viewer/draw/gl_handle.h"

namespace tremolo {

class ShaderProgram {
 public:
  ShaderProgram() = default;
  // Errors (kSystem): the messages of the driver's compiler, after `name`.
  static Result<ShaderProgram> create(const char* name, const char* vertex, const char* fragment);

  void use() const { glUseProgram(program_.name()); }
  GLuint name() const { return program_.name(); }
  // Sets a uniform of the program in use. A name that the driver has removed as unused is ignored.
  void set(const char* uniform, int value) const { glUniform1i(place(uniform), value); }
  void set(const char* uniform, float value) const { glUniform1f(place(uniform), value); }
  void set(const char* uniform, const Eigen::Vector3f& value) const {
    glUniform3fv(place(uniform), 1, value.data());
  }
  void set(const char* uniform, const Eigen::Vector4f& value) const {
    glUniform4fv(place(uniform), 1, value.data());
  }
  void set(const char* uniform, const Eigen::Matrix4f& value) const {
    glUniformMatrix4fv(place(uniform), 1, GL_FALSE, value.data());
  }

 private:
  explicit ShaderProgram(GlHandle program) : program_(std::move(program)) {}
  GLint place(const char* uniform) const { return glGetUniformLocation(program_.name(), uniform); }

  GlHandle program_;
};

}  // namespace tremolo
