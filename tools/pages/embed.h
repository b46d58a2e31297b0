// Files inside of the program: UNLATCH_EMBED_FILE(symbol, "path") at file scope, then UNLATCH_EMBEDDED_FILE(symbol). Of
// the page of a folder UNLATCH_EMBED_PAGE(symbol), then UNLATCH_EMBEDDED_PAGE(symbol): unlatch_add_page gives the file;
// without Node.js there is none, and the page is empty.
#pragma once

#include <cstddef>
#include <string_view>

// The assembler reads the file; a compiler would need half a minute for a page as an array.
#define UNLATCH_EMBED_FILE(symbol, path)                                                                           \
  asm("  .section .rodata\n  .global " #symbol ", " #symbol "_end\n" #symbol ":\n  .incbin \"" path "\"\n" #symbol \
      "_end:\n  .byte 0\n  .text\n");                                                                              \
  extern "C" const char symbol[], symbol##_end[]
#define UNLATCH_EMBEDDED_FILE(symbol) std::string_view(symbol, static_cast<std::size_t>(symbol##_end - (symbol)))

#ifdef UNLATCH_PAGE
#define UNLATCH_EMBED_PAGE(symbol) UNLATCH_EMBED_FILE(symbol, UNLATCH_PAGE)
#define UNLATCH_EMBEDDED_PAGE(symbol) UNLATCH_EMBEDDED_FILE(symbol)
#else
#define UNLATCH_EMBED_PAGE(symbol) static_assert(true)
#define UNLATCH_EMBEDDED_PAGE(symbol) std::string_view()
#endif
