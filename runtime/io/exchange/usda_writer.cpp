#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <span>
#include <string_view>

#include "formats/file/atomic_file.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/json_text.h"

namespace tremolo {
namespace {

// A file that grows by pieces of text, which are gathered; after an error the rest is passed over.
struct UsdText {
  AtomicFile file;
  Status status = Success{};
  std::uint64_t bytes = 0;
  std::string gathered = {};

  void add(std::string_view text) {
    constexpr std::size_t kPiece = 1 << 20;
    gathered += text;
    if (gathered.size() >= kPiece) flush();
  }
  void flush() {
    if (status) status = file.write(gathered);
    bytes += gathered.size();
    gathered.clear();
  }
};

// A frame's time code. Fifteen digits: 0.018 s times 60 is 1.08 and not its last bit's neighbour.
std::string time_code(const Animation& animation, double time) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.15g", time * animation.rate);
  return text;
}

std::string tuple3(const float* x) {
  char text[64];
  std::snprintf(text, sizeof(text), "(%.9g, %.9g, %.9g)", double{x[0]}, double{x[1]}, double{x[2]});
  return text;
}

std::string tuple_list(std::span<const double> places) {
  std::string text = "[";
  for (std::size_t i = 0; i + 2 < places.size(); i += 3) {
    const std::array<float, 3> x = {static_cast<float>(places[i]),
                                    static_cast<float>(places[i + 1]),
                                    static_cast<float>(places[i + 2])};
    if (i > 0) text += ", ";
    text += tuple3(x.data());
  }
  return text + "]";
}

// The extent of points in USD's form: the smallest and the largest corner.
std::string extent_list(std::span<const double> places) {
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i + 2 < places.size(); i += 3)
    box.extend(Eigen::Vector3d(places.data() + i).cast<float>());
  return "[" + tuple3(box.min().data()) + ", " + tuple3(box.max().data()) + "]";
}

// A prim's name: letters, digits and '_', not a digit first, each once.
std::string prim_name(std::string_view name, std::set<std::string>& taken) {
  std::string plain = "_";
  for (const char c : name) {
    const bool kept = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    plain += kept ? c : '_';
  }
  if (plain.size() > 1 && !(plain[1] >= '0' && plain[1] <= '9')) plain.erase(0, 1);
  std::string free = plain;
  for (int k = 2; !taken.insert(free).second; ++k) free = plain + "_" + std::to_string(k);
  return free;
}

// A value, or one for each frame's time code. text: of a frame. changes: write all of them.
template <class Text>
void add_samples(UsdText& out, const Animation& animation, const std::string& name, bool changes,
                 const Text& text) {
  if (!changes) return out.add("        " + name + " = " + text(0) + "\n");
  out.add("        " + name + ".timeSamples = {\n");
  for (std::size_t frame = 0; frame < animation.frames(); ++frame)
    out.add("            " + time_code(animation, animation.times[frame]) + ": " + text(frame) +
            ",\n");
  out.add("        }\n");
}

template <class Value>
bool differs(const AnimatedBody& body, const Value& value) {
  return std::any_of(body.poses.begin(), body.poses.end(),
                     [&](const Pose& pose) { return value(pose) != value(body.poses[0]); });
}

// double3 and quatd (w, x, y, z); the sign of a quaternion follows the frame before.
void add_pose(UsdText& out, const Animation& animation, const AnimatedBody& body) {
  std::vector<Eigen::Quaterniond> turns;
  for (const Pose& pose : body.poses) {
    Eigen::Quaterniond turn = pose.rotation.normalized();
    if (!turns.empty() && turn.dot(turns.back()) < 0.0) turn.coeffs() = -turn.coeffs();
    turns.push_back(turn);
  }
  const auto place = [&body](std::size_t frame) {
    const Eigen::Vector3d& x = body.poses[frame].position;
    return "(" + json_number(x.x()) + ", " + json_number(x.y()) + ", " + json_number(x.z()) + ")";
  };
  const auto turn = [&turns](std::size_t frame) {
    const Eigen::Quaterniond& q = turns[frame];
    return "(" + json_number(q.w()) + ", " + json_number(q.x()) + ", " + json_number(q.y()) + ", " +
           json_number(q.z()) + ")";
  };
  add_samples(out, animation, "double3 xformOp:translate",
              differs(body, [](const Pose& pose) { return pose.position; }), place);
  add_samples(out, animation, "quatd xformOp:orient",
              differs(body, [](const Pose& pose) { return pose.rotation.coeffs(); }), turn);
  out.add("        uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n");
}

void add_points(UsdText& out, const Animation& animation, const AnimatedBody& body) {
  const bool on_bones = body.weights.cols() > 0;
  const bool changes =
      on_bones || animation.shape_of(body).modes.cols() > 0 || !body.displacements.empty();
  std::vector<double> places(3 * animation.shape_of(body).surface.vertices.size());
  const auto read = [&](std::size_t frame) -> std::span<const double> {
    if (on_bones)
      world_positions(animation, body, frame, places);
    else
      local_positions(animation, body, frame, places);
    return places;
  };
  add_samples(out, animation, "point3f[] points", changes,
              [&](std::size_t frame) { return tuple_list(read(frame)); });
  add_samples(out, animation, "float3[] extent", changes,
              [&](std::size_t frame) { return extent_list(read(frame)); });
}

void add_triangles(UsdText& out, const RenderSurface& surface) {
  std::string counts = "[", corners = "[";
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    counts += t > 0 ? ", 3" : "3";
    for (const VertexId corner : surface.triangles[t])
      corners += (corners.size() > 1 ? ", " : "") + std::to_string(corner);
  }
  out.add("        int[] faceVertexCounts = " + counts + "]\n");
  out.add("        int[] faceVertexIndices = " + corners + "]\n");
  out.add(
      "        uniform token subdivisionScheme = \"none\"\n        uniform bool doubleSided = 1\n");
}

void add_primvars(UsdText& out, const RenderSurface& surface) {
  constexpr const char* kOfVertices = " (\n            interpolation = \"vertex\"\n        )\n";
  if (!surface.uvs.empty()) {
    std::string text;
    for (const Eigen::Vector2f& uv : surface.uvs)
      text += (text.empty() ? "(" : ", (") + json_number(uv[0]) + ", " + json_number(uv[1]) + ")";
    out.add("        texCoord2f[] primvars:st = [" + text + "]" + kOfVertices);
  }
  if (!surface.colours.empty()) {
    std::string text;
    for (const Colour& c : surface.colours) {
      const std::array<float, 3> rgb = {static_cast<float>(c[0]) / 255.0f,
                                        static_cast<float>(c[1]) / 255.0f,
                                        static_cast<float>(c[2]) / 255.0f};
      text += (text.empty() ? "" : ", ") + tuple3(rgb.data());
    }
    out.add("        color3f[] primvars:displayColor = [" + text + "]" + kOfVertices);
  }
}

// One subset of faces a material, where there are several.
void add_subsets(UsdText& out, const RenderSurface& surface) {
  if (surface.materials.size() < 2) return;
  std::set<std::string> taken;
  for (std::size_t m = 0; m < surface.materials.size(); ++m) {
    std::string faces;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
      if (surface.material_of[t] == m) faces += (faces.empty() ? "" : ", ") + std::to_string(t);
    out.add("        def GeomSubset \"" + prim_name(surface.materials[m], taken) +
            "\"\n        {\n            uniform token elementType = \"face\"\n"
            "            uniform token familyName = \"materialBind\"\n"
            "            int[] indices = [" +
            faces + "]\n        }\n");
  }
}

void add_mesh(UsdText& out, const Animation& animation, const AnimatedBody& body,
              const std::string& name) {
  const RenderSurface& surface = animation.shape_of(body).surface;
  out.add("    def Mesh \"" + name + "\"\n    {\n");
  add_triangles(out, surface);
  add_points(out, animation, body);
  if (body.weights.cols() == 0) add_pose(out, animation, body);
  if (!body.shown.empty())
    add_samples(out, animation, "token visibility", true, [&body](std::size_t frame) {
      return std::string(body.is_shown(frame) ? "\"inherited\"" : "\"invisible\"");
    });
  add_primvars(out, surface);
  add_subsets(out, surface);
  out.add("    }\n");
}

}  // namespace

Result<WrittenFile> write_usda(const std::string& path, const Animation& animation, bool z_up) {
  if (Status s = check_animation(animation); !s) return s.error();
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  UsdText out{std::move(*file)};
  out.add("#usda 1.0\n(\n    defaultPrim = \"tremolo\"\n    metersPerUnit = 1\n    upAxis = \"" +
          std::string(z_up ? "Z" : "Y") +
          "\"\n    startTimeCode = " + time_code(animation, animation.times.front()) +
          "\n    endTimeCode = " + time_code(animation, animation.times.back()) +
          "\n    timeCodesPerSecond = " + json_number(animation.rate) +
          "\n    framesPerSecond = " + json_number(animation.rate) + "\n)\n\n");
  out.add("def Xform \"tremolo\"\n{\n");
  std::set<std::string> taken;
  for (const AnimatedBody& body : animation.bodies)
    add_mesh(out, animation, body, prim_name(body.name, taken));
  out.add("}\n");
  out.flush();
  if (!out.status) return out.status.error();
  if (Status s = out.file.commit(); !s) return s.error();
  return WrittenFile{path, out.bytes};
}

}  // namespace tremolo
