#!/usr/bin/env bash
# Makes the pictures of this folder: bodies alone, the window of `mss view`, and moving pictures. Without a display:
#   xvfb-run -a results/view/run.sh [OUT]
set -euo pipefail
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
out=${1:-$here}
mss=$here/../../build/release/mss
view() { "$mss" view "$@"; }
body() { view "${@:2}" --plain --size 640x480 --shot "$out/$1.png"; }
film() { view "${@:2}" --record "$out/$1.webp"; }

body bear mesh_bear --frames 30
body creature voxel_creature --frames 20 --set material.young=3e5
body cube fig5_1_twist --frames 60
body ring mesh_torus --frames 18 --set material.young=4e4
view fig5_1_twist --frames 60 --size 1120x700 --shot "$out/fig5_1_twist.png"

film bear mesh_bear --frames 38
film heap "$here/heap.toml" --frames 38

# The thesis's scenes.
film fig2_1_crumple fig2_1_crumple --frames 38 --size 320x240
film fig5_1_twist fig5_1_twist --size 320x240
film fig5_2_bounce fig5_2_bounce --frames 38 --size 320x240

# A ball on the floor: at Verlet's safe step, and at the 1/60 s of a game's frame.
ball() { film "ball_$1" "$here/ball.toml" --size 320x240 --set "solve.integrator=$1" --set "solve.dt=$2" "${@:3}"; }
ball verlet '"safe"'
ball backward_euler 0.016666666666666666
ball xpbd 0.016666666666666666 --set solve.iterations=60
ball vbd 0.016666666666666666 --set solve.iterations=60

# The same soft beam, undamped, by this program and by two engines, whose positions are drawn. Without the engines they are left out.
peers=$here/../../reference/peers
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$mss" peer export "$peers/reports/bar.toml" --set material.young=1e5 --set solve.duration=1.1 --out "$work/beam"
film beam_mss "$work/beam/scene.toml" --size 320x240
engine() {
  if node "$peers/$1.mjs" "$work/beam" "$work/$1" "${@:2}"; then
    film "beam_$1" "$work/beam" --result "$work/$1" --size 320x240
  fi
}
engine mujoco --step 0.002
engine jolt --step 0.0166667 --iterations 20
