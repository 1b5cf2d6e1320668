#include "proto/contract/result.h"

namespace granary {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::cancelled:
      return "CANCELLED";
    case ErrorCode::unknown:
      return "UNKNOWN";
    case ErrorCode::invalid_argument:
      return "INVALID_ARGUMENT";
    case ErrorCode::deadline_exceeded:
      return "DEADLINE_EXCEEDED";
    case ErrorCode::not_found:
      return "NOT_FOUND";
    case ErrorCode::already_exists:
      return "ALREADY_EXISTS";
    case ErrorCode::permission_denied:
      return "PERMISSION_DENIED";
    case ErrorCode::resource_exhausted:
      return "RESOURCE_EXHAUSTED";
    case ErrorCode::failed_precondition:
      return "FAILED_PRECONDITION";
    case ErrorCode::aborted:
      return "ABORTED";
    case ErrorCode::out_of_range:
      return "OUT_OF_RANGE";
    case ErrorCode::unimplemented:
      return "UNIMPLEMENTED";
    case ErrorCode::internal:
      return "INTERNAL";
    case ErrorCode::unavailable:
      return "UNAVAILABLE";
    case ErrorCode::data_loss:
      return "DATA_LOSS";
    case ErrorCode::unauthenticated:
      return "UNAUTHENTICATED";
  }
  return "UNKNOWN";
}

ExitCode exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
    case ErrorCode::failed_precondition:
    case ErrorCode::out_of_range:
    case ErrorCode::unimplemented:
      return ExitCode::usage;
    case ErrorCode::not_found:
      return ExitCode::not_found;
    case ErrorCode::unavailable:
      return ExitCode::unreachable;
    case ErrorCode::permission_denied:
    case ErrorCode::unauthenticated:
      return ExitCode::not_allowed;
    case ErrorCode::cancelled:
      return ExitCode::cancelled;
    case ErrorCode::deadline_exceeded:
      return ExitCode::timed_out;
    case ErrorCode::data_loss:
      return ExitCode::verification_failed;
    default:
      return ExitCode::job_failed;
  }
}

}  // namespace granary
