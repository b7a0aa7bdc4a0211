#!/usr/bin/env bash
# From a bare Debian 12 to the program, to results or to test verdicts in one command.
set -euo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat >&2 <<'TEXT'
usage: ./run.sh build                 build the program, build/release/mss
       ./run.sh reproduce [options]   build, then rerun every experiment and draw every chart
       ./run.sh test [options]        build, then run the tests; options go to ctest

All install what packages.txt lists and this system lacks, and fetch the engines of reference/peers (MuJoCo, Jolt).
Options of reproduce: --quick, --out DIR.
TEXT
  exit 2
}

say() { printf 'run.sh: %s\n' "$*" >&2; }

as_root() {
  if [[ $EUID -eq 0 ]]; then "$@"; else sudo "$@"; fi
}

missing_packages() {
  local package status
  sed 's/#.*//' "$root/packages.txt" | awk 'NF { print $1 }' | while read -r package; do
    [[ $package == npm ]] && command -v npm >/dev/null && continue
    status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $status == installed ]] || echo "$package"
  done
}

install_packages() {
  if ! command -v dpkg-query >/dev/null; then
    say "this is not Debian, so install the equivalents of packages.txt yourself; building with what is there"
    return
  fi
  local names missing
  names=$(missing_packages)
  [[ -n $names ]] || return 0
  mapfile -t missing <<<"$names"
  if [[ $EUID -ne 0 ]] && ! command -v sudo >/dev/null; then
    say "these packages are missing, and only root can install them with apt-get install: ${missing[*]}"
    exit 2
  fi
  say "installing ${missing[*]}"
  as_root apt-get update --quiet
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install --quiet --yes --no-install-recommends "${missing[@]}"
}

# MuJoCo and Jolt for Node.js, as reference/peers/package-lock.json has them; `mss peers` says where they are missing.
fetch_engines() {
  local folder=$root/reference/peers
  [[ ! $folder/node_modules/.package-lock.json -nt $folder/package-lock.json ]] || return 0
  if ! command -v npm >/dev/null; then
    say "npm is not installed, so mss peers will leave out MuJoCo and Jolt"
  elif ! (cd "$folder" && npm ci --silent --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000); then
    say "npm could not fetch MuJoCo and Jolt (is there no network?), so mss peers will leave them out"
  fi
}

# Builds what is named: the program is enough to reproduce, and tests wait for nothing they do not use.
build() {
  (cd "$root" && cmake --preset release && cmake --build --preset release --parallel "$(nproc)" --target "$1")
}

# What to try of the program, by its path from here.
suggest() {
  local mss=$root/build/release/mss
  mss=${mss#"$PWD/"}
  say "try: $mss view mesh_bear    (without a display: xvfb-run -a $mss view mesh_bear --frames 18 --shot bear.png)"
  say "and: $mss run cantilever    ($mss list scenes: all there are; $mss --help: what else it does)"
}

# The directory that mss will write to: what --out says, else one in this repository.
out_directory() {
  local directory="$root/out/reproduce"
  while [[ $# -gt 0 ]]; do
    case $1 in
      --out) directory=${2:-} ;;
      --out=*) directory=${1#--out=} ;;
    esac
    shift
  done
  echo "$directory"
}

reproduce() {
  local out
  out=$(out_directory "$@")
  local options=("$@")
  [[ " $* " == *" --out"[\ =]* ]] || options+=(--out "$out")
  "$root/build/release/mss" reproduce "${options[@]}"
  [[ ! -f $out/index.html ]] || say "every chart is on the page $out/index.html, and beside it as SVG, PNG and CSV"
}

case ${1:-} in
  build)
    [[ $# -eq 1 ]] || usage
    install_packages
    fetch_engines
    build mss
    suggest
    ;;
  reproduce)
    install_packages
    fetch_engines
    build mss
    reproduce "${@:2}"
    ;;
  test)
    install_packages
    fetch_engines
    build mss_all_tests
    (cd "$root" && ctest --preset release "${@:2}")
    ;;
  *) usage ;;
esac
