// Takes a file into the program as it is: UNLATCH_EMBED(symbol, "path") at file scope, then UNLATCH_EMBEDDED(symbol).
#pragma once

#include <cstddef>
#include <string_view>

// The assembler reads the file.
#define UNLATCH_EMBED(symbol, path)                                                                                \
  asm("  .section .rodata\n  .global " #symbol ", " #symbol "_end\n" #symbol ":\n  .incbin \"" path "\"\n" #symbol \
      "_end:\n  .byte 0\n  .text\n");                                                                              \
  extern "C" const char symbol[], symbol##_end[]

#define UNLATCH_EMBEDDED(symbol) std::string_view(symbol, static_cast<std::size_t>(symbol##_end - (symbol)))
