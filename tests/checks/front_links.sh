#!/bin/sh
# hapticd-front contains no code of devices, scenes or the owner, and none of core: of core it has
# value types, whose functions are inline.
#
#   front_links.sh PROGRAM
set -u
program=${1:?a program}
[ -x "$program" ] || exit 2
found=$(readelf -d "$program" | grep -E 'NEEDED.*libserialport'
  nm -C "$program" | grep -E ' [TtWV] haptic::hw::| [Tt] haptic::core::' | grep -v '\[clone'
  nm -C "$program" | grep -E ' [TtWV] haptic::server::(load_scene|parse_scene|Owner::|Loop::)')
[ -z "$found" ] && exit 0
echo "$program has what the front must not know:"
echo "$found" | head -n 10
exit 1
