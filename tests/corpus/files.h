// Shapes as the bytes of surface files.
#pragma once

#include <string>
#include <vector>

#include "tests/corpus/shapes.h"

namespace tremolo::corpus {

std::string obj_bytes(const Shape& shape, const std::string& name = "part");
std::string ply_bytes(const Shape& shape, bool binary);
std::string off_bytes(const Shape& shape);
// Triangles; of larger polygons fans.
std::string stl_bytes(const Shape& shape, bool binary);

// node: the JSON of its transform, such as "\"translation\":[1,0,0]"; may be empty.
struct Instance {
  std::string name;
  std::size_t part = 0;
  std::string transform;
};
// One mesh and one material a part, the buffer inside the text.
std::string gltf_bytes(const std::vector<Shape>& parts, const std::vector<Instance>& instances);

}  // namespace tremolo::corpus
