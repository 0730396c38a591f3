// A pipe to gnuplot.
#pragma once

#include <string>

#include "common/result.h"

namespace tremolo {

// Within gnuplot's single quotes, where nothing but the quote itself is special. A line break,
// which would end the command, becomes a space.
std::string gnuplot_quoted(const std::string& text);

// Runs a script; it sets its own terminal and output. Errors: kSystem if gnuplot is missing (the
// message tells how to get it) or fails; gnuplot's own words go to stderr.
Status run_gnuplot(const std::string& script);

}  // namespace tremolo
