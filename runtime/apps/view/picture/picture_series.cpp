#include "runtime/apps/view/picture/picture_series.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "formats/file/output_guard.h"

extern char** environ;

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// Encoder options for a film that browsers play, by file extension.
std::vector<std::string> codec_of(const std::string& ending) {
  if (ending == ".mp4")
    return {"-c:v", "libx264", "-crf", "18", "-preset", "medium", "-movflags", "+faststart"};
  if (ending == ".webm") return {"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"};
  return {};
}

// Starts the command with `input` as standard input; returns 0 or an errno.
int start_encoder(std::vector<std::string> words, int input, pid_t& child) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  // It has its own process group: Ctrl-C on the terminal is for this program, which then ends the
  // film.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  const int result =
      posix_spawnp(&child, arguments.front(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return result;
}

}  // namespace

Result<VideoFile> VideoFile::create(const std::string& path, double rate, int width, int height) {
  const std::string ending = fs::path(path).extension().string();
  const std::vector<std::string> codec = codec_of(ending);
  if (codec.empty()) return usage_error(path + ": a film is .mp4 or .webm");
  if (width % 2 != 0 || height % 2 != 0)
    return content_error(
        fmt::format("{}: a film has an even width and height, not {}x{}", path, width, height));
  if (const Status kept = check_replaceable(path); !kept) return kept.error();
  VideoFile video;
  video.path_ = path;
  video.width_ = width;
  video.height_ = height;
  video.temporary_ = fmt::format("{}.partial-{}{}", path, ::getpid(), ending);
  // Checks that the file can be written before anything is rendered.
  const int trial =
      ::open(video.temporary_.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_CLOEXEC, 0666);
  if (trial < 0) return system_error(path + ": cannot create: " + std::strerror(errno));
  ::close(trial);
  video.partial_ = PartialOfChild(video.temporary_);
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    return system_error(std::string("no pipe to ffmpeg: ") + std::strerror(errno));
  std::vector<std::string> words = {"ffmpeg",
                                    "-hide_banner",
                                    "-loglevel",
                                    "error",
                                    "-y",
                                    "-f",
                                    "rawvideo",
                                    "-pix_fmt",
                                    "rgb24",
                                    "-s",
                                    fmt::format("{}x{}", width, height),
                                    "-r",
                                    fmt::format("{:.6g}", rate),
                                    "-i",
                                    "-"};
  words.insert(words.end(), codec.begin(), codec.end());
  for (const char* word : {"-pix_fmt", "yuv420p"}) words.emplace_back(word);
  words.push_back(video.temporary_);
  const int failed = start_encoder(words, ends[0], video.encoder_);
  ::close(ends[0]);
  video.pipe_ = ends[1];
  if (failed == 0) return video;
  video.encoder_ = -1;
  return system_error(failed == ENOENT
                          ? path +
                                ": films are made by ffmpeg, which is not installed: apt-get "
                                "install ffmpeg, or write pictures with --out"
                          : path + ": ffmpeg cannot be started: " + std::strerror(failed));
}

VideoFile::VideoFile(VideoFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      partial_(std::move(other.partial_)),
      width_(other.width_),
      height_(other.height_),
      pipe_(std::exchange(other.pipe_, -1)),
      encoder_(std::exchange(other.encoder_, -1)) {}

VideoFile::~VideoFile() {
  if (encoder_ > 0) {
    ::kill(encoder_, SIGTERM);
    end_encoder();
  }
  if (pipe_ >= 0) ::close(pipe_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

// Its exit code; -1 after a signal.
int VideoFile::end_encoder() {
  if (pipe_ >= 0) ::close(std::exchange(pipe_, -1));
  int status = 0;
  const pid_t child = std::exchange(encoder_, -1);
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

Status VideoFile::add(const Picture& picture) {
  if (picture.width != width_ || picture.height != height_)
    return system_error(path_ + ": a picture of another size came");
  // If ffmpeg has ended, writing to its pipe must not end this process.
  struct sigaction ignore {
  }, before{};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGPIPE, &ignore, &before);
  std::size_t done = 0;
  int error = 0;
  while (done < picture.pixels.size() && error == 0) {
    const ssize_t count =
        ::write(pipe_, picture.pixels.data() + done, picture.pixels.size() - done);
    if (count > 0)
      done += static_cast<std::size_t>(count);
    else if (errno != EINTR)
      error = errno;
  }
  ::sigaction(SIGPIPE, &before, nullptr);
  if (error != 0) return system_error(path_ + ": ffmpeg takes no more: " + std::strerror(error));
  return Success{};
}

Status VideoFile::finish() {
  const int code = end_encoder();
  if (code != 0)
    return system_error(fmt::format("{}: ffmpeg failed ({})", path_,
                                    code < 0 ? "a signal" : fmt::format("exit code {}", code)));
  if (const Status kept = check_replaceable(path_); !kept) return kept;
  if (::rename(temporary_.c_str(), path_.c_str()) != 0)
    return system_error(path_ + ": cannot rename the finished film: " + std::strerror(errno));
  temporary_.clear();
  return Success{};
}

}  // namespace tremolo

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
