// As in motion_dual.cpp.
#define JINK_UNROLL _Pragma("GCC unroll 4")
#include "run/gradient.hpp"

namespace jink::inline JINK_LEVEL {
JINK_STEP(, Slopes)
}
