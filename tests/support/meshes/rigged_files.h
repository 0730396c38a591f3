// The box of surface_files.h on two bones: "hip.L" from the origin carries its foot, "knee joint"
// from z = 1.5 its top; the clip "bend" turns the knee by a right angle about x in one second.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "tests/support/meshes/surface_files.h"

namespace tremolo::testing {

// weights_of_bytes: the weights are normalised bytes in place of floats.
inline std::string rigged_gltf(bool weights_of_bytes = false) {
  std::string buffer = box_gltf_buffer();
  std::string views, accessors;
  int count = 4;
  const auto add = [&](const std::string& bytes, int component, int rows, const char* type,
                       bool normalised = false) {
    views += ",{\"buffer\":0,\"byteOffset\":" + std::to_string(buffer.size()) +
             ",\"byteLength\":" + std::to_string(bytes.size()) + "}";
    accessors += ",{\"bufferView\":" + std::to_string(count) +
                 ",\"componentType\":" + std::to_string(component) +
                 (normalised ? ",\"normalized\":true" : "") + ",\"count\":" + std::to_string(rows) +
                 ",\"type\":\"" + type + "\"}";
    buffer += bytes;
    return count++;
  };
  std::string joints, weights, binds, times, turns;
  for (int v = 0; v < 8; ++v) {
    append_bytes(joints, std::array<std::uint8_t, 4>{static_cast<std::uint8_t>(v / 4), 0, 0, 0});
    if (weights_of_bytes)
      append_bytes(weights, std::array<std::uint8_t, 4>{255, 0, 0, 0});
    else
      append_bytes(weights, std::array<float, 4>{1, 0, 0, 0});
  }
  for (const float z : {0.0F, -1.5F})
    for (int k = 0; k < 16; ++k) append_bytes(binds, k == 14 ? z : k % 5 == 0 ? 1.0F : 0.0F);
  append_bytes(times, std::array<float, 2>{0, 1});
  const float half = std::sqrt(0.5F);
  append_bytes(turns, std::array<float, 8>{0, 0, 0, 1, half, 0, 0, half});
  const int at_joints = add(joints, 5121, 8, "VEC4");
  const int at_weights = add(weights, weights_of_bytes ? 5121 : 5126, 8, "VEC4", weights_of_bytes);
  const int at_binds = add(binds, 5126, 2, "MAT4");
  const int at_times = add(times, 5126, 2, "SCALAR");
  const int at_turns = add(turns, 5126, 2, "VEC4");
  std::string text = box_gltf(data_uri(buffer),
                              R"([{"name":"Box","mesh":0,"skin":0,"scale":[7,7,7]},
      {"name":"hip.L","children":[2]},{"name":"knee joint","translation":[0,0,1.5]}])",
                              "[0,1]");
  const auto change = [&text](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  change("\"COLOR_0\":2", "\"COLOR_0\":2,\"JOINTS_0\":" + std::to_string(at_joints) +
                              ",\"WEIGHTS_0\":" + std::to_string(at_weights));
  change("\"count\":36,\"type\":\"SCALAR\"}", "\"count\":36,\"type\":\"SCALAR\"}" + accessors);
  change("\"byteOffset\":288,\"byteLength\":72}", "\"byteOffset\":288,\"byteLength\":72}" + views);
  change("\"byteLength\":360", "\"byteLength\":" + std::to_string(buffer.size()));
  change("\"scene\":0",
         "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":" + std::to_string(at_binds) +
             "}],\"animations\":[{\"name\":\"bend\",\"samplers\":[{\"input\":" +
             std::to_string(at_times) + ",\"output\":" + std::to_string(at_turns) +
             "}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}}]}],"
             "\"scene\":0");
  return text;
}

// The same as text of FBX, in metres.
inline std::string rigged_fbx() {
  std::string text = box_fbx();
  const auto change = [&text](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  const auto cluster = [](int id, const char* indices, const char* height) {
    return "\tDeformer: " + std::to_string(id) +
           ", \"SubDeformer::\", \"Cluster\" {\n\t\tVersion: 100\n\t\tIndexes: *4 {\n\t\t\ta: " +
           indices +
           "\n\t\t}\n\t\tWeights: *4 {\n\t\t\ta: 1,1,1,1\n\t\t}\n\t\tTransform: *16 {\n\t\t\ta: "
           "1,0,0,0,0,1,0,0,0,0,1,0,0,0,-" +
           height +
           ",1\n\t\t}\n\t\tTransformLink: *16 {\n\t\t\ta: "
           "1,0,0,0,0,1,0,0,0,0,1,0,0,0," +
           height + ",1\n\t\t}\n\t}\n";
  };
  const auto limb = [](int id, const char* name, const char* height) {
    return "\tModel: " + std::to_string(id) + ", \"Model::" + name +
           "\", \"LimbNode\" {\n\t\tVersion: 232\n\t\tProperties70:  {\n\t\t\tP: \"Lcl "
           "Translation\", "
           "\"Lcl Translation\", \"\", \"A\",0,0," +
           height + "\n\t\t}\n\t}\n";
  };
  change("\"UnitScaleFactor\", \"double\", \"Number\", \"\",2.54",
         "\"UnitScaleFactor\", \"double\", \"Number\", \"\",1");
  change("Connections:  {",
         "Connections:  {\n\tC: \"OO\",4000,1000\n\tC: \"OO\",5000,4000\n\tC: \"OO\",5001,4000\n"
         "\tC: \"OO\",3000,5000\n\tC: \"OO\",3001,5001\n\tC: \"OO\",3000,0\n\tC: \"OO\",3001,3000\n"
         "\tC: \"OO\",6100,6000\n\tC: \"OO\",6200,6100\n\tC: \"OP\",6200,3001, \"Lcl Rotation\"\n"
         "\tC: \"OP\",6300,6200, \"d|X\"");
  change("\tModel: 2000",
         limb(3000, "hip.L", "0") + limb(3001, "knee joint", "150") +
             "\tDeformer: 4000, \"Deformer::\", \"Skin\" {\n\t\tVersion: 101\n\t}\n" +
             cluster(5000, "0,1,2,3", "0") + cluster(5001, "4,5,6,7", "150") +
             "\tAnimationStack: 6000, \"AnimStack::bend\", \"\" {\n\t}\n"
             "\tAnimationLayer: 6100, \"AnimLayer::Base\", \"\" {\n\t}\n"
             "\tAnimationCurveNode: 6200, \"AnimCurveNode::R\", \"\" {\n\t\tProperties70:  {\n"
             "\t\t\tP: \"d|X\", \"Number\", \"\", \"A\",0\n\t\t\tP: \"d|Y\", \"Number\", \"\", "
             "\"A\",0\n"
             "\t\t\tP: \"d|Z\", \"Number\", \"\", \"A\",0\n\t\t}\n\t}\n"
             "\tAnimationCurve: 6300, \"AnimCurve::\", \"\" {\n\t\tDefault: 0\n\t\tKeyVer: 4008\n"
             "\t\tKeyTime: *2 {\n\t\t\ta: 0,46186158000\n\t\t}\n"
             "\t\tKeyValueFloat: *2 {\n\t\t\ta: 0,90\n\t\t}\n\t}\n\tModel: 2000");
  return text;
}

}  // namespace tremolo::testing
