// Versions that travel with every result. kEngineVersion is part of every job key: raise it
// whenever an engine may compute another bit (CHANGELOG says "results change: yes").
#pragma once

namespace granary {

inline constexpr const char* kProductVersion = "0.1.0";
inline constexpr const char* kEngineVersion = "2026.11.12";

}  // namespace granary
