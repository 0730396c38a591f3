// Pictures -> a film, by the program ffmpeg.
#pragma once

#include <cstdio>
#include <string>
#include <sys/types.h>

#include "common/result.h"
#include "formats/file/atomic_file.h"
#include "runtime/viewer/picture/png_file.h"

namespace tremolo {

// A film during writing. Its temporary file, next to the target, is renamed when finish() succeeds,
// and else removed with the object. Pictures have an even width and height.
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

}  // namespace tremolo
