# unlatch_add_to_flash(OUT SYMBOL FILE): appends to the text OUT C++ declarations of SYMBOL and SYMBOL_end, between which
# the bytes of FILE lie in the section .plans, aligned as a plan image must be.
function(unlatch_add_to_flash out symbol file)
  string(APPEND ${out} "asm(\".section .plans, \\\"a\\\"\\n .balign 64\\n .global ${symbol}, ${symbol}_end\\n\"\n"
    "    \"${symbol}: .incbin \\\"${file}\\\"\\n ${symbol}_end:\\n .text\");\n"
    "extern \"C\" const std::byte ${symbol}[], ${symbol}_end[];\n")
  set(${out} "${${out}}" PARENT_SCOPE)
endfunction()
