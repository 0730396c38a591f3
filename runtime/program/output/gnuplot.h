// A pipe to gnuplot.
#pragma once

#include <string>

#include "common/result.h"

namespace tremolo {

// Within gnuplot's single quotes, where nothing but the quote itself is special. A line break,
// which would end the command, becomes a space.
std::string gnuplot_quoted(const std::string& text);

// True if gnuplot is on the PATH.
bool has_gnuplot();

// Runs a script that sets its own terminal and no output; returns the picture's bytes. Errors:
// kSystem if gnuplot is missing (the message says how to install it), fails or draws nothing.
// Messages of gnuplot go to stderr.
Result<std::string> run_gnuplot(const std::string& script);

}  // namespace tremolo
