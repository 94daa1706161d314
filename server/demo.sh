#!/usr/bin/env bash
# The main job in one command: a finger in an exoskeleton (simulated) closes on a soft object that
# another process simulates. Shows it live, prints a summary, leaves pictures.
#
#   server/demo.sh [--seconds N] [--motion FILE] [--delay MS] [--serial] [--hand] [--page]
#                  [--output DIR] [--no-build] [--build DIR]
#
#   --seconds N    stop after N s (default 20; with --hand 26, its whole motion; with --page 600)
#   --motion FILE  moves the hand by a recording: CSV, columns time_s,q_o1_mcp_rad,q_o2_pip_rad
#   --delay MS     a second finger next to it, whose simulation is a round trip of MS ms away, and a
#                  picture of both forces, one on the other
#   --serial       through a serial link: a board's firmware and a model of its actuator, emulated
#                  on a pseudo-terminal (hw/README.md), instead of the simulated finger
#   --hand         a hand of five fingers on a moving palm (simulated) touches, strokes and grasps
#                  objects that MuJoCo simulates; makes a film, too
#   --page         prints an address at which a browser shows it, and takes a picture of that page;
#                  Ctrl-C ends it early
#   --output DIR   where summary, recording and pictures go (default: demo-output beside the README)
#   --no-build     does not install packages and does not build
#   --build DIR    uses the programs of this build folder (implies --no-build)
#
# Exit status: 0 contact was felt (by every motor) and free motion was free; else what went wrong is
# said.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

seconds=
motion=
delay=
serial=false
hand=false
page=false
output=$root/demo-output
build=true
programs=$root/build/release
while (($#)); do
  case "$1" in
    --seconds) seconds=${2:?--seconds needs a number}; shift 2 ;;
    --motion) motion=$(realpath -e -- "${2:?--motion needs a file}"); shift 2 ;;
    --delay) delay=${2:?--delay needs a number}; shift 2 ;;
    --serial) serial=true; shift ;;
    --hand) hand=true; shift ;;
    --page) page=true; shift ;;
    --output) output=${2:?--output needs a folder}; shift 2 ;;
    --no-build) build=false; shift ;;
    --build) build=false; programs=$(realpath -e -- "${2:?--build needs a folder}"); shift 2 ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) echo "demo.sh: unknown argument '$1' (see --help)" >&2; exit 2 ;;
  esac
done
default=20
if $hand; then default=26; fi
if $page; then default=600; fi
: "${seconds:=$default}"
if ! [[ $seconds =~ ^[0-9]{1,6}$ ]] || ((10#$seconds < 3)); then
  echo "demo.sh: --seconds must be a whole number, 3 to 999999" >&2
  exit 2
fi
seconds=$((10#$seconds))
if [[ -n $delay ]] && { ! [[ $delay =~ ^[0-9]{1,3}$ ]] || $serial; }; then
  echo "demo.sh: --delay must be a whole number of ms, 0 to 999, and not with --serial" >&2
  exit 2
fi
if $hand && { [[ -n $delay ]] || $serial; }; then
  echo "demo.sh: --hand is not with --delay or --serial" >&2
  exit 2
fi

targets=(hapticd hapticctl)
packages=(build demo)
if $hand; then
  targets+=(haptic-example-mujoco haptic_python)
  packages+=(hand)
else
  targets+=(haptic-example-soft-grasp)
fi
if $serial; then targets+=(haptic-board-emulator); fi
if [[ -n $delay ]]; then targets+=(haptic-relay); fi
if $page; then
  targets+=(haptic_page)
  packages+=(node)
fi
if $build; then
  sh "$root/docker/install-deps.sh" "${packages[@]}"
  (
    cd "$root"
    # Without the tests, whose packages the demo does not install; a folder that has them keeps
    # them.
    [[ -f build/release/build.ninja ]] ||
      cmake --preset release -DHAPTIC_BUILD_TESTS=OFF --log-level=WARNING >/dev/null
    [[ -z $delay ]] || cmake -DHAPTIC_BUILD_RELAY=ON --log-level=WARNING build/release >/dev/null
    if $hand || $page; then cmake --log-level=WARNING build/release >/dev/null; fi  # finds more now
    cmake --build --preset release --parallel "$(nproc)" --target "${targets[@]}"
  )
fi

program() {  # program NAME: where the build put it
  local found
  # Not the copies of an earlier build that the package tests install.
  found=$(find "$programs" -path '*/tests/package' -prune -o \
    -type f -name "$1" -perm -u+x -print -quit 2>/dev/null || true)
  [[ -n $found ]] || { echo "demo.sh: no program $1 in $programs; build first" >&2; return 1; }
  echo "$found"
}
hapticd=$(program hapticd)
hapticctl=$(program hapticctl)
grasp=("$(program "${targets[2]}")")
if $serial; then emulator=$(program haptic-board-emulator); fi
if [[ -n $delay ]]; then relay=$(program haptic-relay); fi
command -v gnuplot >/dev/null ||
  { echo "demo.sh: gnuplot is missing (docker/install-deps.sh demo)" >&2; exit 1; }

mkdir -p "$output"
output=$(cd "$output" && pwd)
folder=$(mktemp -d)
server=unix:$folder/socket
recording=$output/recording.csv
declare -A running=()  # name -> process id: what is ours to end

# shellcheck disable=SC2317  # called by the trap
finish() {
  local name
  for name in watch browser grasp palm hapticd emulator far_grasp relay far_hapticd; do
    if [[ -n ${running[$name]:-} ]]; then kill "${running[$name]}" 2>/dev/null || true; fi
  done
  for name in "${!running[@]}"; do wait "${running[$name]}" 2>/dev/null || true; done
  rm -rf "$folder"
}
trap finish EXIT
trap 'exit 130' INT TERM

give_up() {  # give_up MESSAGE LOG
  echo "demo.sh: $1" >&2
  tail -n 20 "$2" >&2 || true
  exit 1
}
alive() { kill -0 "${running[$1]}" 2>/dev/null; }
end() {  # end NAME: asks it to stop and returns its exit status
  local id=${running[$1]} status=0
  unset "running[$1]"
  kill -TERM "$id" 2>/dev/null || true
  wait "$id" || status=$?
  return "$status"
}

scene=$root/server/scenes/finger_soft_grasp.textproto
what="soft grasp with one finger"
if $hand; then
  scene=$root/server/scenes/hand_soft_grasp.textproto
  what="a hand touches, strokes and grasps"
  grasp+=("$root/client/mujoco/examples/hand.xml" --film "$output/hand.webm"
    --picture "$output/hand.png")
fi
# No person wears this device, and the host of a shared machine takes the processors away for tens
# of ms, again and again: what would be a fault of a real one is counted in the summary (lateness,
# skipped ticks).
more=record.compare_renderers=true
if $hand; then more='device[0].tracker={}'; fi
settings=(--set "$more" --set "record.file=\"$recording\"" --set record.overwrite=true
  --set loop.loop_late_fault.nanos=100000000 --set loop.late_bucket_full=1000000)
web=()
if $page; then
  . "$root/server/demo/page.sh"
  web=(--set 'server.web={ listen: "127.0.0.1:0" printed: "control" }')
fi
if $serial; then
  port=$folder/board
  # The board waits for longer than the loop may be late.
  "$emulator" --link "$port" --watchdog-ms 125 \
    --motion "${motion:-$root/server/scenes/motion/reach_and_grasp.csv}" \
    >/dev/null 2>"$folder/emulator.log" &
  running[emulator]=$!
  for _ in {1..100}; do
    [[ -L $port ]] && break
    alive emulator || give_up "the board's emulator did not start" "$folder/emulator.log"
    sleep 0.1
  done
  board="port: \"$port\" max_effort: 40 max_silence { nanos: 100000000 }"
  settings+=(--set "device[0].board={ $board }"
    # The observer must be told for a device what it knows of a simulated finger: the mass that
    # moves for certain beyond the load cell, the end of the rod (hw/emulator/rig.cpp).
    --set device[0].passivity.tank.inertia_kg=0.02
    --set device[0].passivity.observer.inertia_kg=0.02
    --set device[0].passivity.device_damping_n_s_per_m=0.5)
elif [[ -n $motion ]]; then
  wearer=simulated_finger
  if $hand; then wearer=simulated_hand; fi
  settings+=(--set "device[0].$wearer.motion_file=\"$motion\"")
fi

"$hapticd" --scene "$scene" --listen "$server" "${settings[@]}" "${web[@]}" \
  2>"$folder/hapticd.log" &
running[hapticd]=$!
for _ in {1..100}; do
  [[ -S $folder/socket ]] && break
  alive hapticd || give_up "hapticd did not start" "$folder/hapticd.log"
  sleep 0.1
done
[[ -S $folder/socket ]] || give_up "hapticd does not listen" "$folder/hapticd.log"
head -n 3 "$folder/hapticd.log"

if $hand; then  # a tracker says where the palm is, by the recording that the fingers follow
  PYTHONPATH=$(dirname "$(dirname "$hapticd")")/client/python /usr/bin/python3 \
    "$root/client/python/examples/palm.py" --server "$server" \
    "${motion:-$root/server/scenes/motion/hand_touch_stroke_grasp.csv}" >"$folder/palm.log" 2>&1 &
  running[palm]=$!
fi
"${grasp[@]}" --server "$server" >"$folder/grasp.log" 2>&1 &
running[grasp]=$!

if [[ -n $delay ]]; then . "$root/server/demo/far.sh"; fi
if $page; then show_page; fi

# Live in a terminal; elsewhere the summary has to do.
if [[ -t 1 ]]; then
  "$hapticctl" --server "$server" watch &
  running[watch]=$!
fi
end_at=$((SECONDS + seconds))
while ((SECONDS < end_at)); do
  alive hapticd || give_up "hapticd ended before its time" "$folder/hapticd.log"
  for name in grasp ${running[palm]:+palm} ${delay:+far_grasp far_hapticd relay}; do
    alive "$name" || give_up "$name ended before its time" "$folder/$name.log"
  done
  sleep 0.2
done
if [[ -n ${running[watch]:-} ]]; then
  end watch || true
  echo
fi
"$hapticctl" --server "$server" info | sed -n 's/.*; tick /  tick              /p' >"$folder/tick"
if $hand; then
  kill -TERM "${running[grasp]}"  # it closes its session, then it makes the film
  sleep 0.5
else
  end grasp || true  # a client that is told to go may say so in its status
fi
if [[ -n $delay ]]; then
  end far_grasp || true
  end relay || true
  end far_hapticd || give_up "the second hapticd did not stop cleanly" "$folder/far_hapticd.log"
fi
if $hand; then end palm || true; fi
end hapticd || give_up "hapticd did not stop cleanly" "$folder/hapticd.log"
if $hand; then
  echo "making the film, a minute or two"
  wait "${running[grasp]}" || give_up "the film could not be made" "$folder/grasp.log"
  unset "running[grasp]"
fi
if $serial; then
  end emulator || give_up "the board's emulator did not stop cleanly" "$folder/emulator.log"
  sed -n '$s/^/  board             /p' "$folder/emulator.log"
fi

# How the force was computed, as the scene in use says.
method=$("$hapticd" --scene "$scene" "${settings[@]}" --print-scene |
  grep -oE '\b(standard|null_space|subspace_linear|subspace_exact|per_contact)\b' | head -n 1)

status=0
{
  if $serial; then echo "soft grasp over a serial link to an emulated board"; fi
  echo "$what, ${motion:+moved by $(basename -- "$motion"), }method $method"
  awk -f "$root/server/demo/summary.awk" -v stretches="$folder/contact" "$recording"
  if [[ -n $delay ]]; then
    awk -v ms="$delay" -v curves="$folder/curves.csv" -f "$root/server/demo/delay.awk" \
      "$recording" "$output/recording-delayed.csv"
  fi
} >"$output/summary.txt" || status=$?
cat "$output/summary.txt"
cat "$folder/tick"
sed -n 's/^\(soft grasp\|MuJoCo\): /  client            /p' "$folder/grasp.log"

# About 4000 points per curve: more than the picture can show, and the SVG stays small.
if [[ ! -s $folder/contact ]]; then echo "-1 -1" >"$folder/contact"; fi
tr ' ' ',' <"$folder/contact" >"$folder/contact.csv"
rows=$(wc -l <"$recording")
awk -v every=$((rows / 4000 + 1)) 'NR == 1 || NR % every == 0' "$recording" >"$folder/figure.csv"
heading="hapticd: $what"
if [[ -n $motion ]]; then heading+=", moved by $(basename -- "$motion" | sed 's/_/\\\\_/g')"; fi
picture=soft-grasp
figure=$root/server/demo/figure.gp
if $hand; then picture=hand-forces figure=$root/server/demo/hand.gp; fi
gnuplot -e "data='$folder/figure.csv'; contact='$folder/contact.csv'; output='$output/$picture'" \
  -e "method='$method'; heading=\"$heading\"" "$figure" ||
  give_up "gnuplot could not draw the figure" /dev/null
echo "  pictures          $output/$picture.png, .svg; every tick: $recording"
if $page; then page_summary; fi
if $hand; then echo "  film              $output/hand.webm; strongest grasp: $output/hand.png"; fi

if [[ -s $folder/curves.csv ]]; then
  gnuplot -e "curves='$folder/curves.csv'; contact='$folder/contact.csv'; ms=$delay" \
    -e "output='$output/delay'" "$root/server/demo/delay.gp" ||
    give_up "gnuplot could not draw the delay" /dev/null
  echo "  pictures          $output/delay.png, .svg: the force here and $delay ms away"
fi

if $hand && ! grep -q ' accepted, 0 refused$' "$folder/grasp.log"; then status=8; fi
((status == 0)) || echo "demo.sh: not as promised (see the summary)" >&2
exit "$status"
