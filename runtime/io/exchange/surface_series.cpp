#include <algorithm>
#include <filesystem>
#include <span>
#include <string_view>
#include <unordered_set>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "formats/file/output_guard.h"
#include "formats/surface/surface_writer.h"
#include "formats/vtk/vtu_writer.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/json_text.h"
#include "runtime/io/exchange/morph_targets.h"

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

// A text with `<`, `&` and quotes escaped for XML.
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

bool is_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

// The part before the frame's number; empty for a name without one.
std::string_view before_number(std::string_view stem) {
  const std::size_t dash = stem.rfind('-');
  if (dash == std::string_view::npos || stem.size() - dash < 5) return {};
  return is_digits(stem.substr(dash + 1)) ? stem.substr(0, dash) : std::string_view();
}

// True if the name is that of a file of the series `path`.
bool is_of_series(const fs::path& path, std::string_view name) {
  const fs::path file(name);
  const std::string_view front =
      before_number(name.substr(0, name.size() - file.extension().string().size()));
  const std::string stem = path.stem().string();
  return file.extension() == path.extension() && (front == stem || front.starts_with(stem + "-"));
}

// The first line of a text and the rest of it.
std::string_view next_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

// An earlier list; empty if this program did not write it.
std::string earlier_list(const std::string& path, std::string_view head) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  const Result<std::string> text = read_whole_file(path);
  return text && text->starts_with(head) ? *text : std::string();
}

// Removes the files that an earlier list names and that were not written now. Nothing else.
Status remove_others(const std::vector<std::string>& listed,
                     const std::vector<WrittenFile>& written) {
  std::unordered_set<std::string> kept;
  for (const WrittenFile& file : written) kept.insert(fs::path(file.path).lexically_normal());
  for (const std::string& path : listed) {
    std::error_code ignored;
    if (kept.contains(fs::path(path).lexically_normal())) continue;
    if (!fs::is_regular_file(fs::symlink_status(path, ignored))) continue;
    if (Status s = remove_result(path); !s) return s;
  }
  return Success{};
}

// Paths of a list's last column, of those that are named as the series' own files.
std::vector<std::string> files_in_csv(const std::string& path, const std::string& text) {
  std::vector<std::string> files;
  std::string_view rest = text;
  for (next_line(rest); !rest.empty();) {
    const std::string_view line = next_line(rest);
    const std::string name(line.substr(line.rfind(',') + 1));
    if (is_of_series(path, name)) files.push_back((fs::path(path).parent_path() / name).string());
  }
  return files;
}

// Paths of a .pvd's files in its own folder.
std::vector<std::string> files_in_pvd(const std::string& path, const std::string& text) {
  constexpr std::string_view kFile = " file=\"";
  std::vector<std::string> files;
  const fs::path folder(folder_of_pvd(path));
  std::string_view rest = text;
  while (!rest.empty()) {
    std::string_view line = next_line(rest);
    const std::size_t at = line.find(kFile);
    if (at == std::string_view::npos) continue;
    line.remove_prefix(at + kFile.size());
    const fs::path name = fs::path(line.substr(0, line.find('"'))).filename();
    if (name.extension() == ".vtu" && !before_number(name.stem().string()).empty())
      files.push_back((folder / name).string());
  }
  return files;
}

constexpr std::string_view kSeriesHead = "frame,t,body,file\n";
constexpr std::string_view kPvdHead =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
    "byte_order=\"LittleEndian\">\n<Collection>\n";

// The body's surface in a frame; with normals only if the shape has some.
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

std::size_t first_shown(const AnimatedBody& body) {
  std::size_t frame = 0;
  while (!body.is_shown(frame)) ++frame;
  return frame;
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

std::string list_of_series(const std::string& path) {
  return without_ending(path) + ".csv";
}

std::string folder_of_pvd(const std::string& path) {
  return without_ending(path) + "-frames";
}

std::vector<std::string> files_of_series(const std::string& path) {
  return files_like(fs::path(path).parent_path().string(),
                    [&path](std::string_view name) { return is_of_series(path, name); });
}

std::vector<std::string> files_of_pvd(const std::string& path) {
  return files_like(folder_of_pvd(path),
                    [](std::string_view name) { return name.ends_with(".vtu"); });
}

Result<std::vector<WrittenFile>> write_surface_series(const std::string& path,
                                                      const Animation& animation) {
  const std::string ending = fs::path(path).extension().string();
  if (ending != ".ply" && ending != ".obj")
    return usage_error(path + ": a series of surfaces ends in .ply or .obj");
  if (Status s = check_animation(animation); !s) return s.error();
  if (Status s = check_file_names(animation); !s) return s.error();
  std::vector<WrittenFile> files(1);
  std::string list(kSeriesHead);
  for (std::size_t frame = 0; frame < animation.frames(); ++frame)
    for (const std::size_t b : deforming_bodies(animation)) {
      const AnimatedBody& body = animation.bodies[b];
      if (!body.is_shown(frame)) continue;
      const std::string name = without_ending(path_of_body(path, animation, b)) + "-" +
                               frame_digits(frame, animation.frames()) + ending;
      if (Status s = write_render_surface(name, bent_surface(animation, body, frame)); !s)
        return s.error();
      files.push_back(written_file(name));
      list += std::to_string(frame) + "," + json_number(animation.times[frame]) + "," + body.name +
              "," + fs::path(name).filename().string() + "\n";
    }
  const std::string csv = list_of_series(path);
  const std::string before = earlier_list(csv, kSeriesHead);
  if (Status s = write_file(csv, list); !s) return s.error();
  files[0] = {csv, list.size()};
  if (Status s = remove_others(files_in_csv(path, before), files); !s) return s.error();
  return files;
}

Result<std::vector<WrittenFile>> write_pvd(const std::string& path, const Animation& animation) {
  if (!path.ends_with(".pvd")) return usage_error(path + ": the name must end in .pvd");
  if (Status s = check_animation(animation); !s) return s.error();
  if (Status s = check_file_names(animation); !s) return s.error();
  const fs::path folder = folder_of_pvd(path);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return system_error(folder.string() + ": cannot create: " + error.message());
  std::vector<WrittenFile> files(1);
  std::string list(kPvdHead);
  for (std::size_t frame = 0; frame < animation.frames(); ++frame)
    for (std::size_t b = 0; b < animation.bodies.size(); ++b) {
      const AnimatedBody& body = animation.bodies[b];
      if (!body.is_shown(frame)) continue;
      const bool still = stands_still(animation, body);
      const fs::path name = folder / (file_name_of(body.name) + "-" +
                                      frame_digits(still ? 0 : frame, animation.frames()) + ".vtu");
      if (!still || frame == first_shown(body)) {
        if (Status s = write_frame_vtu(name.string(), animation, body, frame); !s) return s.error();
        files.push_back(written_file(name.string()));
      }
      list += "<DataSet timestep=\"" + json_number(animation.times[frame]) + "\" group=\"" +
              xml_text(body.name) + "\" part=\"" + std::to_string(b) + "\" file=\"" +
              xml_text((folder.filename() / name.filename()).string()) + "\"/>\n";
    }
  list += "</Collection>\n</VTKFile>\n";
  const std::string before = earlier_list(path, kPvdHead);
  if (Status s = write_file(path, list); !s) return s.error();
  files[0] = {path, list.size()};
  if (Status s = remove_others(files_in_pvd(path, before), files); !s) return s.error();
  return files;
}

}  // namespace tremolo
