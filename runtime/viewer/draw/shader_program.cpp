#include "runtime/viewer/draw/shader_program.h"

#include <array>
#include <string>

namespace tremolo {
namespace {

// Attaches the shader to the program; the driver's complaint if it does not compile.
Status attach_shader(GLuint program, GLenum kind, const char* text) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint good = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
  std::array<char, 1000> log{};
  if (good == GL_FALSE)
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  else
    glAttachShader(program, shader);
  glDeleteShader(shader);
  if (good == GL_FALSE) return system_error(log.data());
  return Success{};
}

}  // namespace

Result<ShaderProgram> ShaderProgram::create(const char* name, const char* vertex,
                                            const char* fragment) {
  const auto refused = [name](const std::string& why) {
    return system_error(std::string("OpenGL does not take the shader '") + name + "': " + why);
  };
  GlHandle program = GlHandle::make(GlKind::kProgram);
  if (Status s = attach_shader(program.name(), GL_VERTEX_SHADER, vertex); !s)
    return refused(s.error().message);
  if (Status s = attach_shader(program.name(), GL_FRAGMENT_SHADER, fragment); !s)
    return refused(s.error().message);
  glLinkProgram(program.name());
  GLint good = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &good);
  if (good == GL_FALSE) {
    std::array<char, 1000> log{};
    glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    return refused(log.data());
  }
  return ShaderProgram(std::move(program));
}

}  // namespace tremolo
