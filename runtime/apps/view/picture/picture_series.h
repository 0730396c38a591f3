// Writes pictures to a folder of PNGs, to a film, or to both.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <vector>

#include "common/result.h"
#include "formats/file/atomic_file.h"
#include "runtime/apps/view/picture/png_file.h"

namespace tremolo {

// Pictures -> a film, by the program ffmpeg. A film during writing. Its temporary file, next to the
// target, is renamed when finish() succeeds, and else removed with the object. Pictures have an
// even width and height.
class VideoFile {
 public:
  // path: *.mp4 (H.264) or *.webm (VP9). rate: pictures a second. Errors: kUsage for another
  // ending; kContent for an odd width or height; kSystem where ffmpeg is not installed or cannot be
  // started.
  static Result<VideoFile> create(const std::string& path, double rate, int width, int height);

  VideoFile(VideoFile&& other) noexcept;
  VideoFile& operator=(VideoFile&&) = delete;
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;
  ~VideoFile();

  // Errors: kSystem when ffmpeg does not take it.
  Status add(const Picture& picture);
  // Waits for ffmpeg. Errors: kSystem if it failed; its messages are on stderr.
  Status finish();

 private:
  VideoFile() = default;
  int end_encoder();

  std::string path_, temporary_;
  PartialOfChild partial_;
  int width_ = 0, height_ = 0;
  int pipe_ = -1;
  pid_t encoder_ = -1;
};

// "frame-000012.png", and the test of such a name.
std::string picture_name(int number);
bool is_picture_name(std::string_view name);

class PictureSeries {
 public:
  // folder: created if need be; empty: none. video: as for VideoFile; empty: none. Errors: kSystem
  // if a folder cannot be created or written to; those of VideoFile.
  static Result<PictureSeries> create(const std::string& folder, const std::string& video,
                                      double rate, int width, int height);

  // frame-000000.png, frame-000001.png ... Errors: those of write_png and VideoFile::add.
  Status add(const Picture& picture);
  // Ends the film; without pictures there is none. Removes pictures of a longer series that this
  // program wrote into the folder before.
  Status finish();
  // Files of pictures, in order; of a film at the end.
  const std::vector<std::string>& files() const { return files_; }

 private:
  PictureSeries() = default;
  std::string folder_, video_path_;
  std::optional<VideoFile> video_;
  std::vector<std::string> files_;
  int count_ = 0;
};

}  // namespace tremolo
