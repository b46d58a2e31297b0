#!/usr/bin/env bash
# install_test.sh BUILD SCRATCH CXX: installs the kernel of a finished build, builds a project that finds it with
# find_package(unlatch), and runs that. SCRATCH is emptied first.
set -euo pipefail
build=$1 scratch=$2 compiler=$3
source=$(cd "$(dirname "$0")" && pwd)
rm -rf "$scratch"
cmake --install "$build" --prefix "$scratch/prefix" --component kernel
# The prefix may be moved before its use.
mv "$scratch/prefix" "$scratch/moved"
if grep -rn "$(cd "$source/../.." && pwd)" "$scratch/moved" --include='*.cmake'; then
  echo "the installed package names the source folder" >&2
  exit 1
fi
cmake -S "$source" -B "$scratch/consumer" -DCMAKE_PREFIX_PATH="$scratch/moved" -DCMAKE_CXX_COMPILER="$compiler" \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS="-Wall -Wextra -Werror"
cmake --build "$scratch/consumer"
"$scratch/consumer/consumer"
