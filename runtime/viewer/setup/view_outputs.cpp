#include "runtime/viewer/setup/view_outputs.h"

#include <filesystem>
#include <string>
#include <utility>

#include "runtime/viewer/picture/picture_series.h"

namespace tremolo {

std::vector<NamedFile> inputs_of_view(const ViewerOptions& options,
                                      std::vector<NamedFile> of_scene) {
  std::vector<NamedFile> inputs = std::move(of_scene);
  for (const std::string& text : options.textures)
    inputs.push_back({text.substr(text.find('=') + 1), "--texture"});
  return inputs;
}

Status check_view_outputs(const ViewerOptions& options, const std::vector<NamedFile>& inputs) {
  if (options.offscreen && !options.record_hand.empty())
    return usage_error("--record-hand applies only to a window, not to --offscreen");
  std::vector<std::string> outputs = {options.video, options.record_hand};
  if (!options.out.empty())
    for (std::string& path : files_like(options.out, is_picture_name))
      outputs.push_back(std::move(path));
  if (Status s = keep_apart(outputs, inputs); !s) return s;
  if (Status s = check_writable({options.video, options.record_hand}); !s) return s;
  if (options.out.empty()) return Success{};
  return check_writable({(std::filesystem::path(options.out) / picture_name(0)).string()}, true);
}

}  // namespace tremolo
