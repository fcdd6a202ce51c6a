#define JINK_UNROLL _Pragma("GCC unroll 1")
#include "run/gradient.hpp"

namespace jink::inline JINK_LEVEL {
JINK_STEP(, Slopes)
}
