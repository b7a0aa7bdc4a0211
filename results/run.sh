#!/usr/bin/env bash
# Reruns every study of this folder with build/release/mss, each in a process group of its own; those that measure
# time wait until the machine is quiet. A folder is replaced when its study is done; of its charts those stay that a text
# shows. After all of them `mss reproduce --quick`, and how long each took both ways: study_times.csv, from which
# `mss reproduce` says beforehand how long it takes.
#   results/run.sh [OUT [STUDY ...]]    of these only; the default is this folder and all of them
set -euo pipefail
root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
out=${1:-$root/results}
untimed=(atlas failures recovery stability volume energy shape contact validate)
timed=(timing precision stiffness convergence frames regimes refine thesis)
studies=("${@:2}")
[[ ${#studies[@]} -gt 0 ]] || studies=("${untimed[@]}" "${timed[@]}")

command_of() {
  case $1 in
    atlas | failures) echo "stability $1" ;;
    contact) echo "validate contact" ;;
    timing) echo "timing --peers" ;;
    *) echo "$1" ;;
  esac
}

# Up to five minutes; meta.json says what the load was.
wait_until_quiet() {
  local load
  for _ in {1..60}; do
    read -r load _ < /proc/loadavg
    awk "BEGIN { exit !($load < 0.3) }" && return
    sleep 5
  done
  echo "results/run.sh: the machine is busy, load $load" >&2
}

drop_charts_that_no_text_shows() {
  local chart name
  for chart in "$out/$1"/*.svg; do
    name=$1/$(basename -- "$chart" .svg)
    grep -qF "$name.png" "$root"/{README.md,results/README.md,reference/THESIS.md} || rm -f -- "$out/$name".{svg,png}
  done
}

for study in "${studies[@]}"; do
  [[ " ${timed[*]} " != *" $study "* ]] || wait_until_quiet
  rm -rf -- "$out/$study.new"
  # shellcheck disable=SC2046  # a command may have several words
  setsid --wait "$root/build/release/mss" $(command_of "$study") --out "$out/$study.new"
  rm -rf -- "${out:?}/$study"
  mv -- "$out/$study.new" "$out/$study"
  drop_charts_that_no_text_shows "$study"
done

# What meta.json of a study has under a key on a line of its own.
json() { sed -n "s/^ *\"$2\": \"\{0,1\}\([^,\"]*\)\"\{0,1\},\{0,1\}$/\1/p" "$1/meta.json" | head -1; }

write_study_times() {
  local quick=$out/quick.new
  setsid --wait "$root/build/release/mss" reproduce --quick --out "$quick"
  echo "study,quick,full,machine" > "$out/study_times.new"
  for study in "${studies[@]}"; do
    echo "$study,$(json "$quick/$study" wall_seconds),$(json "$out/$study" wall_seconds),$(json "$out/$study" cpu)"
  done >> "$out/study_times.new"
  rm -rf -- "$quick"
  mv -- "$out/study_times.new" "$out/study_times.csv"
}

[[ $# -gt 1 ]] || write_study_times
