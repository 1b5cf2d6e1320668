// Table-valued SQL function series_rows(message): the rows (name, time_s, value) of a stored
// v1.SeriesList. One name per column: "remaining.remaining_percent", "cg.x_m".
#pragma once

struct sqlite3;

namespace granary::server {

// Throws std::runtime_error.
void add_series_function(sqlite3* connection);

}  // namespace granary::server
