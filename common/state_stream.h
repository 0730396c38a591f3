// Saves values as bytes and restores them, with one function for both: carry(stream) lists the
// values, and a stream that writes appends them, one that reads restores them, bit for bit. The
// bytes are untrusted: sizes must match, and after an error a stream reads nothing more.
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremolo {

static_assert(std::endian::native == std::endian::little, "values are written as they lie");

class StateStream {
 public:
  // Appends to `bytes`, which must outlive the stream.
  static StateStream writing(std::string& bytes) { return StateStream(&bytes, {}); }
  // The bytes must outlive the stream.
  static StateStream reading(std::span<const std::byte> bytes) {
    return StateStream(nullptr, bytes);
  }

  bool reads() const { return written_ == nullptr; }
  // False after a value did not fit; values are then left as they are.
  bool good() const { return good_; }
  // Reports that the bytes read are not a valid state. Does nothing to a stream that writes.
  void spoil() { good_ = good_ && !reads(); }
  void require(bool condition) {
    if (!condition) spoil();
  }
  std::size_t left() const { return read_.size(); }  // bytes to be read

  // Each value: a number, a bool, an enumeration, a vector or matrix, a quaternion, a std::vector
  // or std::optional of these, or a type with carry(stream) or carry(stream, value). Sizes are
  // fixed: values of other sizes are not read.
  template <class... Values>
  void operator()(Values&... values) {
    (one(values), ...);
  }

  // The same, but the list or matrix gets the size that was written.
  template <class Value>
  void sized(std::vector<Value>& list) {
    const std::size_t count = size_of(list.size());
    // Every element takes a byte at least.
    require(count <= left());
    if (reads() && good_) list.resize(count);
    for (std::size_t i = 0; good_ && i < list.size(); ++i) one(list[i]);
  }
  template <class Scalar, int kRows, int kColumns>
  void sized(Eigen::Matrix<Scalar, kRows, kColumns>& matrix) {
    const Eigen::Index rows = size_of(static_cast<std::size_t>(matrix.rows()));
    const auto columns =
        static_cast<Eigen::Index>(size_of(static_cast<std::size_t>(matrix.cols())));
    const Eigen::Index most = left() / sizeof(Scalar);
    require((kRows == Eigen::Dynamic || rows == kRows) &&
            (kColumns == Eigen::Dynamic || columns == kColumns) && rows >= 0 && columns >= 0 &&
            rows <= most && (rows == 0 || columns <= most / rows));
    if (reads() && good_) matrix.resize(rows, columns);
    raw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(Scalar));
  }
  void sized(std::string& text) {
    const std::size_t count = size_of(text.size());
    require(count <= left());
    if (reads() && good_) text.resize(count);
    raw(text.data(), text.size());
  }

 private:
  StateStream(std::string* written, std::span<const std::byte> read)
      : written_(written), read_(read) {}

  void raw(void* data, std::size_t count) {
    if (!good_ || count == 0) return;
    if (!reads()) {
      written_->append(static_cast<const char*>(data), count);
      return;
    }
    if (count > read_.size()) return spoil();
    std::memcpy(data, read_.data(), count);
    read_ = read_.subspan(count);
  }

  std::size_t size_of(std::size_t present) {
    std::uint64_t count = present;
    raw(&count, sizeof(count));
    return count;
  }

  template <class Value>
  requires std::is_arithmetic_v<Value> || std::is_enum_v<Value>
  void one(Value& value) {
    if constexpr (std::same_as<Value, bool>) {
      auto byte = static_cast<std::uint8_t>(value);
      raw(&byte, 1);
      require(byte <= 1);
      if (good_) value = byte == 1;
    } else {
      raw(&value, sizeof(value));
    }
  }
  template <class Scalar, int kRows, int kColumns, int kOptions, int kMostRows, int kMostColumns>
  void one(Eigen::Matrix<Scalar, kRows, kColumns, kOptions, kMostRows, kMostColumns>& matrix) {
    if constexpr (kRows == Eigen::Dynamic || kColumns == Eigen::Dynamic) {
      const std::size_t rows = size_of(static_cast<std::size_t>(matrix.rows()));
      const std::size_t columns = size_of(static_cast<std::size_t>(matrix.cols()));
      require(rows == static_cast<std::size_t>(matrix.rows()) &&
              columns == static_cast<std::size_t>(matrix.cols()));
    }
    raw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(Scalar));
  }
  template <class Scalar>
  void one(Eigen::Quaternion<Scalar>& quaternion) {
    one(quaternion.coeffs());
  }
  template <class Value, class Allocator>
  void one(std::vector<Value, Allocator>& list) {
    require(size_of(list.size()) == list.size());
    if constexpr (std::is_floating_point_v<Value>) {
      raw(list.data(), list.size() * sizeof(Value));
    } else {
      for (std::size_t i = 0; good_ && i < list.size(); ++i) one(list[i]);
    }
  }
  template <class Value>
  void one(std::optional<Value>& value) {
    bool present = value.has_value();
    one(present);
    if (reads() && good_) {
      if (present && !value) value.emplace();
      if (!present) value.reset();
    }
    if (value) one(*value);
  }
  template <class Value>
  requires requires(Value& value, StateStream& stream) { value.carry(stream); }
  void one(Value& value) { value.carry(*this); }
  template <class Value>
  requires requires(Value& value, StateStream& stream) { carry(stream, value); }
  void one(Value& value) { carry(*this, value); }

  std::string* written_;
  std::span<const std::byte> read_;
  bool good_ = true;
};

// The state of `thing`, which this does not change.
template <class Thing>
std::string state_bytes(const Thing& thing) {
  std::string bytes;
  StateStream stream = StateStream::writing(bytes);
  // One function saves and restores; a stream that writes changes nothing.
  const_cast<Thing&>(thing).carry(stream);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
  return bytes;
}

// False, and `thing` is as it was, if the bytes are not a state of it.
template <class Thing>
bool restore_state(Thing& thing, std::string_view bytes) {
  const std::string before = state_bytes(thing);
  const auto read = [&thing](std::string_view from) {
    StateStream stream = StateStream::reading(std::as_bytes(std::span(from.data(), from.size())));
    thing.carry(stream);
    return stream.good() && stream.left() == 0;
  };
  if (read(bytes)) return true;
  (void)read(before);
  return false;
}

}  // namespace tremolo
