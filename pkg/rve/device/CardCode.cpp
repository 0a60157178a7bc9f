// SPDX-License-Identifier: GPL-2.0-or-later
#include <pkg/rve/device/CardCode.hpp>

#ifdef TALIK_CARD_CODE
// the file that clang has made, as it is, and a zero after it
asm(".pushsection .rodata\n"
    "talikCardCode:\n"
    ".incbin \"" TALIK_CARD_CODE "\"\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const char talikCardCode[];
#endif

namespace talik {

#ifdef TALIK_CARD_CODE
const char* cardCode() { return talikCardCode[0] ? talikCardCode : nullptr; }
const char* cardCodeMissing() { return "the clang of the build did not compile them (its log says why); build Talik anew with Debian's clang."; }
#else
const char* cardCode() { return nullptr; }
const char* cardCodeMissing() { return "clang was missing; install Debian's package clang and build Talik anew."; }
#endif

} // namespace talik
