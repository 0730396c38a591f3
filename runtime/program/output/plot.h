// Energies of runs as a page, or as a picture by gnuplot.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/program/output/energy_page.h"

namespace tremolo {

// Files in a run's folder.
inline constexpr const char* kEnergyPageName = "energy.html";
inline constexpr const char* kPictureName = "energy.svg";

// Draws the total energy of the runs over time, one curve per run, and below it the energy of the
// high band for runs that have one (`tremolo-precompute reference` has none). The extension of
// `output` selects the format: .html, a page with zoom and values under the pointer; .svg or .png,
// by gnuplot. Errors: kUsage for another extension, kContent for a CSV without the columns t and
// total, kSystem if gnuplot is missing (the message says how to install it) or fails.
Status plot_energies(const std::vector<PlotSource>& sources, const std::string& output);

// Writes energy.html to a folder and, if gnuplot is installed, energy.svg; adds the paths to
// `files`. Errors: as above, except for a missing gnuplot.
Status plot_run(const PlotSource& source, const std::string& folder,
                std::vector<std::string>& files);

// `tremolo plot`: the energies of these folders of `tremolo run --out`. The exit code; errors are
// printed on stderr.
int plot_command(const std::vector<std::string>& directories, const std::string& output);

}  // namespace tremolo
