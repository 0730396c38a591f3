// The command line flags that say what solid it is, for the precompute and its reference alike.
#pragma once

#include <CLI/CLI.hpp>

#include "precompute/problem/problem_request.h"

namespace tremolo {

// What is read as text first.
struct SolidTexts {
  std::string force;
  std::string mass = "consistent";
  std::string up = "z";
};

// X,Y,Z; false when it is not three numbers.
bool parse_vector(const std::string& text, Eigen::Vector3d& vector);

// False when some `flag` is followed by several numbers instead of one word X,Y,Z: the rest would
// be taken for the mesh's name (the text has been printed).
bool vectors_are_words(const std::vector<std::string>& words, const std::string& flag);

// Mesh, materials, what is held and what is loaded. Both are borrowed until the line is parsed.
void add_solid_options(CLI::App& app, ProblemRequest& request, SolidTexts& texts);

// Texts to values; false when one is wrong (the text has been printed).
bool finish_solid_options(const SolidTexts& texts, ProblemRequest& request);

}  // namespace tremolo
