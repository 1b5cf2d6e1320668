// Result<T>: a value, or one clear error with the gRPC code it travels as. Expected failures are
// values; exceptions are for bugs and for libraries that throw.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace granary {

// The subset of gRPC's codes in use, with gRPC's numbers.
enum class ErrorCode {
  cancelled = 1,
  unknown = 2,
  invalid_argument = 3,
  deadline_exceeded = 4,
  not_found = 5,
  already_exists = 6,
  permission_denied = 7,
  resource_exhausted = 8,
  failed_precondition = 9,
  aborted = 10,
  out_of_range = 11,
  unimplemented = 12,
  internal = 13,
  unavailable = 14,
  data_loss = 15,
  unauthenticated = 16
};

struct Error {
  ErrorCode code = ErrorCode::unknown;
  std::string message;     // one line for people
  std::string field_path;  // "discharge.particles.count"; empty when no field is to blame
  int retry_after_ms = 0;  // RESOURCE_EXHAUSTED: it passes by itself, ask again then; 0 = it does not
};

std::string_view to_string(ErrorCode code);

// Exit codes of the client (PRODUCT section 2).
enum class ExitCode {
  ok = 0,
  job_failed = 1,
  usage = 2,
  not_found = 3,
  unreachable = 4,
  not_allowed = 5,
  unstable = 6,
  cancelled = 7,
  timed_out = 8,
  verification_failed = 9,
  interrupted = 130
};

ExitCode exit_code_of(ErrorCode code);

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT: implicit by design
  Result(Error error) : content_(std::move(error)) {}  // NOLINT

  bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }
  // Precondition: ok().
  T& value() { return std::get<T>(content_); }
  const T& value() const { return std::get<T>(content_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  // Precondition: !ok().
  const Error& error() const { return std::get<Error>(content_); }

 private:
  std::variant<T, Error> content_;
};

struct Done {};
using Status = Result<Done>;

}  // namespace granary
