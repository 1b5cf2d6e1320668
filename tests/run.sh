#!/usr/bin/env bash
# Installs what is missing, builds, runs every test. Arguments go to ctest: tests/run.sh -L unit
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/build.sh
# Two at a time: service tests wait for processes, physics tests compute.
ctest --test-dir build/release --output-on-failure -j "$(nproc)" "$@"
