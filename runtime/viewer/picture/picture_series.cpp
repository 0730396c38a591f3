#include "runtime/viewer/picture/picture_series.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <unistd.h>

#include <fmt/format.h>

#include "formats/file/output_guard.h"

namespace tremolo {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPictureStart = "frame-", kPictureEnd = ".png";

}  // namespace

std::string picture_name(int number) {
  return fmt::format("{}{:06}{}", kPictureStart, number, kPictureEnd);
}

bool is_picture_name(std::string_view name) {
  if (!name.starts_with(kPictureStart) || !name.ends_with(kPictureEnd)) return false;
  const std::size_t sides = kPictureStart.size() + kPictureEnd.size();
  if (name.size() < sides + 6) return false;
  return name.substr(kPictureStart.size(), name.size() - sides).find_first_not_of("0123456789") ==
         std::string_view::npos;
}

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
    const std::string path = (fs::path(folder_) / picture_name(count_)).string();
    if (Status s = write_png(path, picture); !s) return s;
    files_.push_back(path);
  }
  ++count_;
  return video_ ? video_->add(picture) : Status(Success{});
}

Status PictureSeries::finish() {
  if (count_ == 0) {
    video_.reset();
    return Success{};
  }
  if (!folder_.empty()) {
    const std::string last = picture_name(count_ - 1);
    const auto is_behind = [&last](std::string_view name) {
      return is_picture_name(name) &&
             (name.size() > last.size() || (name.size() == last.size() && name > last));
    };
    for (const std::string& path : files_like(folder_, is_behind))
      if (is_our_png(path))
        if (Status s = remove_result(path); !s) return s;
  }
  if (!video_) return Success{};
  if (Status s = video_->finish(); !s) return s;
  files_.push_back(video_path_);
  return Success{};
}

}  // namespace tremolo
