#include "runtime/viewer/picture/picture_series.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <unistd.h>

#include <fmt/format.h>

namespace tremolo {

namespace fs = std::filesystem;

Result<PictureSeries> PictureSeries::create(const std::string& folder, const std::string& video,
                                            double rate, int width, int height) {
  PictureSeries series;
  series.folder_ = folder;
  series.video_path_ = video;
  if (!folder.empty()) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return system_error(folder + ": cannot create: " + error.message());
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
      return system_error(folder + ": cannot write there: " + std::strerror(errno));
  }
  if (video.empty()) return series;
  Result<VideoFile> file = VideoFile::create(video, rate, width, height);
  if (!file) return file.error();
  series.video_.emplace(std::move(*file));
  return series;
}

Status PictureSeries::add(const Picture& picture) {
  if (!folder_.empty()) {
    const std::string path = (fs::path(folder_) / fmt::format("frame-{:06}.png", count_)).string();
    if (Status s = write_png(path, picture); !s) return s;
    files_.push_back(path);
  }
  ++count_;
  return video_ ? video_->add(picture) : Status(Success{});
}

Status PictureSeries::finish() {
  if (!video_) return Success{};
  if (Status s = video_->finish(); !s) return s;
  files_.push_back(video_path_);
  return Success{};
}

}  // namespace tremolo
