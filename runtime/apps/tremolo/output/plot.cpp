#include "runtime/apps/tremolo/output/plot.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "formats/file/output_guard.h"
#include "formats/file/scanner.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

bool has_column(std::string_view header, std::string_view name) {
  const std::vector<std::string_view> names = cells_of(header);
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The line of column names.
Result<std::string> read_header(const std::string& csv) {
  const Result<MappedFile> file = MappedFile::open(csv);
  if (!file) return file.error();
  const std::string_view text(reinterpret_cast<const char*>(file->bytes().data()),
                              file->bytes().size());
  std::string header(text.substr(0, text.find('\n')));
  if (!header.empty() && header.back() == '\r') header.pop_back();
  for (const char* name : {"t", "total"})
    if (!has_column(header, name))
      return content_error(csv + ", line 1: expected a column `" + name + "`, found " +
                           quoted_text(header));
  return header;
}

// Curves of the sources that have the column.
std::string curves(const std::vector<PlotSource>& sources, const std::vector<bool>& have,
                   const char* column) {
  // Told apart without colour too: the first is drawn thick below the others.
  static constexpr const char* kStyles[] = {"lw 2.5 lc rgb '#0060a8'", "lw 1 lc rgb '#d95f02'",
                                            "lw 1 lc rgb '#1b9e77'", "lw 1 lc rgb '#7570b3'",
                                            "lw 1 lc rgb '#666666'"};
  std::string plot = "plot ";
  const char* separator = "";
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (!have[i]) continue;
    plot += fmt::format("{}{} using 't':'{}' with lines {} title {} noenhanced", separator,
                        gnuplot_quoted(sources[i].csv), column, kStyles[i % std::size(kStyles)],
                        gnuplot_quoted(sources[i].label));
    separator = ", ";
  }
  return plot + "\n";
}

// banded: which sources know the high band's energy; the whole mesh has no such band.
std::string script(const std::vector<PlotSource>& sources, const std::vector<bool>& banded,
                   bool svg) {
  const bool two_panels = std::find(banded.begin(), banded.end(), true) != banded.end();
  std::string text = svg ? "set terminal svg size 960,640 font 'sans,14' background 'white'\n"
                         : "set terminal pngcairo size 960,640 font 'sans,11'\n";
  text +=
      "set datafile separator ','\nset key autotitle columnhead\n"
      "set key outside top right horizontal\nset grid lc rgb '#dddddd'\nset border 3\nset tics "
      "nomirror\nset yrange [0:*]\n"
      "set xlabel 'time (s)'\n";
  if (two_panels) text += "set multiplot layout 2,1\n";
  text += "set title 'total energy'\nset ylabel 'J'\n";
  text += curves(sources, std::vector<bool>(sources.size(), true), "total");
  if (!two_panels) return text;
  text += "set title 'energy of the high band'\n";
  text += curves(sources, banded, "high_band");
  return text + "unset multiplot\n";
}

}  // namespace

Status plot_energies(const std::vector<PlotSource>& sources, const std::string& output) {
  const std::string ending = fs::path(output).extension().string();
  if (ending == ".html") return write_energy_page(sources, output);
  if (ending != ".svg" && ending != ".png")
    return Error{ErrorKind::kUsage, output + ": a plot ends in .html, .svg or .png"};
  std::vector<bool> banded;
  for (const PlotSource& source : sources) {
    const Result<std::string> header = read_header(source.csv);
    if (!header) return header.error();
    banded.push_back(has_column(*header, "high_band"));
  }
  const Result<std::string> picture = run_gnuplot(script(sources, banded, ending == ".svg"));
  if (!picture) return Error{picture.error().kind, output + ": " + picture.error().message};
  return write_file(output, *picture);
}

Status plot_run(const PlotSource& source, const std::string& folder,
                std::vector<std::string>& files) {
  for (const char* name : {kEnergyPageName, kPictureName}) {
    if (name == std::string_view(kPictureName) && !has_gnuplot()) break;
    const std::string path = (fs::path(folder) / name).string();
    if (Status s = plot_energies({source}, path); !s) return s;
    files.push_back(path);
  }
  return Success{};
}

int plot_command(const std::vector<std::string>& directories, const std::string& output) {
  const std::vector<PlotSource> sources = plot_sources(directories);
  std::vector<NamedFile> inputs;
  for (const PlotSource& source : sources) inputs.push_back({source.csv, "a run"});
  if (Status status = keep_apart({output}, inputs); !status) return report_error(status.error());
  if (Status status = check_writable({output}); !status) return report_error(status.error());
  const GuardedInputs guard(inputs);
  const Status status = plot_energies(sources, output);
  return status ? 0 : report_error(status.error());
}

}  // namespace tremolo
