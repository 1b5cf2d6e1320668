#!/usr/bin/env bash
# Release build of programs and tests into build/release (programs in build/release/bin).
# A second call rebuilds nothing.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-deps.sh
launcher=()
command -v ccache >/dev/null && launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
if [ ! -f build/release/build.ninja ]; then
  cmake --preset release "${launcher[@]}" >&2
fi
cmake --build --preset release "$@" >&2
