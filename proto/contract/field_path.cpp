#include "proto/contract/field_path.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

namespace granary {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string upper(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return std::toupper(c); });
  return out;
}

Error invalid(std::string_view path, const std::string& what) {
  return {ErrorCode::invalid_argument, std::string(path) + ": " + what, std::string(path)};
}

struct Segment {
  std::string name;
  int index = -1;  // -1 = none given
};

Result<std::vector<Segment>> split(std::string_view path) {
  std::vector<Segment> segments;
  std::size_t begin = 0;
  while (begin <= path.size()) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    std::string_view part = path.substr(begin, end - begin);
    Segment segment;
    if (const auto open = part.find('['); open != std::string_view::npos) {
      const std::string_view digits = part.substr(open + 1, part.size() - open - 2);
      const auto [rest, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), segment.index);
      if (part.back() != ']' || error != std::errc() || rest != digits.data() + digits.size() ||
          segment.index < 0)
        return invalid(path, "bad index in '" + std::string(part) + "', expected name[0]");
      part = part.substr(0, open);
    }
    if (part.empty()) return invalid(path, "empty name in path");
    segment.name = part;
    segments.push_back(segment);
    begin = end + 1;
  }
  return segments;
}

template <typename T>
bool parse_integer(std::string_view text, T* out) {
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && rest == text.data() + text.size();
}

bool parse_double(std::string_view text, double* out) {
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && rest == text.data() + text.size();
}

const EnumValueDescriptor* find_enum_value(const FieldDescriptor& field, std::string_view text) {
  for (int i = 0; i < field.enum_type()->value_count(); ++i)
    if (field.enum_type()->value(i)->name() == upper(text)) return field.enum_type()->value(i);
  return nullptr;
}

std::string enum_names(const FieldDescriptor& field) {
  std::string names;
  for (int i = 0; i < field.enum_type()->value_count(); ++i)
    names += (i ? ", " : "") + field.enum_type()->value(i)->name();
  return names;
}

// Writes a parsed value as a singular, an indexed or an appended one: the three ways of reflection.
#define GRANARY_STORE(Type, value)                                   \
  do {                                                               \
    if (!field.is_repeated())                                        \
      reflection->Set##Type(&message, &field, value);                \
    else if (index < reflection->FieldSize(message, &field))         \
      reflection->SetRepeated##Type(&message, &field, index, value); \
    else                                                             \
      reflection->Add##Type(&message, &field, value);                \
  } while (false)

Status set_scalar(Message& message, const FieldDescriptor& field, int index, std::string_view path,
                  std::string_view text) {
  const Reflection* reflection = message.GetReflection();
  const auto wrong = [&](const char* expected) {
    return invalid(path, "'" + std::string(text) + "' is not " + expected);
  };
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE: {
      double value = 0;
      if (!parse_double(text, &value)) return wrong("a number");
      GRANARY_STORE(Double, value);
      return Done{};
    }
    case FieldDescriptor::CPPTYPE_UINT32: {
      std::uint32_t value = 0;
      if (!parse_integer(text, &value)) return wrong("a whole number from 0 to 4294967295");
      GRANARY_STORE(UInt32, value);
      return Done{};
    }
    case FieldDescriptor::CPPTYPE_UINT64: {
      std::uint64_t value = 0;
      if (!parse_integer(text, &value)) return wrong("a whole number, 0 or more");
      GRANARY_STORE(UInt64, value);
      return Done{};
    }
    case FieldDescriptor::CPPTYPE_BOOL: {
      if (text != "true" && text != "false" && text != "1" && text != "0")
        return wrong("true or false");
      const bool value = text == "true" || text == "1";
      GRANARY_STORE(Bool, value);
      return Done{};
    }
    case FieldDescriptor::CPPTYPE_STRING: {
      GRANARY_STORE(String, std::string(text));
      return Done{};
    }
    case FieldDescriptor::CPPTYPE_ENUM: {
      const EnumValueDescriptor* value = find_enum_value(field, text);
      if (!value) return wrong(("one of " + enum_names(field)).c_str());
      GRANARY_STORE(Enum, value);
      return Done{};
    }
    default:
      return wrong("a value that can be set by path");
  }
}
#undef GRANARY_STORE

Status set_list(Message& message, const FieldDescriptor& field, std::string_view path,
                std::string_view text) {
  message.GetReflection()->ClearField(&message, &field);
  for (int index = 0; !text.empty(); ++index) {
    const std::size_t comma = std::min(text.find(','), text.size());
    if (Status status = set_scalar(message, field, index, path, text.substr(0, comma)); !status)
      return status;
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return Done{};
}

void visit_message(const Message& message, const std::string& prefix, const FieldVisitor& visit) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string path = prefix + field->name();
    const int count = field->is_repeated() ? message.GetReflection()->FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const int index = field->is_repeated() ? i : -1;
      const std::string here = index < 0 ? path : path + "[" + std::to_string(i) + "]";
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        const Message& child = index < 0
                                   ? message.GetReflection()->GetMessage(message, field)
                                   : message.GetReflection()->GetRepeatedMessage(message, field, i);
        visit_message(child, here + ".", visit);
      } else {
        visit(here, message, *field, index);
      }
    }
  }
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  std::string best;
  auto best_score = static_cast<std::ptrdiff_t>(std::max<std::size_t>(2, name.size() / 2)) + 1;
  for (const std::string& candidate : candidates) {
    // A wrong unit leaves the beginning right: what is common there counts in favour.
    const auto common = std::mismatch(name.begin(), name.end(), candidate.begin(), candidate.end());
    const std::ptrdiff_t score =
        static_cast<std::ptrdiff_t>(edit_distance(name, candidate)) - (common.first - name.begin());
    if (score < best_score) {
      best_score = score;
      best = candidate;
    }
  }
  return best;
}

std::string unknown_field_text(const Descriptor& type, std::string_view name) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  const std::string nearest = nearest_name(name, names);
  std::string text = "unknown field '" + std::string(name) + "'";
  if (!nearest.empty()) return text + ", did you mean '" + nearest + "'?";
  text += ", known here:";
  for (const std::string& known : names) text += " " + known;
  return text;
}

Status set_field(Message& root, std::string_view path, std::string_view value) {
  auto segments = split(path);
  if (!segments) return segments.error();
  Message* message = &root;
  for (std::size_t i = 0; i < segments->size(); ++i) {
    const Segment& segment = (*segments)[i];
    const FieldDescriptor* field = message->GetDescriptor()->FindFieldByName(segment.name);
    if (!field) return invalid(path, unknown_field_text(*message->GetDescriptor(), segment.name));
    const Reflection* reflection = message->GetReflection();
    const int size = field->is_repeated() ? reflection->FieldSize(*message, field) : 0;
    if (segment.index >= 0 && !field->is_repeated())
      return invalid(path, "'" + segment.name + "' is not a list");
    if (segment.index > size)
      return invalid(path, "index " + std::to_string(segment.index) + " is beyond the list's " +
                               std::to_string(size) + " entries");
    const bool last = i + 1 == segments->size();
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
      if (!last) return invalid(path, "'" + segment.name + "' has no parts");
      if (field->is_repeated() && segment.index < 0) return set_list(*message, *field, path, value);
      return set_scalar(*message, *field, segment.index, path, value);
    }
    if (last) return invalid(path, "'" + segment.name + "' is a group, name one of its fields");
    if (!field->is_repeated())
      message = reflection->MutableMessage(message, field);
    else if (segment.index < 0)
      return invalid(path, "'" + segment.name + "' is a list, write " + segment.name + "[0]");
    else if (segment.index < size)
      message = reflection->MutableRepeatedMessage(message, field, segment.index);
    else
      message = reflection->AddMessage(message, field);
  }
  return Done{};
}

void for_each_set_scalar(const Message& message, const FieldVisitor& visit) {
  visit_message(message, "", visit);
}

double scalar_number(const Message& message, const FieldDescriptor& field, int index) {
  const Reflection* r = message.GetReflection();
  const bool many = index >= 0;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return many ? r->GetRepeatedDouble(message, &field, index) : r->GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_UINT32:
      return many ? r->GetRepeatedUInt32(message, &field, index) : r->GetUInt32(message, &field);
    case FieldDescriptor::CPPTYPE_UINT64:
      return static_cast<double>(many ? r->GetRepeatedUInt64(message, &field, index)
                                      : r->GetUInt64(message, &field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return many ? r->GetRepeatedBool(message, &field, index) : r->GetBool(message, &field);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

std::string scalar_text(const Message& message, const FieldDescriptor& field, int index) {
  const Reflection* r = message.GetReflection();
  const bool many = index >= 0;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING:
      return many ? r->GetRepeatedString(message, &field, index) : r->GetString(message, &field);
    case FieldDescriptor::CPPTYPE_ENUM:
      return (many ? r->GetRepeatedEnum(message, &field, index) : r->GetEnum(message, &field))
          ->name();
    case FieldDescriptor::CPPTYPE_BOOL:
      return scalar_number(message, field, index) != 0 ? "true" : "false";
    case FieldDescriptor::CPPTYPE_UINT64:
      return std::to_string(many ? r->GetRepeatedUInt64(message, &field, index)
                                 : r->GetUInt64(message, &field));
    default: {
      char buffer[32];
      const auto end =
          std::to_chars(buffer, buffer + sizeof buffer, scalar_number(message, field, index));
      return {buffer, end.ptr};
    }
  }
}

std::string path_pattern(std::string_view path) {
  std::string pattern;
  bool inside = false;
  for (const char c : path) {
    if (c == ']') inside = false;
    if (!inside) pattern += c;
    if (c == '[') inside = true;
  }
  return pattern;
}

}  // namespace granary
