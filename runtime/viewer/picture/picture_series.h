// Writes pictures to a folder of PNGs, to a film, or to both.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/viewer/picture/png_file.h"
#include "runtime/viewer/picture/video_file.h"

namespace tremolo {

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
