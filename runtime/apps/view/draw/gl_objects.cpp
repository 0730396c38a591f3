#include "runtime/apps/view/draw/gl_objects.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace tremolo {

GlHandle GlHandle::make(GlKind kind) {
  GLuint name = 0;
  switch (kind) {
    case GlKind::kBuffer:
      glGenBuffers(1, &name);
      break;
    case GlKind::kVertexArray:
      glGenVertexArrays(1, &name);
      break;
    case GlKind::kTexture:
      glGenTextures(1, &name);
      break;
    case GlKind::kFramebuffer:
      glGenFramebuffers(1, &name);
      break;
    case GlKind::kRenderbuffer:
      glGenRenderbuffers(1, &name);
      break;
    case GlKind::kProgram:
      name = glCreateProgram();
      break;
  }
  return {kind, name};
}

GlHandle::~GlHandle() {
  if (name_ == 0) return;
  switch (kind_) {
    case GlKind::kBuffer:
      glDeleteBuffers(1, &name_);
      break;
    case GlKind::kVertexArray:
      glDeleteVertexArrays(1, &name_);
      break;
    case GlKind::kTexture:
      glDeleteTextures(1, &name_);
      break;
    case GlKind::kFramebuffer:
      glDeleteFramebuffers(1, &name_);
      break;
    case GlKind::kRenderbuffer:
      glDeleteRenderbuffers(1, &name_);
      break;
    case GlKind::kProgram:
      glDeleteProgram(name_);
      break;
  }
}

namespace {

std::span<const float> numbers_in(const std::vector<Eigen::Vector3f>& vectors) {
  return {vectors.empty() ? nullptr : vectors.front().data(), 3 * vectors.size()};
}

}  // namespace

GlHandle make_image(const Picture& picture) {
  GlHandle image = GlHandle::make(GlKind::kTexture);
  glBindTexture(GL_TEXTURE_2D, image.name());
  std::vector<std::uint8_t> rows;
  const std::size_t row = 3 * static_cast<std::size_t>(picture.width);
  for (int y = picture.height; y-- > 0;) {
    const auto begin = picture.pixels.begin() + static_cast<std::ptrdiff_t>(row) * y;
    rows.insert(rows.end(), begin, begin + static_cast<std::ptrdiff_t>(row));
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8, picture.width, picture.height, 0, GL_RGB,
               GL_UNSIGNED_BYTE, rows.data());
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  return image;
}

bool repeats_image(std::span<const std::uint32_t> triangles, std::span<const float> uvs) {
  constexpr float kMargin = 1e-4f;
  const auto outside = [&uvs](std::uint32_t v) {
    const float u = uvs[2 * std::size_t{v}], w = uvs[2 * std::size_t{v} + 1];
    return std::min(u, w) < -kMargin || std::max(u, w) > 1.0f + kMargin;
  };
  return std::any_of(triangles.begin(), triangles.end(), outside);
}

GpuMesh::GpuMesh(std::span<const std::uint32_t> triangles, std::span<const float> rest)
    : array_(GlHandle::make(GlKind::kVertexArray)), triangles_(triangles.size() / 3) {
  glBindVertexArray(array_.name());
  indices_ = GlHandle::make(GlKind::kBuffer);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size_bytes()),
               triangles.data(), GL_STATIC_DRAW);
  attribute(2, rest_, 3, rest, GL_STATIC_DRAW);
}

GpuMesh::GpuMesh(const TriangleShape& shape)
    : GpuMesh(shape.triangles, numbers_in(shape.positions)) {
  move(numbers_in(shape.positions), numbers_in(shape.normals));
}

void GpuMesh::attribute(GLuint location, GlHandle& buffer, int numbers,
                        std::span<const float> values, GLenum use) {
  glBindVertexArray(array_.name());
  const bool fresh = buffer.name() == 0;
  if (fresh) buffer = GlHandle::make(GlKind::kBuffer);
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size_bytes()), values.data(), use);
  if (!fresh) return;
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, numbers, GL_FLOAT, GL_FALSE, 0, nullptr);
}

void GpuMesh::move(std::span<const float> positions, std::span<const float> normals) {
  attribute(0, positions_, 3, positions, GL_STREAM_DRAW);
  attribute(1, normals_, 3, normals, GL_STREAM_DRAW);
}

void GpuMesh::paint(std::span<const float> colours) {
  attribute(3, colours_, 4, colours, GL_STATIC_DRAW);
}

void GpuMesh::unfold(std::span<const float> uvs) {
  attribute(4, uvs_, 2, uvs, GL_STATIC_DRAW);
}

void GpuMesh::draw() const {
  draw(0, triangles_);
}

void GpuMesh::draw(std::size_t first, std::size_t count) const {
  if (array_.name() == 0 || count == 0) return;
  glBindVertexArray(array_.name());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * count), GL_UNSIGNED_INT,
                 // OpenGL takes the offset into the bound buffer as a pointer.
                 reinterpret_cast<const void*>(12 * first));
}

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

namespace {

constexpr int kSamples = 4;

Status check_complete(const PictureSize& size) {
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Success{};
  return system_error("OpenGL gives no room for a picture of " + std::to_string(size.width) + "x" +
                      std::to_string(size.height) + " pixels");
}

GlHandle renderbuffer(GLenum format, int samples, const PictureSize& size) {
  GlHandle buffer = GlHandle::make(GlKind::kRenderbuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, size.width, size.height);
  return buffer;
}

}  // namespace

Status FrameTarget::resize(const PictureSize& size) {
  if (size.width == size_.width && size.height == size_.height) return Success{};
  size_ = {0, 0};
  GLint most = 0, largest = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  if (std::max(size.width, size.height) > largest)
    return system_error("OpenGL gives no room for a picture of " + std::to_string(size.width) +
                        "x" + std::to_string(size.height) + " pixels, " + std::to_string(largest) +
                        " a side at most");
  const int samples = std::min(kSamples, most);
  samples_ = renderbuffer(GL_RGBA16F, samples, size);
  depth_ = renderbuffer(GL_DEPTH_COMPONENT24, samples, size);
  drawn_ = GlHandle::make(GlKind::kFramebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, samples_.name());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.name());
  if (Status s = check_complete(size); !s) return s;
  light_ = GlHandle::make(GlKind::kTexture);
  glBindTexture(GL_TEXTURE_2D, light_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, size.width, size.height, 0, GL_RGBA, GL_FLOAT,
               nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  resolved_ = GlHandle::make(GlKind::kFramebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, resolved_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, light_.name(), 0);
  if (Status s = check_complete(size); !s) return s;
  size_ = size;
  return Success{};
}

void FrameTarget::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_.name());
  glViewport(0, 0, size_.width, size_.height);
}

void FrameTarget::resolve() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.name());
  glBlitFramebuffer(0, 0, size_.width, size_.height, 0, 0, size_.width, size_.height,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace tremolo
