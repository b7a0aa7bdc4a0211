#pragma once

/// Before a loop whose iterations do not depend on each other, whatever a compiler can prove.
#ifdef __clang__
#define MSS_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define MSS_INDEPENDENT _Pragma("GCC ivdep")
#endif
