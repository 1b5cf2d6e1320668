// What a job needs of a worker beyond its kind: tags the worker must carry. Kept as one canonical text
// ("name=value" lines in order), so that equal needs are equal strings in memory, index and database.
#pragma once

#include <map>
#include <string>

#include "proto/contract/result.h"

namespace granary::server {

using Tags = std::map<std::string, std::string>;

std::string needs_text(const Tags& tags);
Tags tags_of_needs(const std::string& needs);
bool fulfils(const Tags& worker_tags, const std::string& needs);

// INVALID_ARGUMENT: empty names, '=' in a name, line ends, or more than 16 tags of 64 characters.
Status check_worker_tags(const Tags& tags);

}  // namespace granary::server
