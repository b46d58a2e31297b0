// Takes the page of a folder into the program: UNLATCH_EMBED_PAGE(symbol) at file scope, then
// UNLATCH_EMBEDDED_PAGE(symbol). unlatch_add_page gives the file; without Node.js there is none, and the page is empty.
#pragma once

#include <cstddef>
#include <string_view>

#ifdef UNLATCH_PAGE
// The assembler reads the file; a compiler would need half a minute for it as an array.
#define UNLATCH_EMBED_PAGE(symbol)                                                                          \
  asm("  .section .rodata\n  .global " #symbol ", " #symbol "_end\n" #symbol ":\n  .incbin \"" UNLATCH_PAGE \
      "\"\n" #symbol "_end:\n  .byte 0\n  .text\n");                                                        \
  extern "C" const char symbol[], symbol##_end[]
#define UNLATCH_EMBEDDED_PAGE(symbol) std::string_view(symbol, static_cast<std::size_t>(symbol##_end - (symbol)))
#else
#define UNLATCH_EMBED_PAGE(symbol) static_assert(true)
#define UNLATCH_EMBEDDED_PAGE(symbol) std::string_view()
#endif
