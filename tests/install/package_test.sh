#!/usr/bin/env bash
# package_test.sh BUILD SOURCE SCRATCH: makes the packages of a finished build twice with tools/package and compares the bytes, checks them with lintian,
# installs them with dpkg in a copy of this system that cannot see the repository, runs the tour of README.md and more there, and removes
# them. The copy is a layer over the system's files in a mount namespace of its own, so this machine stays as it is. SCRATCH is emptied first.
# Exit code 77 (ctest: skipped) where a program is missing or no such layer is allowed.
set -euo pipefail

# Below: inside the copy, in /packages.
inside() {
  local source=$1 build=$2 scenarios=/usr/share/unlatch/scenarios wanted
  wanted=$(cat wanted-hash)
  fail() { echo "package_test.sh: $*" >&2; exit 1; }
  list_ours() { find /usr /etc /lib /bin /sbin /opt /var/lib /var/cache -iname '*unlatch*' 2>/dev/null | sort; }
  list_packages() { for file in /packages/*.deb; do dpkg-deb -f "$file" Package; done; }
  [ ! -e "$source/CMakeLists.txt" ] || fail "the copy sees the repository"
  ! command -v unlatch || fail "unlatch is here before it is installed"
  list_ours >before

  dpkg -i ./*.deb
  [ "$(command -v unlatch)" = /usr/bin/unlatch ] || fail "unlatch is not in the path"
  [ "$(unlatch --version)" = "unlatch $(cat wanted-version)" ] || fail "unlatch --version says $(unlatch --version)"

  [ -s /usr/share/doc/unlatch-scenarios/html/index.html ] || fail "the pages for a browser are missing"
  # shellcheck disable=SC2046
  dpkg -L $(list_packages) | sort -u | while IFS= read -r file; do if [ -f "$file" ]; then echo "$file"; fi; done >files
  ! xargs -d '\n' grep -lF -e "$source/" -e "$build/" <files || fail "these files name the repository's folder"

  echo "== the tour of README.md"
  mkdir /tmp/tour /tmp/own && cd /tmp/tour
  bash -euxo pipefail /packages/tour.sh
  for made in first.html first.csv; do [ -s $made ] || fail "the tour left no $made"; done

  echo "== a scenario of the package: the bits of the build folder, then a replay"
  cd /tmp/own
  unlatch check $scenarios/boosters/reference.yaml
  unlatch run $scenarios/boosters/reference.yaml --log run.log --json run.json
  unlatch replay run.log
  [ "$(python3 /packages/read_hash.py run.json)" = "$wanted" ] || fail "the installed program has other bits than that of the build folder"
  unlatch export $scenarios/boosters/reference.yaml --fmu boosters.fmu
  [ -s boosters.fmu ] || fail "no FMU was written"
  # The modules that a program or the library loads when it needs them: meshes, import, transports.
  unlatch check $scenarios/interstage/duct.yaml >/dev/null
  printf '%s' '<robot name="pair"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>' >pair.urdf
  unlatch import pair.urdf --out pair.yaml
  unlatch check pair.yaml
  unlatch hil $scenarios/boosters/scenario.yaml --transport udp --udp 127.0.0.1:17671 --pace lockstep --until 0.2 --set flight_software.timeout=30 >/dev/null &
  unlatch-fsw --transport udp --udp 127.0.0.1:17671 >/dev/null
  wait $!

  man --where unlatch-hil >/dev/null 2>&1 || [ -s /usr/share/man/man1/unlatch-hil.1.gz ] || fail "no manual page"

  echo "== Python"
  cat >own.py <<'END'
import importlib.metadata
import sys
import unlatch
assert unlatch.__file__.startswith(sys.argv[1]), unlatch.__file__
assert importlib.metadata.version("unlatch") and importlib.metadata.requires("unlatch") == ["numpy"]
with unlatch.load("/usr/share/unlatch/scenarios/interstage/duct.yaml", judge=True) as sim:  # the clearance of a mesh is judged
    sim.run(until=0.01)
with unlatch.load("/usr/share/unlatch/scenarios/boosters/reference.yaml") as sim:
    sim.run(until=0.1)
    print(sim.hash)
END
  [ "$(/usr/bin/python3 own.py /usr/lib/python3/dist-packages/)" = "$(cat /packages/wanted-python)" ] || fail "the Python package has other bits"
  mkdir wheel && /usr/bin/python3 -m zipfile -e /packages/unlatch-*.whl wheel

  echo "== C and C++"
  cat >own.c <<'END'
#include <stdio.h>
#include <unlatch.h>
int main(void) {
  unlatch_simulation* sim;
  if (unlatch_load("/usr/share/unlatch/scenarios/boosters/reference.yaml", NULL, &sim) < 0) return puts(unlatch_get_error(0)->text), 1;
  if (unlatch_step(sim) < 0) return puts(unlatch_get_error(0)->text), 1;
  puts("stepped");
  unlatch_close(sim);
  return 0;
}
END
  # shellcheck disable=SC2046
  cc -std=c99 -Wall -Wextra -Werror own.c $(pkg-config --cflags --libs unlatch) -o own
  [ "$(./own)" = stepped ] || fail "the C program did not step"
  cmake -S /packages/consumer -B consumer -DCMAKE_BUILD_TYPE=Release >/dev/null
  cmake --build consumer
  ./consumer/consumer

  echo "== sources for other people's stacks, copied from the package, with the tests' stand-ins of their interfaces"
  local bridge=/usr/share/unlatch/bridge copied stack
  for stack in cfs fprime ros2; do
    copied=/tmp/own/$stack
    mkdir "$copied"
    cp $bridge/participant/participant.[ch] $bridge/schema/unlatch_wire.h $bridge/schema/unlatch_frame.h "$copied"
    find $bridge/stacks/$stack -type f -exec cp {} "$copied" \;
    cc -std=c99 -Wall -Wextra -Werror -c "$copied/participant.c" -o "$copied/participant.o"
  done
  cc -std=c99 -Wall -Wextra -Werror -I/packages/stacks/cfs -c cfs/unlatch_io.c -o cfs/unlatch_io.o
  c++ -std=c++17 -Wall -Wextra -Werror -I/packages/stacks/fprime -c fprime/UnlatchSim.cpp -o fprime/UnlatchSim.o
  c++ -std=c++17 -Wall -Wextra -Werror -I/packages/stacks/ros2 -c ros2/unlatch_node.cpp -o ros2/unlatch_node.o
  [ -s ros2/package.xml ] && [ -s $bridge/schema/unlatch.idl ] && [ -s $bridge/stacks/unlatch_sfun.c ] || fail "sources of stacks are missing"

  echo "== the service"
  local unit=/lib/systemd/system/unlatch-bench@.service
  if command -v systemd-analyze >/dev/null; then
    cp $unit "unlatch-bench@boosters.service"
    SYSTEMD_UNIT_PATH=$PWD: systemd-analyze verify --man=no "$PWD/unlatch-bench@boosters.service" 2>verified || { cat verified >&2; fail "the unit is not valid"; }
    # Other units of the machine may have their own mistakes.
    ! grep unlatch verified || fail "the unit has mistakes"
  fi
  mkdir service
  # Its two commands, as systemd reads them, with the settings of the example over the transport that needs no second process.
  sed -n 's/^ExecStartPre=//p; s/^ExecStart=//p' $unit | sed 's/\$\$/$/g; s/%%/%/g' >service/commands
  [ "$(wc -l <service/commands)" = 2 ] || fail "the unit has other commands than two"
  (
    set -a
    SCENARIO='' OPTIONS=''
    # As systemd reads it: to the end of the line.
    while IFS='=' read -r name value; do case "$name" in SCENARIO | OPTIONS) printf -v "$name" %s "$value" ;; esac; done </usr/share/doc/unlatch/examples/boosters.env
    [ -f "$SCENARIO" ] || fail "the example's scenario '$SCENARIO' is not installed"
    OPTIONS="${OPTIONS/--transport dds/--transport inproc} --until 0.2 --overruns slip --set flight_software.timeout=30"  # a stalled machine
    cd service
    while IFS= read -r command; do bash -c "$command" </dev/null; done <commands
  )
  unlatch replay service/run-*.log
  [ -s "$(echo service/run-*.json)" ] || fail "the service wrote no result"

  echo "== removal"
  # shellcheck disable=SC2046
  dpkg --purge $(list_packages)
  ! [ -e /usr/bin/unlatch ] || fail "unlatch is still here"
  ! /usr/bin/python3 own.py /usr/lib/python3 2>/dev/null || fail "the Python package is still here"
  list_ours >/packages/after
  diff /packages/before /packages/after || fail "the packages left files behind"

  echo "== the wheel, without any package"
  PYTHONPATH=wheel XDG_CACHE_HOME=/tmp /usr/bin/python3 - <<'END'
import pathlib
import unlatch
assert "/wheel/" in unlatch.__file__, unlatch.__file__
pathlib.Path("lid.yaml").write_text("""unlatch: 1
name: lid
step: {dt: 1 ms, until: 1 s}
bodies: {lid: {mass: 2 kg, inertia: [0.02, 0.02, 0.04], velocity: [0, 0, 1]}}
""")
with unlatch.load("lid.yaml") as sim:
    sim.run(until=0.5)
    assert abs(sim.bodies["lid"].position[2] - 0.5) < 1e-9, sim.bodies["lid"].position
END
  echo "all is well"
}

if [ "${1:-}" = inside ]; then
  cd /packages
  inside "$2" "$3"
  exit
fi

build=$1 source=$(cd "$2" && pwd) scratch=$3
for program in lintian ip doxygen mkdocs dpkg-deb dpkg-shlibdeps strip pkg-config git python3; do
  command -v "$program" >/dev/null || { echo "package_test.sh: $program is missing (tools/setup long); not run" >&2; exit 77; }
done
# As root: dpkg writes files of root.
layer='set -e; mount -t tmpfs none "$0" && mkdir "$0/up" "$0/work" "$0/root" && mount -t overlay overlay -o "lowerdir=/,upperdir=$0/up,workdir=$0/work" "$0/root"'
rm -rf "$scratch"
mkdir -p "$scratch/layer" "$scratch/packages" "$scratch/again"
if [ "$(id -u)" -ne 0 ] || ! unshare -m sh -c "$layer" "$scratch/layer"; then
  echo "package_test.sh: no layer over this machine's files is allowed (try as root); not run" >&2
  exit 77
fi

"$source/tools/docs" "$scratch/site" >/dev/null
export UNLATCH_BUILD=$build UNLATCH_SITE=$scratch/site
"$source/tools/package" "$scratch/packages"
"$source/tools/package" "$scratch/again" >/dev/null
for file in "$scratch"/packages/*; do
  cmp "$file" "$scratch/again/${file##*/}"  # the same bytes
done
[ "$(find "$scratch/packages" -name '*.deb' | wc -l)" -ge 5 ]
lintian --allow-root --fail-on error,warning "$scratch"/packages/*.deb

cd "$scratch/packages"
# The source archive has every file of the commit and no other.
tar -tzf unlatch-*.tar.gz | sed 's|^[^/]*/||' | grep -v '/$' | grep . | LC_ALL=C sort >"$scratch/archived"
git -C "$source" ls-tree -r --name-only HEAD | LC_ALL=C sort | diff - "$scratch/archived"
cat >read_hash.py <<'END'
import json
import sys
print(json.load(open(sys.argv[1], encoding="utf-8"))["hash"])
END
"$build/bin/unlatch" run "$source/hil/scenarios/boosters/reference.yaml" --json "$scratch/wanted.json" >/dev/null
python3 read_hash.py "$scratch/wanted.json" >wanted-hash
PYTHONPATH=$build/python /usr/bin/python3 -B -c 'import sys, unlatch
with unlatch.load(sys.argv[1]) as sim:
    sim.run(until=0.1)
    print(sim.hash)' "$source/hil/scenarios/boosters/reference.yaml" >wanted-python
sed -n 's/^project(unlatch VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt" >wanted-version
sed -n '/^```sh run$/,/^```$/p' "$source/README.md" | grep -v '^```' >tour.sh
grep -q 'unlatch replay' tour.sh
mkdir consumer
cp "$source/tests/install/CMakeLists.txt" "$source/tests/install/consumer.cc" consumer
cp "$source/tests/install/package_test.sh" .
cp -r "$source/tests/bridge/stacks" .

enter="$layer
  ip link set lo up
  root=\$0/root
  mkdir \$root/packages
  cp -r \"\$1\"/. \$root/packages
  mount --rbind /proc \$root/proc
  mount --rbind /dev \$root/dev
  mount -t tmpfs none \$root/tmp
  for hidden in \"\$2\" \"\$3\"; do if [ -d \"\$root\$hidden\" ]; then mount -t tmpfs none \"\$root\$hidden\"; fi; done
  exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 HOME=/tmp DEBIAN_FRONTEND=noninteractive chroot \$root bash /packages/package_test.sh inside \"\$2\" \"\$3\""
unshare -mn sh -c "$enter" "$scratch/layer" "$scratch/packages" "$source" "$build"
