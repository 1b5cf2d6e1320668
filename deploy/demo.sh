#!/usr/bin/env bash
# The first thing to try: builds what is needed, starts a private server and two workers, runs the
# shipped discharge scene, streams its progress, prints f1-f4 and says where the result is.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/build.sh
bin=$PWD/build/release/bin
out=$PWD/build/demo
scene=tests/scenes/discharge_700_centrifugal.txtpb
mkdir -p "$out"
data=$(mktemp -d "${TMPDIR:-/tmp}/granary-demo.XXXXXX")

"$bin/granary" up --data "$data" --listen "unix:$data/demo.sock" --workers 2 >"$data/up.log" 2>&1 &
up=$!
trap 'kill -TERM $up 2>/dev/null || true; wait $up 2>/dev/null || true; rm -rf "$data"' EXIT
export GRANARY_SERVER=unix:$data/demo.sock

for _ in $(seq 100); do
  "$bin/granary" health -q >/dev/null 2>&1 && break
  kill -0 $up 2>/dev/null || { cat "$data/up.log" >&2; exit 1; }
  sleep 0.1
done

echo "server and two workers are up; running $scene"
job=$("$bin/granary" submit "$scene")
"$bin/granary" watch "$job"
"$bin/granary" values "$job"
"$bin/granary" fetch "$job" -o "$out/demo.h5" --force
"$bin/granary" export "$job" --to svg -o "$out" -q >/dev/null
echo "result file: $out/demo.h5"
echo "picture:     $out/picture.svg"
