#!/usr/bin/env bash
# Makes the pictures of this folder: bodies alone, for README.md, and the window of `mss view`. Without a display:
#   xvfb-run -a results/view/run.sh [OUT]
set -euo pipefail
root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
out=${1:-$root/results/view}
view() { "$root/build/release/mss" view "${@:2}" --shot "$out/$1.png"; }
body() { view "$@" --plain --size 640x480; }

body bear mesh_bear --frames 30
body creature voxel_creature --frames 20 --set material.young=3e5
body cube fig5_1_twist --frames 60
body ring mesh_torus --frames 18 --set material.young=4e4
view fig5_1_twist fig5_1_twist --frames 60 --size 1120x700
