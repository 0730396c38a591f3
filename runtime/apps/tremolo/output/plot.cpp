#include "runtime/apps/tremolo/output/plot.h"

#include <filesystem>

#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/output/tell.h"

namespace tremolo {
Status plot_run(const PlotSource& source, const std::string& folder,
                std::vector<std::string>& files) {
  const std::string path = (std::filesystem::path(folder) / kEnergyPageName).string();
  if (Status s = write_energy_page({source}, path); !s) return s;
  files.push_back(path);
  return Success{};
}

int plot_command(const std::vector<std::string>& directories, const std::string& output) {
  if (std::filesystem::path(output).extension() != ".html")
    return report_error({ErrorKind::kUsage, output + ": energies are drawn on a page, .html; a "
                                                     "browser saves pictures of it"});
  const std::vector<PlotSource> sources = plot_sources(directories);
  std::vector<NamedFile> inputs;
  for (const PlotSource& source : sources) inputs.push_back({source.csv, "a run"});
  if (Status status = keep_apart({output}, inputs); !status) return report_error(status.error());
  if (Status status = check_writable({output}); !status) return report_error(status.error());
  const GuardedInputs guard(inputs);
  const Status status = write_energy_page(sources, output);
  return status ? 0 : report_error(status.error());
}

}  // namespace tremolo
