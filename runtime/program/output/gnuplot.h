// A pipe to gnuplot.
#pragma once

#include <string>

#include "common/result.h"

namespace tremolo {

// Within gnuplot's single quotes, where nothing but the quote itself is special. A line break,
// which would end the command, becomes a space.
std::string gnuplot_quoted(const std::string& text);

// Whether a program of that name is on the PATH.
bool has_gnuplot();

// The picture, as bytes, that a script draws; it sets its own terminal and no output. Errors:
// kSystem if gnuplot is missing (the message tells how to get it), fails or draws nothing;
// gnuplot's own words go to stderr.
Result<std::string> run_gnuplot(const std::string& script);

}  // namespace tremolo
