#include "tests/corpus/files.h"

#include <array>
#include <cstdint>
#include <cstdio>

#include <Eigen/Geometry>

#include "tests/support/meshes/surface_files.h"

namespace tremolo::corpus {
namespace {

using testing::append_bytes;

std::string text_of(const Vector3d& x) {
  std::array<char, 96> text = {};
  std::snprintf(text.data(), text.size(), "%.9g %.9g %.9g", x.x(), x.y(), x.z());
  return text.data();
}

std::array<float, 3> floats_of(const Vector3d& x) {
  return {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())};
}

}  // namespace

std::string obj_bytes(const Shape& shape, const std::string& name) {
  std::string text = "o " + name + "\n";
  for (const Vector3d& x : shape.points) text += "v " + text_of(x) + "\n";
  for (const Polygon& face : shape.faces) {
    text += "f";
    for (const int v : face) text += " " + std::to_string(v + 1);
    text += "\n";
  }
  return text;
}

std::string ply_bytes(const Shape& shape, bool binary) {
  std::string bytes = std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") +
                      " 1.0\nelement vertex " + std::to_string(shape.points.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                      std::to_string(shape.faces.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3d& x : shape.points) {
    if (binary)
      append_bytes(bytes, floats_of(x));
    else
      bytes += text_of(x) + "\n";
  }
  for (const Polygon& face : shape.faces) {
    if (binary) {
      append_bytes(bytes, static_cast<std::uint8_t>(face.size()));
      for (const std::int32_t v : face) append_bytes(bytes, v);
      continue;
    }
    bytes += std::to_string(face.size());
    for (const int v : face) bytes += " " + std::to_string(v);
    bytes += "\n";
  }
  return bytes;
}

std::string off_bytes(const Shape& shape) {
  std::string text = "OFF\n" + std::to_string(shape.points.size()) + " " +
                     std::to_string(shape.faces.size()) + " 0\n";
  for (const Vector3d& x : shape.points) text += text_of(x) + "\n";
  for (const Polygon& face : shape.faces) {
    text += std::to_string(face.size());
    for (const int v : face) text += " " + std::to_string(v);
    text += "\n";
  }
  return text;
}

std::string stl_bytes(const Shape& shape, bool binary) {
  const Shape cut = triangulated(shape);
  std::string bytes = binary ? std::string(80, ' ') : "solid part\n";
  if (binary) append_bytes(bytes, static_cast<std::uint32_t>(cut.faces.size()));
  for (const Polygon& face : cut.faces) {
    const Vector3d& a = cut.points[face[0]];
    const Vector3d& b = cut.points[face[1]];
    const Vector3d& c = cut.points[face[2]];
    const Vector3d normal = (b - a).cross(c - a).stableNormalized();
    if (binary) {
      for (const Vector3d& x : {normal, a, b, c}) append_bytes(bytes, floats_of(x));
      append_bytes(bytes, std::uint16_t{0});
      continue;
    }
    bytes += "facet normal " + text_of(normal) + "\nouter loop\n";
    for (const Vector3d& x : {a, b, c}) bytes += "vertex " + text_of(x) + "\n";
    bytes += "endloop\nendfacet\n";
  }
  return binary ? bytes : bytes + "endsolid part\n";
}

std::string gltf_bytes(const std::vector<Shape>& parts, const std::vector<Instance>& instances) {
  std::string buffer;
  std::string views;
  std::string accessors;
  std::string meshes;
  std::string materials;
  const auto view = [&](std::size_t start) {
    views += (views.empty() ? "" : ",") + std::string("{\"buffer\":0,\"byteOffset\":") +
             std::to_string(start) + ",\"byteLength\":" + std::to_string(buffer.size() - start) +
             "}";
  };
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const Shape cut = triangulated(parts[p]);
    const std::string first = std::to_string(2 * p);
    const std::string second = std::to_string(2 * p + 1);
    std::size_t start = buffer.size();
    Vector3d low = cut.points.front();
    Vector3d high = low;
    for (const Vector3d& x : cut.points) {
      append_bytes(buffer, floats_of(x));
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    view(start);
    start = buffer.size();
    for (const Polygon& face : cut.faces)
      for (const std::uint32_t v : face) append_bytes(buffer, v);
    view(start);
    const auto vector = [](const Vector3d& x) {
      std::string text = "[" + text_of(x) + "]";
      for (char& c : text)
        if (c == ' ') c = ',';
      return text;
    };
    accessors +=
        (p == 0 ? "" : ",") + ("{\"bufferView\":" + first) +
        ",\"componentType\":5126,\"type\":\"VEC3\",\"count\":" + std::to_string(cut.points.size()) +
        ",\"min\":" + vector(low) + ",\"max\":" + vector(high) + "},{\"bufferView\":" + second +
        ",\"componentType\":5125,\"type\":\"SCALAR\",\"count\":" +
        std::to_string(3 * cut.faces.size()) + "}";
    meshes += (p == 0 ? "" : ",") + ("{\"primitives\":[{\"attributes\":{\"POSITION\":" + first) +
              "},\"indices\":" + second + ",\"material\":" + std::to_string(p) + "}]}";
    materials += (p == 0 ? "" : ",") + ("{\"name\":\"material " + std::to_string(p) + "\"}");
  }
  std::string nodes;
  std::string roots;
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Instance& instance = instances[i];
    nodes += (i == 0 ? "" : ",") + ("{\"name\":\"" + instance.name) +
             "\",\"mesh\":" + std::to_string(instance.part) +
             (instance.transform.empty() ? "" : ",") + instance.transform + "}";
    roots += (i == 0 ? "" : ",") + std::to_string(i);
  }
  return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[" + roots +
         "]}],\"nodes\":[" + nodes + "],\"meshes\":[" + meshes + "],\"materials\":[" + materials +
         "],\"accessors\":[" + accessors + "],\"bufferViews\":[" + views +
         "],\"buffers\":[{\"byteLength\":" + std::to_string(buffer.size()) + ",\"uri\":\"" +
         testing::data_uri(buffer) + "\"}]}\n";
}

}  // namespace tremolo::corpus
