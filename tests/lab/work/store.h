// Results that survive an interruption: one small file for each piece of work, so that a second
// start skips finished pieces.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "common/result.h"

namespace tremolo {

// A number that was stored; `otherwise` for null, which is stored for one that is not finite.
double to_number(const nlohmann::json& value,
                 double otherwise = std::numeric_limits<double>::quiet_NaN());

class Store {
 public:
  // directory: made if missing. Errors: kSystem.
  static Result<Store> open(const std::string& directory);

  // The result of the piece of work `name` (letters, digits, '-', '+', '.'), made by `work` unless
  // a file from an earlier start has it under the same key. key: everything the result depends on
  // (model checksum, options, version of the computation). A file that is damaged or has another
  // key is made again. Numbers that are not finite return as null. Threads may call at once for
  // different names. Throws what `work` throws, and a Failure: kSystem for an unwritable file,
  // kUsage for a name with other letters.
  nlohmann::json get(const std::string& name, const nlohmann::json& key,
                     const std::function<nlohmann::json()>& work) const;

  // The same for a struct whose members are listed by `fields(archive, value)`, found by its
  // argument: archive("name", value.member, ...) with a name before each. Members that `fields`
  // leaves out keep their defaults, also in the first start.
  template <class T>
  T get_as(const std::string& name, const nlohmann::json& key,
           const std::function<T()>& work) const;

 private:
  std::string directory_;
};

// The two archives of `fields`. Members may be numbers, texts, vectors of numbers, an optional
// double, or structs with their own `fields`. A double that is not finite is read back as
// not-a-number, an optional as empty.
struct FieldWriter {
  nlohmann::json json = nlohmann::json::object();

  template <class V>
  void operator()(const char* name, V& value) {
    if constexpr (requires(FieldWriter & inner) { fields(inner, value); }) {
      FieldWriter inner;
      fields(inner, value);
      json[name] = std::move(inner.json);
    } else {
      json[name] = value;
    }
  }
  void operator()(const char* name, std::optional<double>& value) {
    json[name] = value ? nlohmann::json(*value) : nlohmann::json();
  }
  void operator()(const char* name, Eigen::VectorXd& value) {
    json[name] = std::vector<double>(value.begin(), value.end());
  }
  template <class V, class... Rest>
  requires(sizeof...(Rest) > 1) void operator()(const char* name, V& value, Rest&... rest) {
    (*this)(name, value);
    (*this)(rest...);
  }
};

struct FieldReader {
  const nlohmann::json& json;

  template <class V>
  void operator()(const char* name, V& value) const {
    if constexpr (requires(FieldReader & inner) { fields(inner, value); }) {
      FieldReader inner{json.at(name)};
      fields(inner, value);
    } else {
      json.at(name).get_to(value);
    }
  }
  void operator()(const char* name, double& value) const { value = number(json.at(name)); }
  void operator()(const char* name, std::optional<double>& value) const {
    value = json.at(name).is_null() ? std::optional<double>() : number(json.at(name));
  }
  void operator()(const char* name, std::vector<double>& value) const {
    value.clear();
    for (const nlohmann::json& one : json.at(name)) value.push_back(number(one));
  }
  void operator()(const char* name, Eigen::VectorXd& value) const {
    std::vector<double> numbers;
    (*this)(name, numbers);
    value = Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
  }
  template <class V, class... Rest>
  requires(sizeof...(Rest) > 1) void operator()(const char* name, V& value, Rest&... rest) const {
    (*this)(name, value);
    (*this)(rest...);
  }

 private:
  static double number(const nlohmann::json& value) {
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  }
};

template <class T>
nlohmann::json fields_to_json(T value) {
  FieldWriter writer;
  fields(writer, value);
  return std::move(writer.json);
}

// Throws nlohmann::json::exception where a member is missing or of another type.
template <class T>
T fields_from_json(const nlohmann::json& json) {
  T value;
  FieldReader reader{json};
  fields(reader, value);
  return value;
}

template <class T>
T Store::get_as(const std::string& name, const nlohmann::json& key,
                const std::function<T()>& work) const {
  return fields_from_json<T>(get(name, key, [&] { return fields_to_json(work()); }));
}

}  // namespace tremolo
