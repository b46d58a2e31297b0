#!/bin/sh
# no_fma_catches.sh NO_FMA OBJECT OBJDUMP: proves that the check can fail. OBJECT was compiled with fused multiply-adds.
set -u
output=$("$1" "$2" "$3")
status=$?
echo "$output"
[ "$status" -eq 1 ] || { echo "expected exit code 1, got $status"; exit 1; }
case $output in
  *"fused multiply-add in unlatch::test::calc_fused"*) ;;
  *) echo "expected the function to be named"; exit 1 ;;
esac
