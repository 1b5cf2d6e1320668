// Fields of a scene by path: "discharge.particles.count", "chute.particles[0].diameter_m". One
// notation for --set, error messages, rules, SQL columns and the canonical hash.
#pragma once

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/contract/result.h"

namespace granary {

// Sets one scalar from text as a user would type it: enum values case-insensitive and bare, strings
// without quotes; list elements by index, "[n]" with n = size appends. Lists of numbers take
// "a,b,c". Errors name the path and, for unknown names, the nearest known one.
Status set_field(google::protobuf::Message& message, std::string_view path, std::string_view value);

// The name in `candidates` with the smallest edit distance to `name`; empty when none is close.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

// "has no field 'x' (did you mean 'y'?)", given the type that lacks it.
std::string unknown_field_text(const google::protobuf::Descriptor& type, std::string_view name);

// Calls visit(path, message, field, index) for every set scalar below `message`, in field order;
// index is -1 for singular fields.
using FieldVisitor =
    std::function<void(const std::string& path, const google::protobuf::Message& message,
                       const google::protobuf::FieldDescriptor& field, int index)>;
void for_each_set_scalar(const google::protobuf::Message& message, const FieldVisitor& visit);

// The value of a visited scalar as text: shortest form that reads back to the same bits.
std::string scalar_text(const google::protobuf::Message& message,
                        const google::protobuf::FieldDescriptor& field, int index);
// The same as a number; enums and strings give NaN.
double scalar_number(const google::protobuf::Message& message,
                     const google::protobuf::FieldDescriptor& field, int index);

// "chute.particles[3].diameter_m" -> "chute.particles[].diameter_m": how rules are written.
std::string path_pattern(std::string_view path);

}  // namespace granary
