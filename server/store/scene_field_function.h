// SQL function scene_field(resolved_scene, 'path'): one scalar out of a stored scene, by walking
// the wire format without building the message (a column over a million jobs must not parse a
// million scenes). NULL when the field is not set. Enums give their name, booleans 0 and 1.
#pragma once

struct sqlite3;

namespace granary::server {

// Throws std::runtime_error.
void add_scene_field_function(sqlite3* connection);

}  // namespace granary::server
