#!/usr/bin/env bash
# Runs a command with a screen of its own: with_display.sh COMMAND [ARGUMENT...]. Exit status 77, which CTest takes for
# "skipped", where there is no Xvfb or no xdotool.
set -euo pipefail

for program in Xvfb xdotool; do
  if ! command -v "$program" >/dev/null; then
    echo "skipped: $program is not installed; packages.txt names its package" >&2
    exit 77
  fi
done

number=$(mktemp)
Xvfb -displayfd 3 -screen 0 1400x1000x24 -nolisten tcp -noreset 3>"$number" 2>/dev/null &
screen=$!
trap 'kill "$screen"; rm -f "$number"' EXIT
until [[ -s $number ]]; do
  kill -0 "$screen" || exit 1
  sleep 0.05
done
DISPLAY=:$(cat "$number")
export DISPLAY
"$@"
