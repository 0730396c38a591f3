#!/usr/bin/env bash
# A window under Xvfb, driven as a user would: a body is pulled, the window made tiny and large again,
# a key pressed. usage: window.sh FOLDER SECONDS X Y PROGRAM ARGUMENT...; exit code 77: no Xvfb. With HOLD=KEYS
# each of these keys is held down for so long that it repeats, and nothing else is done. Standard output is the
# program's.
set -u
folder=$1 seconds=$2 x=$3 y=$4
shift 4
command -v Xvfb >/dev/null && command -v xdotool >/dev/null || exit 77
exec 5<>"$folder/display"
Xvfb -displayfd 5 -screen 0 800x600x24 -nolisten tcp >"$folder/xvfb.log" 2>&1 5>&5 &
server=$!
trap 'kill $server 2>/dev/null' EXIT
for _ in $(seq 100); do
  number=$(tr -d '\n' <"$folder/display")
  [ -n "$number" ] && break
  kill -0 $server 2>/dev/null || exit 77
  sleep 0.05
done
[ -n "$number" ] || exit 77
export DISPLAY=:$number
"$@" --seconds "$seconds" 5>&- &
program=$!
window=$(timeout 20 xdotool search --sync --onlyvisible --name "tremolo view" 2>/dev/null | head -1)
if [ -n "$window" ]; then
  sleep 1
  xdotool mousemove "$x" "$y"
  sleep 0.5
  for key in ${HOLD:-}; do
    xdotool keydown "$key"
    sleep 1.2
    xdotool keyup "$key"
    sleep 0.2
  done
fi
if [ -n "$window" ] && [ -z "${HOLD:-}" ]; then
  xdotool mousedown 1
  sleep 1
  for _ in 1 2 3 4 5 6; do
    xdotool mousemove_relative -- 5 -6
    sleep 0.2
  done
  xdotool mouseup 1
  sleep 0.3
  xdotool windowsize "$window" 1 1
  sleep 0.5
  xdotool windowsize "$window" 640 480
  sleep 0.3
  xdotool key --window "$window" w
fi
wait $program
