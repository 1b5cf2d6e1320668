#include "proto/contract/stl.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>

#include "proto/contract/rule_text.h"

namespace granary {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

constexpr std::size_t kHeaderBytes = 84;  // 80 of text, then the number of triangles
constexpr std::size_t kTriangleBytes = 50;
constexpr std::size_t kNormalBytes = 12;
// Twice the area / the longest edge squared; corners are floats, good to 1e-7 of themselves.
constexpr double kThinnest = 1e-9;

// Of a file: no field is to blame here.
Error refuse_file(std::string_view what, const std::string& why) {
  return {ErrorCode::invalid_argument, std::string(what) + ": " + why, ""};
}

std::string too_many(std::size_t count) {
  return "has " + std::to_string(count) + " triangles, must be 1 to " +
         std::to_string(kMaxTriangles);
}

// Where: "triangle 3" counts from 1.
std::optional<Error> check_triangle(const TriangleCorners& corners, std::string_view what,
                                    const std::string& where) {
  for (const double value : corners) {
    if (std::isfinite(value)) continue;
    return refuse_file(what,
                       where + " has a corner at " + number(value) + ", must be a finite number");
  }
  if (!has_area(corners))
    return refuse_file(what, where + " has no area: its corners lie on one line");
  return {};
}

// ---------------------------------------------------------------------------------------- binary

std::uint32_t promised_triangles(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes - sizeof count, sizeof count);
  return count;
}

std::size_t promised_bytes(std::string_view bytes) {
  return kHeaderBytes + kTriangleBytes * std::size_t{promised_triangles(bytes)};
}

Result<std::vector<TriangleCorners>> parse_binary(std::string_view bytes, std::string_view what) {
  const std::uint32_t count = promised_triangles(bytes);
  if (count == 0 || count > kMaxTriangles) return refuse_file(what, too_many(count));
  if (promised_bytes(bytes) != bytes.size())
    return refuse_file(what, "has " + std::to_string(bytes.size()) + " bytes, " +
                                 std::to_string(count) + " triangles need " +
                                 std::to_string(promised_bytes(bytes)));
  std::vector<TriangleCorners> triangles(count);
  for (std::size_t k = 0; k < count; ++k) {
    float corners[9];
    std::memcpy(corners, bytes.data() + kHeaderBytes + k * kTriangleBytes + kNormalBytes,
                sizeof corners);
    std::copy(std::begin(corners), std::end(corners), triangles[k].begin());
    if (auto error = check_triangle(triangles[k], what, "triangle " + std::to_string(k + 1)))
      return *error;
  }
  return triangles;
}

// ----------------------------------------------------------------------------------------- ASCII

bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\t' || c == '\r';
}

class AsciiReader {
 public:
  AsciiReader(std::string_view text, std::string_view what) : text_(text), what_(what) {}

  Result<std::vector<TriangleCorners>> read() {
    while (!rest_is_empty()) {
      if (auto error = read_solid()) return *error;
    }
    if (triangles_.empty()) return refuse_file(what_, too_many(0));
    return std::move(triangles_);
  }

 private:
  std::string where() const { return "line " + std::to_string(line_); }

  bool rest_is_empty() {
    while (at_ < text_.size() && is_space(text_[at_])) line_ += text_[at_++] == '\n' ? 1 : 0;
    return at_ == text_.size();
  }

  // The next word in lower case, empty at the end.
  std::string word() {
    if (rest_is_empty()) return {};
    std::string found;
    while (at_ < text_.size() && !is_space(text_[at_])) {
      const char c = text_[at_++];
      found += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
    return found;
  }

  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }

  std::optional<Error> unexpected(const std::string& found, const std::string& wanted) const {
    std::string shown = found.substr(0, 40);
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return refuse_file(what_, where() +
                                  (found.empty() ? " ends the file" : " has '" + shown + "'") +
                                  " where '" + wanted + "' belongs");
  }

  std::optional<Error> expect(const char* wanted) {
    const std::string found = word();
    return found == wanted ? std::nullopt : unexpected(found, wanted);
  }

  std::optional<Error> read_number(double& value) {
    const std::string found = word();
    const char* begin = found.data() + (found.starts_with('+') ? 1 : 0);
    const char* end = found.data() + found.size();
    const auto [stop, status] = std::from_chars(begin, end, value);
    if (found.empty() || stop != end || status != std::errc()) return unexpected(found, "a number");
    return {};
  }

  std::optional<Error> read_solid() {
    if (auto error = expect("solid")) return error;
    skip_line();  // its name
    for (;;) {
      const std::string found = word();
      if (found == "endsolid") break;
      if (found != "facet") return unexpected(found, "facet or endsolid");
      if (auto error = read_facet()) return error;
    }
    skip_line();
    return {};
  }

  std::optional<Error> read_facet() {
    const std::string begun = "the triangle of " + where();
    double unused = 0;
    if (auto error = expect("normal")) return error;
    for (int k = 0; k < 3; ++k)
      if (auto error = read_number(unused)) return error;
    if (auto error = expect("outer")) return error;
    if (auto error = expect("loop")) return error;
    TriangleCorners corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      if (k % 3 == 0)
        if (auto error = expect("vertex")) return error;
      if (auto error = read_number(corners[k])) return error;
    }
    if (auto error = expect("endloop")) return error;
    if (auto error = expect("endfacet")) return error;
    if (auto error = check_triangle(corners, what_, begun)) return error;
    if (triangles_.size() == kMaxTriangles)
      return refuse_file(what_, "has more than " + std::to_string(kMaxTriangles) + " triangles");
    triangles_.push_back(corners);
    return {};
  }

  std::string_view text_;
  std::string_view what_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::vector<TriangleCorners> triangles_;
};

}  // namespace

bool has_area(const TriangleCorners& c) {
  const auto edge = [&](std::size_t to, std::size_t from) {
    return std::array{c[to] - c[from], c[to + 1] - c[from + 1], c[to + 2] - c[from + 2]};
  };
  const auto ab = edge(3, 0), ac = edge(6, 0), bc = edge(6, 3);
  const double twice_area = std::hypot(ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                                       ab[0] * ac[1] - ab[1] * ac[0]);
  const double longest = std::max({std::hypot(ab[0], ab[1], ab[2]), std::hypot(ac[0], ac[1], ac[2]),
                                   std::hypot(bc[0], bc[1], bc[2])});
  return twice_area > kThinnest * longest * longest;
}

Result<std::vector<TriangleCorners>> parse_stl(std::string_view bytes, std::string_view what) {
  if (bytes.size() > kMaxStlBytes)
    return refuse_file(what,
                       "is larger than the " + std::to_string(kMaxStlBytes) + " bytes allowed");
  const bool fits = bytes.size() >= kHeaderBytes && promised_bytes(bytes) == bytes.size();
  const std::size_t first = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
  if (!fits && bytes.substr(first, 5) == "solid") return AsciiReader(bytes, what).read();
  if (bytes.size() < kHeaderBytes)
    return refuse_file(what, "has " + std::to_string(bytes.size()) +
                                 " bytes and does not begin with 'solid': no STL file");
  return parse_binary(bytes, what);
}

}  // namespace granary
