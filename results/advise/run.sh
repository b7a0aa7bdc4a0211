#!/usr/bin/env bash
# Advice for six scenes, every candidate beside it (of the twist all run to the end), and advice.csv that
# compares the two; then a cube with decreasing error limits:
#   results/advise/run.sh [OUT [SCENE ...]]    of these only: their rows are replaced
set -uo pipefail  # one scene that fails leaves the others
root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
out=${1:-$root/out/advise}
only=" ${*:2} "
mss=$root/build/release/mss
mkdir -p "$out"
# shellcheck source=results/meta.sh
source "$root/results/meta.sh"

# The advised candidate's error against finite elements of half its cells, and what these are uncertain by.
elements() { awk -F, -v OFS=, 'NR == 2 { error = $2; uncertainty = $3 } END { print error, uncertainty }' "$1/advise_elements.csv"; }

# A row of advice.csv. The columns up to the tenth are a candidate; in the grid's table the advised one has the
# error against the grid's reference, which the advisor did not use, and a time taken beside the cheapest's.
compare() {
  local scene=$1 error=$2 of=$3 advice=$out/$1 grid=$out/${1}_grid
  awk -F, -v OFS=, -v scene="$scene" -v requested="$error" -v of="$of" -v elements="$(elements "$advice")" \
    -v seconds="$(from_meta "$advice" seconds)" -v all="$(from_meta "$grid" seconds)" -v pruned="$4" '
    function candidate(  key, i) { key = $1; for (i = 2; i <= 9; ++i) key = key FS $i; return key }
    FNR == 1 { next }
    FILENAME ~ /_grid\/advise.csv$/ {
      if (candidate() == advised && (cost == "" || $12 < cost)) { error = $11; cost = $12; share = $13 }
      if ($NF ~ /^(advised|meets the error|the cheapest)/ && (least == "" || $12 + 0 < least + 0)) least = $12
      ++tried
      if ($NF ~ /^(advised|meets the error|the cheapest|too close)/) ++meeting
      next
    }
    $NF == "advised" { advised = candidate(); cell = $1; precision = $5; integrator = $6; dt = $8; found = $11 }
    END {
      print scene, of, requested, cell, precision, integrator, dt, found, error, share,
            least == "" || cost == "" ? "" : cost / least, seconds, all, tried, seconds / all,
            meeting + 0, pruned, elements
    }' "$advice/advise.csv" "$grid/advise.csv" > "$out/row.csv"
  { head -1 "$out/advice.csv"; sed 1d "$out/advice.csv" | grep -v "^$scene,"; cat "$out/row.csv"; } > "$out/advice.new"
  rm "$out/row.csv"
  mv "$out/advice.new" "$out/advice.csv"
  meta_of_script results/advise/run.sh "$advice" > "$out/meta.json"
}

selected() { [[ $only == "  " || $only == *" $1 "* ]]; }

# scene, error, of, finest level of the grid, whether the grid is pruned, further options of mss
advise() {
  local scene=$1 error=$2 of=$3 finest=$4 pruned=$5
  local unpruned=()
  [[ $pruned == pruned ]] || unpruned=(--unpruned)
  selected "$scene" || return 0
  "$mss" advise "$scene" --error "$error" --of "$of" --out "$out/$scene" "${@:6}"
  "$mss" advise "$scene" --error "$error" --of "$of" --grid "$finest" "${unpruned[@]}" --out "$out/${scene}_grid" "${@:6}"
  compare "$scene" "$error" "$of" "$pruned"
}

[[ -f $out/advice.csv && $only != "  " ]] ||
  echo "scene,of,requested,cell_size,precision,integrator,dt,error_found,error_in_grid,share_run_in_grid,cost_over_cheapest,seconds_advising,seconds_grid,tried_in_grid,share_of_grid,meeting_in_grid,grid,error_against_elements,elements_uncertainty" > "$out/advice.csv"
advise fig5_2_throw 20% deformation 4 pruned --set solve.duration=1
advise fig5_1_twist 3% volume 4 unpruned --set hold.1.turn.rate=0.785  # finer lattices fold at 60 degrees
advise hanging_bar 1% displacement 7 pruned
advise jelly_slope 5% displacement 5 pruned --set solve.duration=1
advise voxel_creature 5% volume 3 pruned --patience 10 --set solve.duration=0.5
advise cantilever 10% displacement 6 pruned --set solve.duration=2 --patience 10

# One scene with decreasing error limits.
for error in 10% 1% 0.3%; do
  selected free_cube || continue
  "$mss" advise free_cube --error "$error" --of displacement --out "$out/free_cube_${error%\%}"
done

# In results/ those charts stay that the page of this folder shows.
if [[ $out -ef $root/results/advise ]]; then
  for chart in "$out"/*/advise.svg; do
    grep -qF "]($(basename -- "$(dirname -- "$chart")")/advise.png)" "$out/README.md" || rm -f -- "${chart%.svg}".{svg,png}
  done
fi
