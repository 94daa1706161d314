# Chooses and calls the container engine of docker/test.sh, which sources this file. Sets `engine`
# and `base`; `compose` and the functions here call it. `scratch` is a folder of the caller.

# Docker if it does what the tests need, else podman; if neither does, prints why, and if none is
# installed the command that installs one.
choose_engine() { # choose_engine [NAME]
  local candidate why=() installed=false
  for candidate in ${1:-docker podman}; do
    if ! command -v "$candidate" >/dev/null; then
      why+=("$candidate: not installed")
      continue
    fi
    installed=true
    if [[ $candidate == podman ]]; then configure_podman; fi
    engine=$candidate
    if probe >"$scratch/probe" 2>&1; then return 0; fi
    why+=("$candidate: $(tail -n 2 "$scratch/probe" | tr '\n' ' ')")
    tear_down >/dev/null 2>&1 || true
    engine=
  done
  printf 'no container engine works here:\n' >&2
  printf '  %s\n' "${why[@]}" >&2
  if ! $installed; then
    echo "to install podman: sudo sh $root/docker/install-deps.sh containers" >&2
  fi
  return 1
}

# Everything that the tests need from an engine, without hapticd: a failure here is the host's. Its
# last line is the reason.
probe() {
  local network=${project}_probe name=${project}_probe
  local ours=(--label "com.docker.compose.project=$project")
  "$engine" info || return 1
  compose version || { echo "there is no compose for it"; return 1; }
  base=$(base_image) || { echo "there is no base image and none can be made"; return 1; }
  "$engine" run --rm "${ours[@]}" "$base" apt-get -qq -o Acquire::Retries=3 update ||
    { echo "its containers reach no Debian mirror"; return 1; }
  "$engine" network create --internal "${ours[@]}" "$network" ||
    { echo "it makes no networks"; return 1; }
  "$engine" run --detach --name "$name" "${ours[@]}" --network "$network" --read-only --tmpfs /tmp \
    --cap-drop ALL --security-opt no-new-privileges --user 990:990 "$base" sleep 300 ||
    { echo "it runs no container without privileges"; return 1; }
  "$engine" exec "$name" getent hosts "$name" || { echo "its networks know no names"; return 1; }
  { "$engine" pause "$name" && "$engine" unpause "$name"; } || { echo "it cannot pause"; return 1; }
  { "$engine" network disconnect --force "$network" "$name" &&
    "$engine" network connect "$network" "$name"; } ||
    { echo "it cannot unplug a network"; return 1; }
  "$engine" rm --force "$name" && "$engine" network rm "$network"
}

# A host without cgroups version 2 or without systemd needs this configuration; elsewhere podman's
# own stays.
configure_podman() {
  [[ -z ${CONTAINERS_CONF:-} ]] || return 0
  if [[ -f /sys/fs/cgroup/cgroup.controllers && -d /run/systemd/system ]]; then return 0; fi
  cat >"$scratch/containers.conf" <<'CONF'
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
[containers]
default_ulimits = ["nofile=20000:20000", "nproc=4096:4096"]
CONF
  export CONTAINERS_CONF=$scratch/containers.conf
}

# Debian from a registry, or made here if none is reachable.
base_image() {
  local image=debian:bookworm-slim
  if "$engine" image inspect "$image" >/dev/null 2>&1 ||
    timeout 60 "$engine" pull --quiet "$image" >/dev/null 2>&1; then
    echo "$image"
    return 0
  fi
  sh "$root/docker/base-image.sh" "$engine" || return 1
  echo localhost/debian:bookworm
}

compose() {
  if [[ $engine == docker ]]; then
    docker compose -p "$project" -f "$root/docker/compose.yaml" "$@"
  else
    podman-compose -p "$project" -f "$root/docker/compose.yaml" "$@"
  fi
}

# container SERVICE: the id of the newest container of a service of this run.
container() {
  "$engine" ps --all --latest --quiet --filter "label=com.docker.compose.project=$project" \
    --filter "label=com.docker.compose.service=$1"
}

# Removes the containers and networks that this run made, by their label.
tear_down() {
  local ids
  ids=$("$engine" ps --all --quiet --filter "label=com.docker.compose.project=$project")
  # A paused container cannot be stopped.
  # shellcheck disable=SC2086
  if [[ -n $ids ]]; then
    "$engine" unpause $ids >/dev/null 2>&1 || true
    "$engine" rm --force --volumes $ids >/dev/null
  fi
  ids=$("$engine" network ls --quiet --filter "name=^${project}_")
  # shellcheck disable=SC2086
  if [[ -n $ids ]]; then "$engine" network rm $ids >/dev/null; fi
}

left_behind() {
  "$engine" ps --all --quiet --filter "label=com.docker.compose.project=$project"
  "$engine" network ls --quiet --filter "name=^${project}_"
  "$engine" volume ls --quiet --filter "label=com.docker.compose.project=$project"
}
