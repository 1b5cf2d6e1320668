#!/bin/bash
# Times the DEM engine against LAMMPS in turn on one core (A B A B ...): CPU time per particle and
# step, whole step with lists. States: the steady chute (tests/reference) and a dense bed made here;
# both codes start from the same exported file, without contact history, and warm up for 200 steps.
# usage: compare.sh [rounds] [build directory]. Appends to results/<cpu>.csv beside this script.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
rounds=${1:-5}
build=${2:-$here/../../build/release}
speed=$build/bin/dem_speed
command -v lmp >/dev/null || { echo "compare.sh: lmp is missing (Debian package lammps)"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
family=$(sed -n 's/^cpu family[^:]*: //p' /proc/cpuinfo | head -1)
model=$(sed -n 's/^model[^ n]*: //p' /proc/cpuinfo | head -1)
file=$here/results/$(echo "$cpu family $family model $model" | tr -c 'A-Za-z0-9\n' '_').csv
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[^=]*=//p' "$build/CMakeCache.txt")
compiler="$(basename "$compiler") $("$compiler" -dumpfullversion)"
commit=$(git -C "$here" rev-parse --short HEAD)
[ -f "$file" ] || echo "date,commit,compiler,case,code,threads,ns_min,ns_median,load_1min" >"$file"

# min and median of the numbers on stdin
statistics() { sort -g | awk '{v[NR] = $1} END {printf "%.2f %.2f", v[1], v[int((NR + 1) / 2)]}'; }

ours() {  # options -> ns of each block
  "$speed" --quiet --samples --warm 200 --blocks 3 "$@"
}

peer() {  # data slope end steps -> ns of each block, CPU time = wall time x share of the core
  lmp -in "$here/chute.lmp" -log none -var data "$1" -var slope "$2" -var end "$3" -var steps "$4" \
      -var blocks 3 -var dt 1e-5 |
    awk -v steps="$4" '/^Loop time/ {wall = $4; atoms = $12}
      /CPU use/ && ++runs > 1 {sub("%", "", $1); printf "%.2f\n", 1e9 * wall * $1 / 100 / steps / atoms}'
}

record() {  # case code threads min median
  echo "$(date -u +%F),$commit,$compiler,$1,$2,$3,$4,$5,$(cut -d' ' -f1 /proc/loadavg)" >>"$file"
}

compare() {  # case slope end steps, then options of dem_speed for the state
  local name=$1 slope=$2 end=$3 steps=$4
  shift 4
  "$speed" "$@" --warm 0 --blocks 0 --quiet --export "$work/$name.data" >/dev/null
  : >"$work/ours"; : >"$work/peer"
  for _ in $(seq "$rounds"); do
    ours "$@" --steps "$steps" >>"$work/ours"
    peer "$work/$name.data" "$slope" "$end" "$steps" >>"$work/peer"
  done
  read -r a a_median <<<"$(statistics <"$work/ours")"
  read -r b b_median <<<"$(statistics <"$work/peer")"
  record "$name" granary 1 "$a" "$a_median"
  record "$name" lammps 1 "$b" "$b_median"
  awk -v n="$name" -v a="$a" -v am="$a_median" -v b="$b" -v bm="$b_median" 'BEGIN {
    printf "%-12s granary %6.2f [%6.2f]  lammps %7.2f [%7.2f] ns  ratio %5.1f [%5.1f]\n",
           n, a, am, b, bm, b / a, bm / am}'
}

zcat "$here/../reference/chute_30deg_0rpm_snapshot.csv.gz" >"$work/chute.csv"
"$speed" --warm 0 --blocks 0 --quiet --save "$work/bed.csv" >/dev/null
echo "minimum [median] of $((3 * rounds)) blocks, CPU time, $cpu family $family model $model"
compare chute 30 2 300 --state "$work/chute.csv"
compare dense_bed 10 0.9 200 --state "$work/bed.csv" --closed
