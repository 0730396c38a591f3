#include "precompute/options/config_option.h"

#include <filesystem>

#include "formats/file/input_file.h"
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

}  // namespace

void add_config_option(CLI::App& app, const std::string& description) {
  app.set_config("--config", "", description)->check(require_regular, "FILE");
}

std::string config_path(const CLI::App& app) {
  const CLI::Option* option = app.get_config_ptr();
  return option->count() > 0 ? option->as<std::string>() : std::string();
}

}  // namespace tremolo
