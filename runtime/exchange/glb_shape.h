// A shape's part of a .glb: its arrays, its materials and the members of its mesh.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"
#include "runtime/exchange/glb_file.h"
#include "runtime/exchange/glb_writer.h"
#include "runtime/exchange/morph_targets.h"

namespace tremolo {

// Lists at the file's top level, besides accessors; the entries are JSON.
struct GlbLists {
  std::vector<std::string> materials;
  std::vector<std::string> textures;
  std::vector<std::size_t> images;  // of GlbOptions::textures, each once; the image's number
};

// attributes: the members `"NAME":accessor` of the base. targets: the same of each target.
// primitives: of each material that has triangles, the accessor of its corners and its number in
// GlbLists::materials.
struct GlbShape {
  TargetRanges ranges;
  std::vector<std::string> attributes;
  std::vector<std::string> targets;
  struct Primitive {
    std::size_t indices;
    std::size_t material;
  };
  std::vector<Primitive> primitives;
};

// Reads the options' textures and adds them. Errors as write_glb.
Status add_textures(GlbFile& file, const GlbOptions& options, GlbLists& lists);

// Adds its numbers to the report.
GlbShape add_shape(GlbFile& file, const Animation& animation, std::size_t shape,
                   const GlbOptions& options, GlbLists& lists, GlbReport& report);

// The members of a body on bones: the joints and weights of its vertices, four a set, as many sets
// as the vertex with the most bones needs, which `most` receives.
std::vector<std::string> add_bone_weights(GlbFile& file, const BoneWeights& weights,
                                          std::size_t& most);

// GlbReport::four_bones_error of a body on bones; frames as morph_error takes them.
double four_bones_error(const Animation& animation, const AnimatedBody& body);

// The mesh of a body as JSON. further: members besides the shape's own; weights: at the start.
std::string mesh_text(const std::string& name, const GlbShape& shape,
                      const std::vector<std::string>& further, const std::vector<float>& weights);

}  // namespace tremolo
