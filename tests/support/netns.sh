#!/bin/sh
# Runs a command in a separate network namespace, with only a loopback interface that supports multicast: tests disturb no other
# process and need no set-up. As root, or in a user namespace. Exit code 77 (ctest: skipped) where neither is allowed.
#   netns.sh COMMAND [ARGUMENT]...
inside='ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec "$@"'
for how in -n -rn; do
  if unshare "$how" true 2>/dev/null; then
    exec unshare "$how" sh -c "$inside" netns "$@"
  fi
done
echo "netns.sh: this machine allows no network namespaces (try as root); not run: $*" >&2
exit 77
