#!/usr/bin/env bash
# What is too long for every change: full kill storms, fuzzing, scale, error intervals, sanitizers. Each part adds a row to
# tests/long_results.md with date, commit, size, result and seconds; the suite keeps a reduced size of each.
#   tests/long.sh [PART..]    parts: storm faults solvers scale coverage fuzz asan tsan; default: all
set -euo pipefail
cd "$(dirname "$0")/.."
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(storm faults solvers scale coverage fuzz asan tsan)
table=tests/long_results.md
log=$(mktemp -d)

row() {  # part, size, result, seconds
  echo "| $(date -u +%F) | $(git rev-parse --short HEAD) | $1 | $2 | $3 | $4 |" | tee -a "$table"
}
timed() {  # part, size, command..: a row with what came of it
  local part=$1 size=$2 start=$SECONDS result=passed
  shift 2
  "$@" >"$log/$part.log" 2>&1 || result="FAILED, see $log/$part.log"
  row "$part" "$size" "$result" $((SECONDS - start))
  [ "$result" = passed ] || failed=1
}
failed=0

storm() {
  timed storm "200 kills, 500 jobs" env GRANARY_STORM_KILLS=200 GRANARY_STORM_JOBS=500 \
    build/release/tests/faults_service --gtest_filter='KillStorm.*'
}
faults() {
  timed faults "300 kills of the engine, every byte and every write" env GRANARY_KILLS=300 GRANARY_STRIDE=1 \
    build/release/tests/faults_storage
}
solvers() {
  timed solvers "IMPULSE against OPEN_CLOSE, 700 disks, 24 fillings" env GRANARY_SOLVER_DISKS=700 GRANARY_SOLVER_FILLINGS=24 \
    build/release/tests/physics_dda --gtest_filter='SolversAgree.*'
  grep "mean \(difference\|paths\)" "$log/solvers.log" || true
}
scale() {
  timed scale "1,000,000 jobs, 100 workers" build/release/bin/queue_scale
  cat "$log/scale.log"
}
coverage() {
  timed coverage "8 scenes, 3 targets, 64 finest replicates" python3 tests/accuracy/coverage.py
  cp "$log/coverage.log" tests/accuracy/results/coverage.md
}
fuzz() {
  local seconds=${GRANARY_FUZZ_SECONDS:-600}
  cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_COMPILER=clang++ \
    -DGRANARY_SANITIZE=address,undefined,fuzzer-no-link -DGRANARY_FUZZ=ON >"$log/fuzz.log"
  for target in ${GRANARY_FUZZ_TARGETS:-scene_text worker_protocol query}; do
    [ -f "tests/fuzz/${target}_fuzz.cpp" ] || continue
    cmake --build build/fuzz --target "fuzz_$target" >>"$log/fuzz.log"
    mkdir -p "build/fuzz/found/$target"
    timed "fuzz $target" "$seconds s of libFuzzer, ASan+UBSan" \
      "$(find build/fuzz -name "fuzz_$target" -type f)" -max_total_time="$seconds" -rss_limit_mb=4096 \
      "build/fuzz/found/$target" "tests/fuzz/corpus/$target"
  done
}
# By clang, which builds with sanitizers in a third of gcc's time (apt install clang).
asan() {
  cmake --preset asan >"$log/asan_build.log" && cmake --build --preset asan >>"$log/asan_build.log"
  # Without the option an undefined operation is printed and the test passes.
  timed asan "whole suite, ASan+UBSan" env UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 ctest --test-dir build/asan --output-on-failure -j "$(nproc)"
}
# gRPC is not built for the thread sanitizer and would drown its own reports: everything that runs without it, and
# the server's own parts, whose test program links it.
tsan() {
  local programs=(unit_contract unit_core unit_dda unit_dem unit_measure_chute unit_measure_discharge unit_run
    unit_scene_chute unit_scene_discharge unit_server unit_storage compat_files faults_storage physics_chute
    physics_chute_paper physics_dda physics_dem physics_frames physics_papers stability_cases)
  cmake --preset tsan >"$log/tsan_build.log" && cmake --build --preset tsan --target toy_engine "${programs[@]}" >>"$log/tsan_build.log"
  timed tsan "everything without gRPC, and the server's parts" ctest --test-dir build/tsan --output-on-failure \
    -j "$(nproc)" -E '_NOT_BUILT$|^Fuzz' -L 'unit|physics|stability|faults|compat'
}

for part in "${parts[@]}"; do "$part"; done
exit $failed
