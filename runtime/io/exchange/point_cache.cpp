#include <algorithm>
#include <bit>
#include <filesystem>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "formats/file/atomic_file.h"
#include "formats/file/stored_values.h"
#include "formats/surface/surface_writer.h"
#include "runtime/io/exchange/animation_writer.h"

namespace tremolo {
namespace {

std::uint32_t swapped(std::uint32_t word) {
  return word >> 24 | (word >> 8 & 0xFF00U) | (word << 8 & 0xFF0000U) | word << 24;
}

// Words of a file in its order of bytes.
struct CacheBytes {
  bool big_endian = false;
  std::string bytes = {};

  void add(std::uint32_t word) { append_bytes(bytes, big_endian ? swapped(word) : word); }
  void add(float value) { add(std::bit_cast<std::uint32_t>(value)); }
};

Status check_cache(const std::string& path, const Animation& animation, std::size_t body) {
  if (Status s = check_animation(animation); !s) return s;
  if (body >= animation.bodies.size())
    return usage_error(path + ": there is no body " + std::to_string(body));
  if (Status s = check_all_shown(path, animation.bodies[body]); !s) return s;
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  const std::size_t vertices = animation.shape_of(animation.bodies[body]).surface.vertices.size();
  if (vertices > kMost || animation.frames() > kMost)
    return content_error(path + ": more vertices or frames than the format counts");
  return Success{};
}

// The head, then the positions of all frames.
Result<WrittenFile> write_cache(const std::string& path, const Animation& animation,
                                std::size_t body, CacheBytes head) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  const AnimatedBody& known = animation.bodies[body];
  std::vector<double> places(3 * animation.shape_of(known).surface.vertices.size());
  // Copies of a vertex move with it: the author's mesh has it once.
  const std::size_t numbers = 3 * animation.shape_of(known).surface.authored();
  CacheBytes& frame_bytes = head;
  WrittenFile written{path, 0};
  for (std::size_t frame = 0; frame < animation.frames(); ++frame) {
    world_positions(animation, known, frame, places);
    for (std::size_t i = 0; i < numbers; ++i) frame_bytes.add(static_cast<float>(places[i]));
    if (Status s = file->write(frame_bytes.bytes); !s) return s.error();
    written.bytes += frame_bytes.bytes.size();
    frame_bytes.bytes.clear();
  }
  if (Status s = file->commit(); !s) return s.error();
  return written;
}

}  // namespace

Result<WrittenFile> write_pc2(const std::string& path, const Animation& animation,
                              std::size_t body) {
  if (Status s = check_cache(path, animation, body); !s) return s.error();
  CacheBytes head;
  head.bytes.assign("POINTCACHE2\0", 12);
  head.add(std::uint32_t{1});
  head.add(
      static_cast<std::uint32_t>(animation.shape_of(animation.bodies[body]).surface.authored()));
  head.add(0.0f);
  head.add(1.0f);
  head.add(static_cast<std::uint32_t>(animation.frames()));
  return write_cache(path, animation, body, std::move(head));
}

Result<WrittenFile> write_mdd(const std::string& path, const Animation& animation,
                              std::size_t body) {
  if (Status s = check_cache(path, animation, body); !s) return s.error();
  CacheBytes head{true};
  head.add(static_cast<std::uint32_t>(animation.frames()));
  head.add(
      static_cast<std::uint32_t>(animation.shape_of(animation.bodies[body]).surface.authored()));
  for (const double t : animation.times) head.add(static_cast<float>(t));
  return write_cache(path, animation, body, std::move(head));
}

Result<WrittenFile> write_rest_obj(const std::string& path, const Animation& animation,
                                   std::size_t body) {
  if (Status s = check_cache(path, animation, body); !s) return s.error();
  // As one object, whatever parts it had: readers make a mesh of each, and a cache moves only one.
  RenderSurface surface = animation.shape_of(animation.bodies[body]).surface;
  surface.objects = {animation.bodies[body].name};
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.normals.clear();
  if (Status s = write_render_surface(path, surface); !s) return s.error();
  std::error_code ignored;
  return WrittenFile{path, std::filesystem::file_size(path, ignored)};
}

std::string file_name_of(std::string_view name) {
  constexpr std::string_view kKept =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  std::string kept(name);
  std::replace_if(
      kept.begin(), kept.end(), [&](char c) { return kKept.find(c) == std::string_view::npos; },
      '_');
  return kept;
}

Status check_file_names(const Animation& animation) {
  std::map<std::string, std::string> taken;
  for (const AnimatedBody& body : animation.bodies)
    if (const auto [other, is_new] = taken.try_emplace(file_name_of(body.name), body.name); !is_new)
      return usage_error("bodies '" + other->second + "' and '" + body.name +
                         "' would be written into the same files");
  return Success{};
}

std::string without_ending(const std::string& path) {
  return std::filesystem::path(path).replace_extension().string();
}

std::vector<std::size_t> deforming_bodies(const Animation& animation) {
  std::vector<std::size_t> bodies;
  for (std::size_t b = 0; b < animation.bodies.size(); ++b)
    if (!animation.bodies[b].collider) bodies.push_back(b);
  return bodies;
}

std::string path_of_body(const std::string& path, const Animation& animation, std::size_t body) {
  if (deforming_bodies(animation).size() < 2) return path;
  return without_ending(path) + "-" + file_name_of(animation.bodies[body].name) +
         std::filesystem::path(path).extension().string();
}

Result<std::vector<WrittenFile>> write_point_caches(const std::string& path,
                                                    const Animation& animation) {
  const bool mdd = path.ends_with(".mdd");
  if (!mdd && !path.ends_with(".pc2"))
    return usage_error(path + ": a point cache ends in .pc2 or .mdd");
  if (Status s = check_file_names(animation); !s) return s.error();
  for (const std::size_t body : deforming_bodies(animation))
    if (Status s = check_all_shown(path, animation.bodies[body]); !s) return s.error();
  std::vector<WrittenFile> files;
  for (const std::size_t body : deforming_bodies(animation)) {
    const std::string cache = path_of_body(path, animation, body);
    const Result<WrittenFile> written =
        mdd ? write_mdd(cache, animation, body) : write_pc2(cache, animation, body);
    if (!written) return written.error();
    files.push_back(*written);
    const Result<WrittenFile> rest =
        write_rest_obj(without_ending(cache) + ".obj", animation, body);
    if (!rest) return rest.error();
    files.push_back(*rest);
  }
  if (files.empty()) return usage_error(path + ": there is no body that deforms");
  return files;
}

}  // namespace tremolo
