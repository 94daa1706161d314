#!/bin/sh
# A scene loads; the output of --print-scene loads too, and prints the same again.
#
#   scene_round_trip.sh HAPTICD SCENE SCRATCH-FOLDER
set -eu
hapticd=$1
scene=$2
mkdir -p "$3"
# Named after the scene, so that two scenes of one run use different files.
first="$3/$(basename "$scene" .textproto).first.textproto"
second="$3/$(basename "$scene" .textproto).second.textproto"

"$hapticd" --scene "$scene" --check-scene
"$hapticd" --scene "$scene" --print-scene >"$first"
"$hapticd" --scene "$first" --check-scene
"$hapticd" --scene "$first" --print-scene >"$second"
diff -u "$first" "$second"
