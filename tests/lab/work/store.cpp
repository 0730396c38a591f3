#include "tests/lab/work/store.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "tests/lab/work/failure.h"

namespace tremolo {
namespace {

using Json = nlohmann::json;

// Invalid UTF-8 in a name must not end the program; numbers that are not finite become null.
std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<Json> read_stored(const std::string& path, const std::string& key) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return std::nullopt;
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("key") || !json.contains("result")) return std::nullopt;
  if (line_of(json["key"]) != key) return std::nullopt;
  if (json.value("checksum", Json()) != checksum(key + "\n" + line_of(json["result"])))
    return std::nullopt;
  return json["result"];
}

bool is_name(const std::string& name) {
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '+' || c == '.';
  });
}

}  // namespace

double to_number(const Json& value, double otherwise) {
  return value.is_number() ? value.get<double>() : otherwise;
}

Result<Store> Store::open(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return system_error(directory + ": cannot create: " + error.message());
  Store store;
  store.directory_ = directory;
  return store;
}

Json Store::get(const std::string& name, const Json& key, const std::function<Json()>& work) const {
  if (!is_name(name)) throw Failure({ErrorKind::kUsage, "no name for a stored result: " + name});
  const std::string path = (std::filesystem::path(directory_) / (name + ".json")).string();
  const std::string key_text = line_of(key);
  if (std::optional<Json> stored = read_stored(path, key_text)) return std::move(*stored);
  const std::string result = line_of(work());
  or_fail(write_file(path, "{\"checksum\":\"" + checksum(key_text + "\n" + result) +
                               "\",\n\"key\":" + key_text + ",\n\"result\":" + result + "}\n"));
  // Parsed from the text, so that a first start and a later one give the same.
  return Json::parse(result);
}

}  // namespace tremolo
