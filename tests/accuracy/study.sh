# Sourced by the scripts beside it: studies on a private server of their own, tables into $out.
here=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-$here/tests/accuracy/results}
granary=$here/build/release/bin/granary
scenes=$here/tests/scenes
mkdir -p "$out"
GRANARY_DATA=$(mktemp -d); export GRANARY_DATA
export GRANARY_CALIBRATION="$GRANARY_DATA/calibration"
trap 'rm -rf "$GRANARY_DATA"' EXIT

# study VERB NAME SCENE OPTIONS..: what it says and its table to $out/VERB_NAME.txt; asked again for
# the same (all results are stored by then), as json to $out/VERB_NAME.json; price also draws.
study() {
  verb=$1; file=$out/$1_$2; scene=$scenes/$3.txtpb; shift 3
  plot=
  if [ "$verb" = price ]; then plot="-o $file.svg"; fi
  "$granary" "$verb" "$scene" "$@" $plot > "$file.table" 2> "$file.said"
  { sed -n 's/^granary: \(knee\|shows\|no difference\)/\1/p' "$file.said" | tr ';' '\n' | sed 's/^ //'; echo
    cat "$file.table"; } > "$file.txt"
  "$granary" "$verb" "$scene" "$@" -q --format json > "$file.json"
  rm "$file.table" "$file.said"
}
