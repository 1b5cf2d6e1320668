#include "server/store/scene_field_function.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>
#include <sqlite3.h>

#include <bit>
#include <charconv>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "granary/v1/scene.pb.h"

namespace granary::server {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

struct Step {
  const FieldDescriptor* field;
  int index;  // of a repeated field; 0 otherwise
};
using Path = std::vector<Step>;

// "chute.particles[0].diameter_m"; empty when there is no such field.
Path find_path(std::string_view text) {
  Path path;
  const Descriptor* type = v1::Scene::descriptor();
  while (!text.empty() && type != nullptr) {
    const std::size_t end = std::min(text.find('.'), text.size());
    std::string_view part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    int index = 0;
    if (const auto open = part.find('['); open != std::string_view::npos) {
      std::from_chars(part.data() + open + 1, part.data() + part.size(), index);
      part = part.substr(0, open);
    }
    const FieldDescriptor* field = type->FindFieldByName(std::string(part));
    if (field == nullptr) return {};
    path.push_back({field, index});
    type = field->message_type();
  }
  return type == nullptr ? path : Path{};
}

struct Found {
  enum class Kind { nothing, integer, real, text } kind = Kind::nothing;
  std::int64_t integer = 0;
  double real = 0;
  std::string text;
};

bool read_scalar(CodedInputStream& in, const FieldDescriptor& field, Found& found) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    std::uint64_t bits = 0;
    if (!in.ReadLittleEndian64(&bits)) return false;
    found.kind = Found::Kind::real;
    found.real = std::bit_cast<double>(bits);
    return true;
  }
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
    std::uint32_t size = 0;
    found.kind = Found::Kind::text;
    return in.ReadVarint32(&size) && in.ReadString(&found.text, static_cast<int>(size));
  }
  std::uint64_t value = 0;
  if (!in.ReadVarint64(&value)) return false;
  found.kind = Found::Kind::integer;
  found.integer = static_cast<std::int64_t>(value);
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_ENUM) return true;
  const auto* name = field.enum_type()->FindValueByNumber(static_cast<int>(value));
  found.kind = Found::Kind::text;
  found.text = name ? name->name() : std::to_string(value);
  return true;
}

// The last occurrence of a singular field wins, as in protobuf's own parser.
bool walk(CodedInputStream& in, const Path& path, std::size_t depth, Found& found) {
  const Step& step = path[depth];
  int seen = 0;
  while (const std::uint32_t tag = in.ReadTag()) {
    if (WireFormatLite::GetTagFieldNumber(tag) != step.field->number() ||
        (step.field->is_repeated() && seen++ != step.index)) {
      if (!WireFormatLite::SkipField(&in, tag)) return false;
      continue;
    }
    if (depth + 1 == path.size()) {
      if (!read_scalar(in, *step.field, found)) return false;
      continue;
    }
    std::uint32_t size = 0;
    if (!in.ReadVarint32(&size)) return false;
    const auto limit = in.PushLimit(static_cast<int>(size));
    if (!walk(in, path, depth + 1, found)) return false;
    in.PopLimit(limit);
  }
  return true;
}

void scene_field(sqlite3_context* context, int, sqlite3_value** arguments) {
  auto* path = static_cast<Path*>(sqlite3_get_auxdata(context, 1));
  std::unique_ptr<Path> made;
  if (path == nullptr) {
    const auto* text = reinterpret_cast<const char*>(sqlite3_value_text(arguments[1]));
    made = std::make_unique<Path>(find_path(text ? text : ""));
    path = made.get();
  }
  Found found;
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_value_blob(arguments[0]));
  const int size = sqlite3_value_bytes(arguments[0]);
  if (!path->empty() && bytes != nullptr) {
    CodedInputStream in(bytes, size);
    if (!walk(in, *path, 0, found)) found.kind = Found::Kind::nothing;
  }
  if (found.kind == Found::Kind::real) sqlite3_result_double(context, found.real);
  if (found.kind == Found::Kind::integer) sqlite3_result_int64(context, found.integer);
  if (found.kind == Found::Kind::text)
    sqlite3_result_text(context, found.text.data(), static_cast<int>(found.text.size()),
                        SQLITE_TRANSIENT);
  if (made)
    sqlite3_set_auxdata(context, 1, made.release(), [](void* p) { delete static_cast<Path*>(p); });
}

}  // namespace

void add_scene_field_function(sqlite3* connection) {
  if (sqlite3_create_function(connection, "scene_field", 2,
                              SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS, nullptr,
                              scene_field, nullptr, nullptr) != SQLITE_OK)
    throw std::runtime_error(sqlite3_errmsg(connection));
}

}  // namespace granary::server
