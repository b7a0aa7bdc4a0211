#!/usr/bin/env bash
# Drives the window of `mss view` with real mouse and key events and checks what it says it did: window_test.sh MSS.
# Needs a screen: see with_display.sh.
set -euo pipefail

mss=$1
folder=$(mktemp -d)
log=$folder/log
view=
trap 'if [[ -n $view ]] && kill -0 "$view" 2>/dev/null; then kill "$view"; fi; rm -rf "$folder"' EXIT

seen=0  # lines of the log that were looked at
line=   # the last of them

fail() {
  echo "FAILED: $*" >&2
  echo "after: $line" >&2
  exit 1
}

# Waits for the next line of the log that tells of an event, for as long as a slow or busy machine may take to send it.
expect() {
  local count alive=1 begin=$SECONDS
  while ((alive && SECONDS - begin < 300)); do
    kill -0 "$view" 2>/dev/null || alive=0  # what it said before it ended is there
    count=$(tail -n +$((seen + 1)) "$log" | grep -n "^{\"event\":\"$1\"" | head -1 | cut -d: -f1 || true)
    if [[ -n $count ]]; then
      seen=$((seen + count))
      line=$(sed -n "${seen}p" "$log")
      return
    fi
    sleep 0.05
  done
  fail "no '$1' came"
}

# A number or word of that line.
field() { grep -o "\"$1\":[^,}]*" <<<"$line" | head -1 | cut -d: -f2 | tr -d '"'; }

# is EXPRESSION, holds EXPRESSION: of numbers, as awk has them; the latter fails unless it is so.
is() { awk "BEGIN { exit !($1) }"; }
holds() { is "$1" || fail "not so: $1"; }

# Where something is: the point at a share of its width, in the middle of its height.
point() {
  grep -o "\"$1\":\[[^]]*\]" <<<"$line" | tr -d '[]' | sed 's/.*://' |
    awk -F, -v share="${2:-0.5}" '{ print int($1 + share * $3), int($2 + $4 / 2) }'
}

press() { # X Y: presses and lets go there
  xdotool mousemove --window "$window" "$1" "$2" sleep 0.12 mousedown 1 sleep 0.12 mouseup 1 sleep 0.05
}

key() { xdotool key --delay 50 "$1"; }

start() {
  "$mss" view voxel_creature --log --set 'environment.gravity=[0,0,0]' --set 'start.velocity=[0,0,0]' \
    --set solve.duration=1000 >"$log" &
  view=$!
  expect ready
  window=$(xdotool search --onlyvisible --name 'mss view: voxel_creature')
  xdotool windowfocus --sync "$window"
  [[ $(field status) == ok && $(field playing) == true && $(field width) == 1280 ]] || fail "not ready"
  holds "$(field kinetic) == 0"
  body=$(grep -o '"middle":\[[^]]*\]' <<<"$line" | tr -d '[]' | cut -d: -f2 | tr ',' ' ')
}

drag_the_body() {
  local x y
  read -r x y <<<"$body"
  xdotool mousemove --window "$window" "$x" "$y" sleep 0.1 mousedown 1
  expect grab
  for away in 20 40 60 80; do xdotool mousemove --window "$window" $((x + away)) "$y" sleep 0.05; done
  sleep 0.3
  xdotool mouseup 1
  expect release
  holds "$(field kinetic) > 1e-6"
}

pause_and_step() {
  key space
  expect pause
  [[ $(field playing) == false ]] || fail "plays on"
  local steps t
  steps=$(field steps) t=$(field t)
  sleep 0.2
  key s
  expect step
  holds "$(field steps) == $steps + 1"
  holds "$(field t) > $t && $(field t) < $t + 0.01"
}

restart() {
  key r
  expect restart
  holds "$(field t) == 0 && $(field steps) == 0 && $(field kinetic) == 0"
}

move_a_slider() {
  local edge x y
  edge=$(field edge)
  read -r x y <<<"$(point 'young \[Pa\]' 0.8)"
  press "$x" "$y"
  expect change
  holds "$(field edge) > 5 * $edge"
}

play_by_button() {
  local x y
  read -r x y <<<"$(point play)"
  press "$x" "$y"
  expect play
}

turn_and_zoom() {
  local yaw distance wait
  yaw=$(field yaw) distance=$(field distance)
  for wait in 0.12 0.5 2 8; do  # frames that see where the mouse is may be slow
    xdotool mousemove --window "$window" 400 80 sleep "$wait" mousedown 1 sleep "$wait"
    xdotool mousemove --window "$window" 500 90 sleep "$wait" mouseup 1 sleep "$wait" click 4 sleep "$wait"
    key space
    expect pause
    is "$(field yaw) < $yaw - 0.5 && $(field distance) < 0.95 * $distance" && return
    key space
    expect play
  done
  fail "not turned and zoomed"
}

# Where the driver is Mesa's in software, which has OpenGL 4.5, and on all cards of the last ten years.
take_to_the_device() {
  local x y
  read -r x y <<<"$(point 'on the device that draws' 0.1)"
  press "$x" "$y"
  expect change
  [[ $(field device) == gpu ]] || fail "not on the device"
  key space
  expect play
  drag_the_body
  key space
  expect pause
  [[ $(field status) == ok ]] || fail "failed on the device"
  read -r x y <<<"$(point 'on the device that draws' 0.1)"
  press "$x" "$y"
  expect change
  [[ $(field device) == cpu ]] || fail "not back from the device"
}

fail_and_restart() {
  local x y
  read -r x y <<<"$(point 'safe step' 0.1)"
  press "$x" "$y"
  expect change
  read -r x y <<<"$(point 'dt \[s\]' 0.97)"
  press "$x" "$y"
  expect change
  holds "$(field dt) > 0.02"
  key space
  expect play
  read -r x y <<<"$body"
  xdotool mousemove --window "$window" "$x" "$y" sleep 0.1 mousedown 1  # a touch wakes the instability
  expect failure
  xdotool mouseup 1
  [[ $(field status) == non_finite && $(field playing) == false ]] || fail "no failure"
  key r
  expect restart
  [[ $(field status) == ok ]] || fail "not restarted"
}

resize() {
  xdotool windowsize "$window" 1000 700
  expect resize
  [[ $(field width) == 1000 && $(field height) == 700 ]] || fail "not resized"
}

close() {
  key ctrl+q
  expect close
  wait "$view" || fail "exit status $?"
  view=
}

start
drag_the_body
pause_and_step
restart
move_a_slider
play_by_button
turn_and_zoom
take_to_the_device
resize
fail_and_restart
close
echo "dragged, paused, stepped, restarted, slid, played, turned, stepped on the device, resized, failed, closed"
