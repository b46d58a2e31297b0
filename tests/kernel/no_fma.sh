#!/bin/sh
# no_fma.sh LIBRARY [OBJDUMP]: fails, and names the function, if LIBRARY holds a fused multiply-add. Such an instruction
# rounds once where two would round twice, so that the same step gives other bits on another processor. x86-64, aarch64.
set -eu
library=$1
objdump=${2:-objdump}

listing=$(mktemp)
trap 'rm -f "$listing"' EXIT
"$objdump" --disassemble --demangle --no-show-raw-insn "$library" >"$listing"

awk -v library="$library" '
  /^[0-9a-f]+ <.*>:$/ { name = $0; sub(/^[0-9a-f]+ </, "", name); sub(/>:$/, "", name); functions++ }
  # "  1f:<tab>vfmadd213sd %xmm0,…": the mnemonic is the first word after the address.
  /^ +[0-9a-f]+:/ && $2 ~ /^(v?fn?m(add|sub|addsub|subadd)[0-9a-z.]*|v4f.*madd.*|fml[as]l?[2bt]?|fn?m(ad|sb|la|ls)|vfn?m[as][.]f(32|64)|fcmla)$/ {
    if (!(name in seen)) print library ": fused multiply-add in " name ": " $2
    seen[name] = 1
    found++
  }
  END {
    if (!functions) { print library ": no machine code found (an archive of LTO objects?)"; exit 2 }
    if (found) { print library ": " found " fused multiply-adds; compile with -ffp-contract=off and without the SLP vectoriser"; exit 1 }
    print library ": " functions " functions, no fused multiply-add"
  }' "$listing"
