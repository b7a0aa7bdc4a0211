#!/usr/bin/env bash
# Fills this folder with what `./run.sh reproduce` wrote, study by study; of their charts those stay that a text shows, and
# the page of each study, NAME/README.md, stays.
# Then `mss reproduce --quick`, for how long each study takes both ways: reproduce/study_times.csv, from which
# `mss reproduce` says beforehand how long it takes.
#   results/run.sh [DIR]    where the finished studies are; without it they are run first, into out/reproduce
set -euo pipefail
root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
results=$root/results
# shellcheck source=results/meta.sh
source "$results/meta.sh"
[[ $# -gt 0 ]] || "$root/run.sh" reproduce
from=${1:-$root/out/reproduce}

drop_charts_that_no_text_shows() {
  local chart name
  for chart in "$results/$1"/*.svg; do
    name=$1/$(basename -- "$chart" .svg)
    grep -qF "$name.png" "$root"/{README.md,results/README.md,reference/THESIS.md} ||
      grep -qF "]($(basename -- "$name").png)" "$results/$1/README.md" || rm -f -- "$results/$name".{svg,png}
  done
}

shopt -s nullglob
studies=("$from"/*/meta.json)
[[ ${#studies[@]} -gt 0 ]] || { echo "results/run.sh: there are no studies in $from" >&2; exit 2; }
studies=("${studies[@]%/meta.json}")
studies=("${studies[@]##*/}")
for study in "${studies[@]}"; do
  mkdir -p -- "$results/$study"
  find "$results/$study" -mindepth 1 -maxdepth 1 ! -name README.md -exec rm -rf -- {} +
  cp -r -- "$from/$study/." "$results/$study"
  drop_charts_that_no_text_shows "$study"
done

quick=$(mktemp -d)
trap 'rm -rf -- "$quick"' EXIT
"$root/build/release/mss" reproduce --quick --out "$quick"
times=$results/reproduce
mkdir -p -- "$times"
echo "study,quick,full,machine" > "$times/study_times.new"
for study in "${studies[@]}"; do
  in_quick=$(from_meta "$quick/$study" wall_seconds)
  echo "$study,$in_quick,$(from_meta "$results/$study" wall_seconds),$(from_meta "$results/$study" cpu)"
done >> "$times/study_times.new"
mv -- "$times/study_times.new" "$times/study_times.csv"
meta_of_script results/run.sh "$results/${studies[0]}" > "$times/meta.json"
