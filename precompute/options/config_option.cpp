#include "precompute/options/config_option.h"

#include <filesystem>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "formats/file/input_file.h"
#include "formats/file/scanner.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::string require_regular(const std::string& path) {
  std::error_code ignored;
  // CLI11 reports a missing file, as it opens the file next.
  if (!std::filesystem::exists(path, ignored)) return {};
  const Result<struct stat> status = examine_input(path);
  if (!status) throw Failure(status.error());
  return {};
}

// CLI11's reader, which takes a byte-order mark for a part of the first key.
class MarkedConfig : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    std::string text(std::istreambuf_iterator<char>(input), {});
    std::istringstream unmarked(std::string(without_mark(text)));
    return CLI::ConfigTOML::from_config(unmarked);
  }
};

}  // namespace

void add_config_option(CLI::App& app, const std::string& description) {
  app.config_formatter(std::make_shared<MarkedConfig>());
  app.set_config("--config", "", description)->check(require_regular, "FILE");
}

std::string config_path(const CLI::App& app) {
  const CLI::Option* option = app.get_config_ptr();
  return option->count() > 0 ? option->as<std::string>() : std::string();
}

}  // namespace tremolo
