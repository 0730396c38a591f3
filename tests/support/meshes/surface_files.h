// One box of 1 x 2 x 3, its corner at the origin, as many programs would save it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

namespace tremolo::testing {

using Corner = std::array<float, 3>;

inline const std::array<Corner, 8>& box_corners() {
  static const std::array<Corner, 8> corners = {
      {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0}, {0, 0, 3}, {1, 0, 3}, {1, 2, 3}, {0, 2, 3}}};
  return corners;
}

// Counter-clockwise seen from outside.
inline const std::array<std::array<std::uint16_t, 4>, 6>& box_quads() {
  static const std::array<std::array<std::uint16_t, 4>, 6> quads = {
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  return quads;
}

inline std::vector<std::array<std::uint16_t, 3>> box_triangles() {
  std::vector<std::array<std::uint16_t, 3>> triangles;
  for (const auto& q : box_quads()) {
    triangles.push_back({q[0], q[1], q[2]});
    triangles.push_back({q[0], q[2], q[3]});
  }
  return triangles;
}

template <class T>
void append_bytes(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

inline std::string corner_text(const Corner& x) {
  return std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]);
}

// Texture coordinates on every face, normals, two materials, one object.
inline std::string box_obj() {
  std::string text = "mtllib box.mtl\no Box\n";
  for (const Corner& x : box_corners()) text += "v " + corner_text(x) + "\n";
  text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
  text += "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 1 0 0\nvn 0 1 0\nvn -1 0 0\n";
  int face = 0;
  for (const auto& quad : box_quads()) {
    if (face % 3 == 0) text += face == 0 ? "usemtl steel\n" : "usemtl glass\n";
    text += "f";
    ++face;
    for (int c = 0; c < 4; ++c)
      text += " " + std::to_string(quad[c] + 1) + "/" + std::to_string(c + 1) + "/" +
              std::to_string(face);
    text += "\n";
  }
  return text;
}
inline std::string box_mtl() {
  return "newmtl steel\nKd 0.5 0.5 0.5\nnewmtl glass\nKd 0.1 0.2 0.3\n";
}

// Quads, and a colour at every vertex: red is x, green y / 2, blue z / 3.
inline std::string box_ply(bool binary) {
  std::string bytes = std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") +
                      " 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                      "property float z\nproperty uchar red\nproperty uchar green\n"
                      "property uchar blue\nelement face 6\n"
                      "property list uchar int vertex_indices\nend_header\n";
  for (const Corner& x : box_corners()) {
    const std::array<std::uint8_t, 3> colour = {static_cast<std::uint8_t>(x[0] * 255),
                                                static_cast<std::uint8_t>(x[1] * 255 / 2),
                                                static_cast<std::uint8_t>(x[2] * 255 / 3)};
    if (binary) {
      append_bytes(bytes, x);
      append_bytes(bytes, colour);
    } else {
      bytes += corner_text(x);
      for (const std::uint8_t c : colour) bytes += " " + std::to_string(c);
      bytes += "\n";
    }
  }
  for (const auto& quad : box_quads()) {
    bytes += binary ? std::string(1, '\4') : "4";
    for (const std::int32_t v : quad) {
      if (binary)
        append_bytes(bytes, v);
      else
        bytes += " " + std::to_string(v);
    }
    if (!binary) bytes += "\n";
  }
  return bytes;
}

inline std::string box_stl_text() {
  std::string text = "solid box\n";
  for (const auto& triangle : box_triangles()) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const std::uint16_t v : triangle) text += "vertex " + corner_text(box_corners()[v]) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

inline std::string box_stl_binary() {
  std::string bytes(80, ' ');
  append_bytes(bytes, static_cast<std::uint32_t>(box_triangles().size()));
  for (const auto& triangle : box_triangles()) {
    append_bytes(bytes, Corner{0, 0, 0});
    for (const std::uint16_t v : triangle) append_bytes(bytes, box_corners()[v]);
    append_bytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

inline std::string box_off() {
  std::string text = "OFF\n8 6 12\n";
  for (const Corner& x : box_corners()) text += corner_text(x) + "\n";
  for (const auto& quad : box_quads()) {
    text += "4";
    for (const std::uint16_t v : quad) text += " " + std::to_string(v);
    text += "\n";
  }
  return text;
}

// A prism over a star of 24 corners, as OBJ and as OFF with comments among its lines: the numbers
// are written with the same digits.
inline std::array<std::string, 2> star_prism() {
  constexpr int kCorners = 24;
  std::string obj, off = "OFF # a star\n# corners, faces\n48 26 0\n\n";
  for (int v = 0; v < 2 * kCorners; ++v) {
    const double turn = 2 * std::numbers::pi * (v % kCorners) / kCorners;
    const double radius = v % 2 == 0 ? 0.123456 : 0.2;
    const std::string x = std::to_string(radius * std::cos(turn)) + " " +
                          std::to_string(radius * std::sin(turn)) + " " +
                          std::to_string(v < kCorners ? 1.0 / 3 : 1.2);
    obj += "v " + x + "\n";
    off += x + (v % 7 == 0 ? " # seventh\n# next\n" : "\n");
  }
  const auto face = [&](const std::vector<int>& corners) {
    obj += "f";
    off += "# a face\n" + std::to_string(corners.size());
    for (const int v : corners) {
      obj += " " + std::to_string(v + 1);
      off += " " + std::to_string(v);
    }
    obj += "\n";
    off += "\n";
  };
  std::vector<int> low, high;
  for (int i = 0; i < kCorners; ++i) {
    low.push_back(kCorners - 1 - i);
    high.push_back(kCorners + i);
  }
  face(low);
  face(high);
  for (int i = 0; i < kCorners; ++i) {
    const int next = (i + 1) % kCorners;
    face({i, next, kCorners + next, kCorners + i});
  }
  return {obj, off};
}

// Positions, texture coordinates and colours (corner i: u = i / 8, v = 1 - i / 16; red i / 8), then
// indices: 96 + 64 + 128 + 72 bytes.
inline std::string box_gltf_buffer() {
  std::string bytes;
  for (const Corner& x : box_corners()) append_bytes(bytes, x);
  for (int i = 0; i < 8; ++i)
    append_bytes(bytes, std::array<float, 2>{float(i) / 8, 1 - float(i) / 16});
  for (int i = 0; i < 8; ++i) append_bytes(bytes, std::array<float, 4>{float(i) / 8, 0, 1, 1});
  for (const auto& triangle : box_triangles()) append_bytes(bytes, triangle);
  return bytes;
}

// uri: where the buffer is, "" for the binary chunk of a GLB. nodes: the scene's JSON of them.
inline std::string box_gltf(std::string_view uri,
                            std::string_view nodes = R"([{"name":"Box","mesh":0}])",
                            std::string_view roots = "[0]") {
  std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":)";
  text += roots;
  text += R"(}],"nodes":)";
  text += nodes;
  text += R"(,"materials":[{"name":"brass"}],"meshes":[{"name":"shape","primitives":[{
    "attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2},"indices":3,"material":0,"mode":4}]}],
    "accessors":[
    {"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[1,2,3]},
    {"bufferView":1,"componentType":5126,"count":8,"type":"VEC2"},
    {"bufferView":2,"componentType":5126,"count":8,"type":"VEC4"},
    {"bufferView":3,"componentType":5123,"count":36,"type":"SCALAR"}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":96},
    {"buffer":0,"byteOffset":96,"byteLength":64},{"buffer":0,"byteOffset":160,"byteLength":128},
    {"buffer":0,"byteOffset":288,"byteLength":72}],"buffers":[{"byteLength":360)";
  if (!uri.empty()) text += ",\"uri\":\"" + std::string(uri) + "\"";
  return text + "}]}";
}

inline std::string base64_text(std::string_view bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

inline std::string data_uri(std::string_view bytes) {
  return "data:application/octet-stream;base64," + base64_text(bytes);
}

inline std::string box_glb() {
  std::string json = box_gltf("");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = box_gltf_buffer();
  std::string bytes = "glTF";
  append_bytes(bytes, std::uint32_t{2});
  append_bytes(bytes, static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
  append_bytes(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  append_bytes(bytes, static_cast<std::uint32_t>(buffer.size()));
  return bytes + std::string("BIN\0", 4) + buffer;
}

// In centimetres, 100 times the box.
inline std::string box_dae() {
  std::string places;
  for (const Corner& x : box_corners())
    places += corner_text({x[0] * 100, x[1] * 100, x[2] * 100}) + " ";
  std::string indices;
  for (const auto& triangle : box_triangles())
    for (const std::uint16_t v : triangle) indices += std::to_string(v) + " ";
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="shape"><mesh><source id="p">
<float_array id="pa" count="24">)" +
         places +
         R"(</float_array><technique_common><accessor source="#pa" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>)" +
         indices +
         R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s" name="S"><node id="n" name="Box">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";
}

// In inches, 100 times the box.
inline std::string box_fbx() {
  std::string places;
  for (const Corner& x : box_corners())
    for (const float value : x) places += (places.empty() ? "" : ",") + std::to_string(value * 100);
  std::string indices;
  for (const auto& quad : box_quads())
    for (int c = 0; c < 4; ++c)
      indices +=
          (indices.empty() ? "" : ",") + std::to_string(c < 3 ? int(quad[c]) : -int(quad[c]) - 1);
  return R"(; FBX 7.3.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7300
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",2
		P: "UnitScaleFactor", "double", "Number", "",2.54
	}
}
Objects:  {
	Geometry: 1000, "Geometry::", "Mesh" {
		Vertices: *24 {
			a: )" +
         places + R"(
		}
		PolygonVertexIndex: *24 {
			a: )" +
         indices + R"(
		}
		GeometryVersion: 124
	}
	Model: 2000, "Model::Box", "Mesh" {
		Version: 232
		Shading: Y
		Culling: "CullingOff"
	}
}
Connections:  {
	C: "OO",2000,0
	C: "OO",1000,2000
}
)";
}

}  // namespace tremolo::testing
