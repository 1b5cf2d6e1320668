// Named columns: how an engine shows its state without its readers knowing any physics. A column has
// a name, a unit, an element type and rows x width elements, row by row. `ColumnView` borrows,
// `Column` owns; a `State` is a list of owned columns: all that a checkpoint has to keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace granary::core {

enum class ElementType : std::uint8_t { f32, f64, i32, i64, u32, u64, u8 };

std::size_t element_bytes(ElementType type);

template <typename T>
constexpr ElementType element_type_of() {
  if constexpr (std::is_same_v<T, float>) return ElementType::f32;
  else if constexpr (std::is_same_v<T, double>) return ElementType::f64;
  else if constexpr (std::is_same_v<T, std::int32_t>) return ElementType::i32;
  else if constexpr (std::is_same_v<T, std::int64_t>) return ElementType::i64;
  else if constexpr (std::is_same_v<T, std::uint32_t>) return ElementType::u32;
  else if constexpr (std::is_same_v<T, std::uint64_t>) return ElementType::u64;
  else {
    static_assert(std::is_same_v<T, std::uint8_t>, "no column holds this type");
    return ElementType::u8;
  }
}

struct Column {
  std::string name;
  std::string unit;  // SI, "1" for pure numbers
  ElementType type = ElementType::f64;
  std::size_t rows = 0;
  std::size_t width = 1;  // 2 for plane vectors, 3 for space vectors
  std::vector<std::byte> bytes;

  // Precondition: T matches `type`.
  template <typename T>
  std::span<const T> as() const {
    if (element_type_of<T>() != type) throw std::logic_error("column " + name + ": other type");
    return {reinterpret_cast<const T*>(bytes.data()), rows * width};
  }
};

struct ColumnView {
  std::string_view name;
  std::string_view unit;
  ElementType type = ElementType::f64;
  std::size_t rows = 0;
  std::size_t width = 1;
  const void* data = nullptr;

  std::size_t size_bytes() const { return rows * width * element_bytes(type); }
};

// Precondition: values.size() is a multiple of width.
template <typename T>
Column make_column(std::string name, std::string unit, std::span<const T> values,
                   std::size_t width = 1) {
  Column column{std::move(name), std::move(unit), element_type_of<T>(), values.size() / width, width,
                {}};
  column.bytes.resize(values.size_bytes());
  if (!values.empty()) std::memcpy(column.bytes.data(), values.data(), values.size_bytes());
  return column;
}

ColumnView view_of(const Column& column);

// Everything an engine needs to go on bitwise as if it had not been stopped.
struct State {
  std::vector<Column> columns;

  void put(Column column) { columns.push_back(std::move(column)); }
  template <typename T>
  void put(std::string name, std::string unit, const std::vector<T>& values, std::size_t width = 1) {
    columns.push_back(make_column<T>(std::move(name), std::move(unit), std::span<const T>(values), width));
  }
  template <typename T>
  void put_scalar(std::string name, std::string unit, T value) {
    columns.push_back(make_column<T>(std::move(name), std::move(unit), std::span<const T>(&value, 1)));
  }
  const Column* find(std::string_view name) const;
  // Throws std::runtime_error naming the column when it is missing or of another type or length.
  template <typename T>
  std::vector<T> get(std::string_view name) const {
    const Column& column = require(name);
    auto values = column.as<T>();
    return {values.begin(), values.end()};
  }
  template <typename T>
  T get_scalar(std::string_view name) const {
    auto values = get<T>(name);
    if (values.size() != 1) throw std::runtime_error("state: " + std::string(name) + " is no scalar");
    return values[0];
  }

 private:
  const Column& require(std::string_view name) const;
};

// 128-bit hash (XXH3) over names, shapes and bytes, as 32 hex digits: `state_hash` of a result.
std::string hash_columns(std::span<const ColumnView> columns);

}  // namespace granary::core
