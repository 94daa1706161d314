#!/bin/sh
# The list of Debian packages that hapticd needs; no other file installs any.
#
#   docker/install-deps.sh [--list] [group...]      default: build test
#
# Groups: runtime     what the installed programs load
#         build       what compiles them
#         demo        what server/demo.sh needs in addition to build
#         hand        what server/demo.sh --hand needs in addition to build and demo
#         test        what tests/run.sh needs in addition to build
#         report      what draws the figures of the study
#         node        npm, which builds the JavaScript client and the page, and fetches buf
#         browser     the browser of the page's tests
#         firmware    the board's side
#         kernel      what tests/hostile/kernel.sh boots Debian's kernel with
#         containers  building and running images
# Installs missing packages only; if none is missing it needs neither network nor root. "a|b" means:
# a, or b if the distribution calls it so. Debian 12 has all of it; Ubuntu 24.04 the groups runtime,
# build and demo, with which the product builds and the demo runs there.
set -eu

packages() {
  case "$1" in
    runtime) echo "libgrpc++1.51|libgrpc++1.51t64 libprotobuf32|libprotobuf32t64" \
                  "libspdlog1.10|libspdlog1.12" "libssl3|libssl3t64" \
                  "libserialport0|libserialport0t64" "libsystemd0" "libseccomp2" ;;
    build) echo "g++ cmake ninja-build pkg-config libeigen3-dev libgrpc++-dev libprotobuf-dev" \
                "protobuf-compiler protobuf-compiler-grpc libspdlog-dev libcli11-dev" \
                "nlohmann-json3-dev libssl-dev libasio-dev libserialport-dev" \
                "libsystemd-dev libboost-dev libseccomp-dev python3-protobuf python3-cffi" \
                "dpkg-dev file help2man" ;;
    demo) echo "gnuplot-nox" ;;
    hand) echo "libmujoco-dev libegl-dev libgl1-mesa-dri ffmpeg" ;;
    test) echo "libgtest-dev libgmock-dev clang-format clang-tidy gnuplot-nox spin" \
                "liborocos-kdl-dev clang python3-grpcio python3-cryptography tshark openssl" \
                "python3-pip python3-setuptools python3-wheel" \
                "prometheus systemd mypy lintian haproxy libmujoco-dev libegl-dev" \
                "libgl1-mesa-dri ffmpeg avahi-daemon avahi-utils dbus-daemon" \
                "mono-mcs mono-runtime libmono-system-net-http4.0-cil" ;;
    report) echo "gnuplot-nox" ;;
    node) echo "nodejs npm" ;;
    browser) echo "chromium fonts-dejavu-core" ;;
    firmware) echo "gcc-arm-none-eabi" ;;
    kernel) echo "qemu-system-x86 cpio" ;;
    # An engine that needs neither daemon nor registry; docker/test.sh uses Docker if it runs.
    containers) echo "podman podman-compose runc netavark aardvark-dns iptables debootstrap" \
                     "dpkg-dev python3" ;;
    *)
      echo "install-deps.sh: no group '$1' (see --help)" >&2
      return 2
      ;;
  esac
}

fail() {
  echo "install-deps.sh: $*" >&2
  exit 1
}

installed() {  # installed NAME
  # Other builds of nodejs contain npm, and conflict with Debian's package of it.
  if [ "$1" = npm ] && [ -x /usr/bin/npm ] && installed nodejs; then return 0; fi
  status=$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null) || return 1
  [ "$status" = installed ]
}

one_installed() {  # one_installed "a|b"
  for name in $(echo "$1" | tr '|' ' '); do
    if installed "$name"; then return 0; fi
  done
  return 1
}

known() {  # known NAME: can apt install it?
  apt-cache --quiet policy "$1" 2>/dev/null | grep -q 'Candidate: [^(]'
}

first_known() {  # first_known "a|b"
  for name in $(echo "$1" | tr '|' ' '); do
    if known "$name"; then
      echo "$name"
      return 0
    fi
  done
  return 1
}

list_only=false
groups=
for argument in "$@"; do
  case "$argument" in
    --list) list_only=true ;;
    -h | --help) sed -n '2,${/^#/!q;s/^# \{0,1\}//p}' "$0"; exit 0 ;;
    *) groups="$groups $argument" ;;
  esac
done

wanted=
for group in ${groups:-build test}; do
  names=$(packages "$group") || exit 2
  wanted="$wanted $names"
done
if $list_only; then
  for entry in $wanted; do echo "$entry"; done | sort -u
  exit 0
fi

if ! command -v dpkg-query >/dev/null 2>&1 || ! command -v apt-get >/dev/null 2>&1; then
  fail "this is not Debian or Ubuntu; install the counterparts of:$wanted"
fi

missing=
for entry in $wanted; do
  one_installed "$entry" || missing="$missing $entry"
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null 2>&1 ||
    fail "missing:$missing - and you are neither root nor have sudo to install them"
  as_root=sudo
fi
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get -qq -o Dpkg::Use-Pty=0 -o Acquire::Retries=3 "$@"
}

resolve() {  # sets `chosen`, or `unknown` to the first entry that apt does not know
  chosen=
  unknown=
  for entry in $missing; do
    if name=$(first_known "$entry"); then
      chosen="$chosen $name"
    else
      unknown=$entry
      return 1
    fi
  done
}

echo "install-deps.sh: installing$missing" >&2
# The package lists are fetched only if the present ones are not enough.
# shellcheck disable=SC2086
if ! { resolve && apt install -y --no-install-recommends $chosen; }; then
  apt update || fail "could not fetch the package lists; is there a network? Missing:$missing"
  resolve || fail "the distribution has no package '$unknown' (Debian 12 has it)"
  apt install -y --no-install-recommends $chosen ||
    fail "apt-get could not install:$chosen"
fi
