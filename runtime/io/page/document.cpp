#include "runtime/io/page/document.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <tremolo_page_template.h>

#include "formats/file/atomic_file.h"
#include "formats/file/base64.h"
#include "runtime/io/exchange/json_text.h"

namespace tremolo {

std::string page_document(std::string_view report) {
  constexpr std::string_view kMark = "%REPORT%";
  const std::string_view page = kPageTemplate;
  const std::size_t mark = page.find(kMark);
  std::string document(page.substr(0, mark));
  document.reserve(page.size() + report.size());
  // Escapes the character <, so that no text ends the page's script element; it appears only in
  // strings, where JSON allows the escape.
  for (const char c : report) c == '<' ? document += "\\u003c" : document += c;
  document += page.substr(mark + kMark.size());
  return document;
}

namespace {

using Eigen::Index;
using Eigen::VectorXd;

static_assert(std::endian::native == std::endian::little);

constexpr double kWholeError = 5e-6;  // of the size; see document.h
constexpr double kLargestWhole = 32767.0;
constexpr std::size_t kPageLooks = 64;  // frames at which the error is measured

std::string page_member(std::string_view name, const std::string& value) {
  return json_string(name) + ":" + value;
}

std::string page_object(const std::vector<std::string>& members) {
  std::string list = json_list(members);
  list.front() = '{';
  list.back() = '}';
  return list;
}

template <class Number>
std::string page_array(const char* type, const std::vector<Number>& values) {
  const std::string_view bytes(reinterpret_cast<const char*>(values.data()),
                               sizeof(Number) * values.size());
  return page_object({page_member("type", json_string(type)),
                      page_member("data", json_string(encode_base64(bytes)))});
}

// The modes of a shape in the page's form. whole: 3s x r, or empty.
struct PageFields {
  Eigen::MatrixXf floats;
  std::vector<std::int16_t> whole;
  std::vector<float> scales;

  VectorXd column(Index i, Index rows) const {
    if (whole.empty()) return floats.col(i).cast<double>();
    VectorXd values(rows);
    for (Index k = 0; k < rows; ++k)
      values[k] = static_cast<double>(scales[i]) * whole[i * rows + k];
    return values;
  }
};

// The largest |q_i| of all bodies of the shape.
VectorXd largest_coordinates(const Animation& animation, std::size_t shape) {
  VectorXd largest = VectorXd::Zero(animation.shapes[shape].modes.cols());
  for (const AnimatedBody& body : animation.bodies) {
    if (body.shape != shape) continue;
    for (std::size_t frame = 0; frame < animation.frames(); ++frame)
      largest = largest.cwiseMax(coordinates_at(animation, body, frame).cwiseAbs());
  }
  return largest;
}

PageFields page_fields(const Animation& animation, std::size_t number) {
  const AnimatedShape& shape = animation.shapes[number];
  const Index rows = shape.modes.rows(), r = shape.modes.cols();
  PageFields fields;
  if (r == 0) return fields;
  const VectorXd most = shape.modes.cwiseAbs().colwise().maxCoeff();
  const double error =
      0.5 / kLargestWhole * most.cwiseProduct(largest_coordinates(animation, number)).sum();
  if (!(error <= kWholeError * largest_extent(shape))) {
    fields.floats = shape.modes.cast<float>();
    return fields;
  }
  fields.whole.reserve(rows * r);
  for (Index i = 0; i < r; ++i) {
    const float scale = most[i] > 0.0 ? static_cast<float>(most[i] / kLargestWhole) : 1.0F;
    fields.scales.push_back(scale);
    for (Index k = 0; k < rows; ++k) {
      const double nearest = std::round(shape.modes(k, i) / static_cast<double>(scale));
      fields.whole.push_back(
          static_cast<std::int16_t>(std::clamp(nearest, -kLargestWhole, kLargestWhole)));
    }
  }
  return fields;
}

std::vector<float> page_rest(const AnimatedShape& shape) {
  std::vector<float> rest;
  rest.reserve(3 * shape.surface.vertices.size());
  for (const Eigen::Vector3d& x : shape.surface.vertices)
    for (const double coordinate : x) rest.push_back(static_cast<float>(coordinate));
  return rest;
}

std::string page_shape_text(const AnimatedShape& shape, const PageFields& fields) {
  std::vector<std::uint32_t> corners;
  for (const Triangle& triangle : shape.surface.triangles)
    for (const VertexId corner : triangle) corners.push_back(static_cast<std::uint32_t>(corner));
  std::vector<std::string> members = {
      page_member("name", json_string(shape.name)),
      page_member("vertices", json_number(shape.surface.vertices.size())),
      page_member("modes", json_number(shape.modes.cols())),
      page_member("rest", page_array("float32", page_rest(shape)))};
  if (fields.whole.empty()) {
    const float* first = fields.floats.data();
    members.push_back(page_member(
        "fields", page_array("float32", std::vector<float>(first, first + fields.floats.size()))));
  } else {
    members.push_back(page_member("fields", page_array("int16", fields.whole)));
    members.push_back(page_member("scales", json_numbers(fields.scales)));
  }
  members.push_back(page_member("corners", page_array("uint32", corners)));
  if (!shape.smooth_groups.empty())
    members.push_back(page_member("groups", page_array("uint32", shape.smooth_groups)));
  return page_object(members);
}

std::vector<float> page_poses(const Animation& animation, const AnimatedBody& body) {
  std::vector<float> poses;
  for (std::size_t frame = 0; frame < animation.frames(); ++frame)
    for (const Pose& pose : poses_at(body, frame)) {
      for (const double x : pose.position) poses.push_back(static_cast<float>(x));
      for (const double x : pose.rotation.coeffs().normalized())
        poses.push_back(static_cast<float>(x));
    }
  const std::size_t width = 7 * body.bones();
  for (std::size_t i = width; i < poses.size(); ++i)
    if (poses[i] != poses[i - width]) return poses;
  poses.resize(width);
  return poses;
}

std::string page_body_text(const Animation& animation, const AnimatedBody& body) {
  std::vector<std::string> members = {
      page_member("name", json_string(body.name)),
      page_member("shape", json_number(body.shape)),
      page_member("bones", json_number(body.bones())),
      page_member("scenery", body.collider ? "true" : "false"),
      page_member("q", page_array("float32", std::vector<float>(body.q.begin(), body.q.end()))),
      page_member("poses", page_array("float32", page_poses(animation, body)))};
  if (!body.shown.empty())
    members.push_back(page_member(
        "shown",
        page_array("uint32", std::vector<std::uint32_t>(body.shown.begin(), body.shown.end()))));
  if (body.weights.cols() > 0)
    members.push_back(page_member(
        "weights",
        page_array("float32", std::vector<float>(body.weights.data(),
                                                 body.weights.data() + body.weights.size()))));
  return page_object(members);
}

// The largest distance between the page's positions and X + U q, relative to the shape's size.
double page_error(const Animation& animation, std::size_t number, const PageFields& fields) {
  const AnimatedShape& shape = animation.shapes[number];
  const Index rows = shape.modes.rows(), r = shape.modes.cols();
  const std::vector<float> rest = page_rest(shape);
  Eigen::MatrixXd wrong(3 * static_cast<Index>(shape.surface.vertices.size()), r + 1);
  for (Index k = 0; k < wrong.rows(); ++k)
    wrong(k, r) = static_cast<double>(rest[k]) - shape.surface.vertices[k / 3][k % 3];
  for (Index i = 0; i < r; ++i) wrong.col(i) = fields.column(i, rows) - shape.modes.col(i);
  double worst = 0.0;
  const std::size_t looks = std::min(kPageLooks, animation.frames());
  for (const AnimatedBody& body : animation.bodies) {
    if (body.shape != number) continue;
    for (std::size_t look = 0; look < looks; ++look) {
      const std::size_t frame = looks < 2 ? 0 : look * (animation.frames() - 1) / (looks - 1);
      const VectorXd q = coordinates_at(animation, body, frame);
      const VectorXd rounded = q.cast<float>().cast<double>();
      VectorXd error = wrong.leftCols(r) * rounded + wrong.col(r);
      if (r > 0) error += shape.modes * (rounded - q);
      worst = std::max(worst, Eigen::Map<const Eigen::Matrix3Xd>(error.data(), 3, error.size() / 3)
                                  .colwise()
                                  .norm()
                                  .maxCoeff());
    }
  }
  const double size = largest_extent(shape);
  return size > 0.0 ? worst / size : 0.0;
}

Status check_page_limits(const Animation& animation) {
  for (const AnimatedBody& body : animation.bodies) {
    const std::size_t r = animation.shape_of(body).modes.cols();
    if (r > kPageCoordinates)
      return content_error("body '" + body.name + "' has " + std::to_string(r) +
                           " coordinates, and a page draws " + std::to_string(kPageCoordinates) +
                           " at most: keep fewer (--modes), or write a .glb");
    if (body.bones() > kPageBones)
      return content_error("body '" + body.name + "' is on " + std::to_string(body.bones()) +
                           " bones, and a page draws " + std::to_string(kPageBones) +
                           " at most: write a .glb");
  }
  return Success{};
}

}  // namespace

Result<PageMotion> page_motion(const Animation& animation, bool z_up) {
  if (Status s = check_animation(animation); !s) return s.error();
  if (Status s = check_page_limits(animation); !s) return s.error();
  PageMotion motion;
  std::vector<std::string> shapes, bodies;
  for (std::size_t k = 0; k < animation.shapes.size(); ++k) {
    const PageFields fields = page_fields(animation, k);
    shapes.push_back(page_shape_text(animation.shapes[k], fields));
    motion.position_error = std::max(motion.position_error, page_error(animation, k, fields));
  }
  for (const AnimatedBody& body : animation.bodies)
    bodies.push_back(page_body_text(animation, body));
  const std::vector<float> times(animation.times.begin(), animation.times.end());
  motion.json = page_object({page_member("up", json_string(z_up ? "z" : "y")),
                             page_member("times", page_array("float32", times)),
                             page_member("shapes", json_list(shapes)),
                             page_member("bodies", json_list(bodies))});
  return motion;
}

Result<WrittenFile> write_motion_page(const std::string& path, const Animation& animation,
                                      bool z_up) {
  if (!path.ends_with(".html")) return usage_error(path + ": the name must end in .html");
  const Result<PageMotion> motion = page_motion(animation, z_up);
  if (!motion) return motion.error();
  const std::string film =
      page_object({page_member("kind", json_string("film")), "\"film\":" + motion->json});
  const std::string section =
      page_object({page_member("title", json_string("")), "\"parts\":[" + film + "]"});
  const std::string page = page_document(
      page_object({page_member("title", json_string(std::filesystem::path(path).stem().string())),
                   page_member("subtitle", json_string("")), "\"sections\":[" + section + "]"}));
  if (Status s = write_file(path, page); !s) return s.error();
  return WrittenFile{path, page.size()};
}

}  // namespace tremolo
