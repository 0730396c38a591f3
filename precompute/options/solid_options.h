// Command line options that describe the solid, shared by the precompute and its reference.
#pragma once

#include <CLI/CLI.hpp>

#include "precompute/problem/problem_request.h"

namespace tremolo {

// Options that are parsed as text first.
struct SolidTexts {
  std::string force;
  std::string mass = "consistent";
  std::string up = "z";
  std::string order = "auto";
  std::string subdivide = "auto";
};

// Parses X,Y,Z; returns false if the text is not three numbers.
bool parse_vector(const std::string& text, Eigen::Vector3d& vector);

// Returns false if `flag` is followed by several numbers instead of one word X,Y,Z, whose rest
// would be taken for the mesh's name. The error has been printed then.
bool vectors_are_words(const std::vector<std::string>& words, const std::string& flag);

// Adds the options for mesh, materials, fixed vertices and loads. Both references must stay valid
// until the line is parsed.
void add_solid_options(CLI::App& app, ProblemRequest& request, SolidTexts& texts);

// Converts the texts; returns false if one is invalid (the error has been printed).
bool finish_solid_options(const SolidTexts& texts, ProblemRequest& request);

}  // namespace tremolo
