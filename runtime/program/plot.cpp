#include "runtime/program/plot.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "formats/atomic_file.h"
#include "runtime/program/commands.h"
#include "runtime/program/report/gnuplot.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

std::string curves(const std::vector<PlotSource>& sources, const char* column) {
  // Told apart without colour too: the first is drawn thick below the others.
  static constexpr const char* kStyles[] = {"lw 2.5 lc rgb '#0060a8'", "lw 1 lc rgb '#d95f02'",
                                            "lw 1 lc rgb '#1b9e77'", "lw 1 lc rgb '#7570b3'",
                                            "lw 1 lc rgb '#666666'"};
  std::string plot = "plot ";
  for (std::size_t i = 0; i < sources.size(); ++i)
    plot += fmt::format("{}{} using 't':'{}' with lines {} title {} noenhanced", i == 0 ? "" : ", ",
                        gnuplot_quoted(sources[i].csv), column, kStyles[i % std::size(kStyles)],
                        gnuplot_quoted(sources[i].label));
  return plot + "\n";
}

std::string script(const std::vector<PlotSource>& sources, bool svg) {
  std::string text = svg ? "set terminal svg size 960,640 font 'sans,14' background 'white'\n"
                         : "set terminal pngcairo size 960,640 font 'sans,11'\n";
  text +=
      "set datafile separator ','\nset key autotitle columnhead\n"
      "set key outside top right horizontal\nset grid lc rgb '#dddddd'\nset border 3\nset tics "
      "nomirror\nset yrange [0:*]\n"
      "set multiplot layout 2,1\nset xlabel 'time (s)'\n"
      "set title 'total energy'\nset ylabel 'J'\n";
  text += curves(sources, "total");
  text += "set title 'energy of the high band'\n";
  text += curves(sources, "high_band");
  return text + "unset multiplot\n";
}

}  // namespace

Status plot_energies(const std::vector<PlotSource>& sources, const std::string& output) {
  const std::string ending = fs::path(output).extension().string();
  if (ending != ".svg" && ending != ".png")
    return Error{ErrorKind::kUsage, output + ": a plot ends in .svg or .png"};
  const Result<std::string> picture = run_gnuplot(script(sources, ending == ".svg"));
  if (!picture) return Error{picture.error().kind, output + ": " + picture.error().message};
  return write_file(output, *picture);
}

int plot_command(const std::vector<std::string>& directories, const std::string& output) {
  std::vector<PlotSource> sources;
  for (const std::string& directory : directories) {
    const fs::path path(directory);
    const fs::path csv = fs::is_directory(path) ? path / "run.csv" : path;
    if (!std::ifstream(csv)) return report_error(system_error(csv.string() + ": cannot open"));
    const fs::path folder = (fs::is_directory(path) ? path : path.parent_path()) / "";
    sources.push_back({folder.parent_path().filename().string(), csv.string()});
  }
  const Status status = plot_energies(sources, output);
  return status ? 0 : report_error(status.error());
}

}  // namespace tremolo
