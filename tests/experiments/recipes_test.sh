#!/usr/bin/env bash
# recipes_test.sh parallel|snakemake MSS DIR: a recipe of experiments/recipes makes the tables that one run makes, in DIR. Exit status
# 77, which CTest takes for "skipped", where its program is not installed.
set -euo pipefail

recipe=$1 mss=$2 directory=$3
recipes=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../../experiments/recipes" && pwd)
command -v "$recipe" >/dev/null || { echo "skipped: $recipe is not installed" >&2; exit 77; }

rm -rf "$directory"
mkdir -p "$directory"
cd "$directory"
options=(--quick --integrators verlet)
"$mss" stability atlas "${options[@]}" --out whole
case $recipe in
  parallel) MSS=$mss "$recipes/gnu_parallel.sh" 3 merged stability atlas "${options[@]}" ;;
  snakemake)
    snakemake --snakefile "$recipes/Snakefile" --cores 2 --quiet \
      --config study="stability atlas" options="${options[*]}" parts=3 out=merged mss="$mss"
    ;;
esac
[[ -s whole/atlas.csv ]]
for table in whole/*.csv; do cmp "$table" "merged/${table#whole/}"; done
