#!/usr/bin/env bash
# How punctual the hand is in a real window that is resized and minimised while every core is busy:
#     bench/viewer/window.sh build/examples/viewer/hfh_viewer [SECONDS [TERRAIN...]]
# Wants Xvfb, openbox and xdotool. Prints what the viewer prints at its end, and ends with 1 if more than a thousandth of the ticks
# came over 1 ms late though it had real-time priority.
set -euo pipefail
viewer=$1 seconds=${2:-60}
shift $(($# < 2 ? $# : 2))

work=$(mktemp -d)
children=()
finish() {
    for child in "${children[@]}"; do kill "$child" 2>/dev/null || true; done
    rm -rf "$work"
}
trap finish EXIT

Xvfb -displayfd 3 -screen 0 1400x900x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
children+=($!)
until [ -s "$work/display" ]; do sleep 0.1; done
DISPLAY=:$(cat "$work/display")
export DISPLAY
unset WAYLAND_DISPLAY
openbox 2>/dev/null &
children+=($!)
for ((core = 0; core < $(nproc); ++core)); do
    while :; do :; done &
    children+=($!)
done

"$viewer" --size 1280x720 "$@" >"$work/out" &
pid=$!
children+=($pid)
window=$(xdotool search --sync --onlyvisible --name "hfh viewer" | tail -1)
sleep 1
end=$((SECONDS + seconds))
while ((SECONDS < end)); do
    xdotool windowactivate --sync "$window" mousemove --window "$window" 400 300 mousedown 1
    for x in 400 450 500 550 600; do
        xdotool mousemove --window "$window" "$x" 320 click 4
        sleep 0.2
    done
    xdotool windowsize "$window" 700 500
    sleep 0.5
    xdotool windowminimize "$window"
    sleep 0.5
    xdotool mouseup 1 windowmap "$window" windowactivate --sync "$window" windowsize "$window" 1280 720 key Home
    sleep 0.5
done
xdotool mousedown 1
sleep 0.5
xdotool key Escape
wait "$pid"
cat "$work/out"
awk '/^haptic ticks/ { gsub(",", "", $3); ticks = $3; real = /SCHED_FIFO/ }
     /^late / { gsub(",", "", $2); late = $2 }
     END { printf "late ticks      %.3f in a thousand\n", 1000 * late / ticks; exit real && late > ticks / 1000 }' "$work/out"
