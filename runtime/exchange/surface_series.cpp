#include "runtime/exchange/surface_series.h"

#include <algorithm>
#include <filesystem>
#include <span>
#include <string_view>

#include "formats/file/atomic_file.h"
#include "formats/surface/surface_writer.h"
#include "formats/vtk/vtu_writer.h"
#include "runtime/exchange/json_text.h"
#include "runtime/exchange/morph_targets.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// "0012", with as many digits as the last frame needs, at least four.
std::string frame_digits(std::size_t frame, std::size_t frames) {
  const std::size_t width = std::max<std::size_t>(4, std::to_string(frames - 1).size());
  const std::string number = std::to_string(frame);
  return std::string(width - number.size(), '0') + number;
}

WrittenFile written_file(const std::string& path) {
  std::error_code ignored;
  return {path, fs::file_size(path, ignored)};
}

// A file's text with `<`, `&` and quotes as XML wants them.
std::string xml_text(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '&')
      safe += "&amp;";
    else if (c == '"')
      safe += "&quot;";
    else
      safe += c;
  }
  return safe;
}

// The body as it is in a frame; normals only where the shape came with some.
RenderSurface bent_surface(const Animation& animation, const AnimatedBody& body,
                           std::size_t frame) {
  RenderSurface bent = animation.shape_of(body).surface;
  const std::span<double> places(bent.vertices[0].data(), 3 * bent.vertices.size());
  world_positions(animation, body, frame, places);
  if (bent.normals.empty()) return bent;
  const std::vector<Eigen::Vector3d> normals =
      smooth_normals(animation.shape_of(body), bent.vertices);
  for (std::size_t v = 0; v < normals.size(); ++v) bent.normals[v] = normals[v].cast<float>();
  return bent;
}

bool stands_still(const Animation& animation, const AnimatedBody& body) {
  if (animation.shape_of(body).modes.cols() > 0 || !body.displacements.empty()) return false;
  for (const Pose& pose : body.poses)
    if (pose.position != body.poses[0].position ||
        pose.rotation.coeffs() != body.poses[0].rotation.coeffs())
      return false;
  return true;
}

Status write_frame_vtu(const std::string& path, const Animation& animation,
                       const AnimatedBody& body, std::size_t frame) {
  const RenderSurface& surface = animation.shape_of(body).surface;
  std::vector<double> places(3 * surface.vertices.size()), moved(places.size());
  world_positions(animation, body, frame, places);
  world_displacements(animation, body, frame, moved);
  const std::vector<float> points(places.begin(), places.end());
  const std::vector<float> vectors(moved.begin(), moved.end());
  return write_moved_vtu(path, points, surface.triangles, vectors);
}

}  // namespace

Result<std::vector<WrittenFile>> write_surface_series(const std::string& path,
                                                      const Animation& animation) {
  const std::string ending = fs::path(path).extension().string();
  if (ending != ".ply" && ending != ".obj")
    return usage_error(path + ": a series of surfaces ends in .ply or .obj");
  if (Status s = check_animation(animation); !s) return s.error();
  if (Status s = check_file_names(animation); !s) return s.error();
  std::vector<WrittenFile> files(1);
  std::string list = "frame,t,body,file\n";
  for (std::size_t frame = 0; frame < animation.frames(); ++frame)
    for (const std::size_t b : deforming_bodies(animation)) {
      const AnimatedBody& body = animation.bodies[b];
      const std::string name = without_ending(path_of_body(path, animation, b)) + "-" +
                               frame_digits(frame, animation.frames()) + ending;
      if (Status s = write_render_surface(name, bent_surface(animation, body, frame)); !s)
        return s.error();
      files.push_back(written_file(name));
      list += std::to_string(frame) + "," + json_number(animation.times[frame]) + "," + body.name +
              "," + fs::path(name).filename().string() + "\n";
    }
  const std::string csv = without_ending(path) + ".csv";
  if (Status s = write_file(csv, list); !s) return s.error();
  files[0] = {csv, list.size()};
  return files;
}

Result<std::vector<WrittenFile>> write_pvd(const std::string& path, const Animation& animation) {
  if (!path.ends_with(".pvd")) return usage_error(path + ": the name must end in .pvd");
  if (Status s = check_animation(animation); !s) return s.error();
  if (Status s = check_file_names(animation); !s) return s.error();
  const fs::path folder = without_ending(path) + "-frames";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return system_error(folder.string() + ": cannot create: " + error.message());
  std::vector<WrittenFile> files(1);
  std::string list =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (std::size_t frame = 0; frame < animation.frames(); ++frame)
    for (std::size_t b = 0; b < animation.bodies.size(); ++b) {
      const AnimatedBody& body = animation.bodies[b];
      const bool still = stands_still(animation, body);
      const fs::path name = folder / (file_name_of(body.name) + "-" +
                                      frame_digits(still ? 0 : frame, animation.frames()) + ".vtu");
      if (!still || frame == 0) {
        if (Status s = write_frame_vtu(name.string(), animation, body, frame); !s) return s.error();
        files.push_back(written_file(name.string()));
      }
      list += "<DataSet timestep=\"" + json_number(animation.times[frame]) + "\" group=\"" +
              xml_text(body.name) + "\" part=\"" + std::to_string(b) + "\" file=\"" +
              xml_text((folder.filename() / name.filename()).string()) + "\"/>\n";
    }
  list += "</Collection>\n</VTKFile>\n";
  if (Status s = write_file(path, list); !s) return s.error();
  files[0] = {path, list.size()};
  return files;
}

}  // namespace tremolo
